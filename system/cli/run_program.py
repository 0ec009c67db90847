"""The command `noctule run PROGRAM.toml`: a mapped network on a die, beside what was asked for."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from chips.rolls.chip import TEMPERATURE_STEP
from circuits.silicon.course import beginning_of, course_through
from circuits.silicon.silicon import Silicon
from circuits.units import parse_quantity
from system.cli.map_verb import RunProgram
from system.cli.nef_program import run_value_program, share_or_none
from system.cli.output import print_json, print_line, print_table, working
from system.mapping.chips import read_any_program
from system.mapping.picture import draw_mapped_run
from system.mapping.rolls.calibrate import calibrated
from system.mapping.rolls.mapped import Mapped
from system.mapping.run import MappedRun, check_channels, run_mapped
from system.notice import say
from system.options.block import describe_die, silicon_line
from system.options.temperature import COURSE, read_course, temperature_fields
from system.plot import check_picture, save_picture
from system.rolls.options import silicon_of
from system.spikes.file import check_spikes, write_spikes
from system.spikes.output import trains_of
from system.spikes.read import read_spikes
from system.system import DRAWN


def run_program(path: str, asked: RunProgram) -> None:
    """Run a program once, and print, draw and write the result."""
    check_picture(asked.plot)
    if asked.spikes is not None:
        check_spikes(asked.spikes)
    mapped = read_any_program(path)
    fields = temperature_fields(read_course(asked.temperature))
    silicon = _silicon(asked, beginning_of(fields["temperature_c"], fields.get(COURSE, ()), TEMPERATURE_STEP))
    if not isinstance(mapped, Mapped):
        run_value_program(path, asked, mapped, silicon)
        return
    duration = None if asked.duration is None else parse_quantity(asked.duration, "s", "duration")
    events = read_spikes(asked.input)
    check_channels(mapped.network, events, asked.input)
    followed = course_through(fields.get(COURSE, ()), TEMPERATURE_STEP)
    if asked.codes == "calibrated":
        with working("calibrating the weights on the die"):
            mapped = calibrated(mapped, silicon, asked.bias_kind)
    with working(f"running {path}"):
        run = run_mapped(
            mapped, events, silicon, duration, kind=asked.bias_kind,
            temperature=None if followed is None else followed.at,
        )  # fmt: skip
    title = f"{path}, {silicon_line(silicon)}, {asked.codes} codes"
    save_picture(asked.plot, partial(draw_mapped_run, mapped, run, title.replace("degC", "°C")))
    if asked.spikes is not None:
        trains = trains_of("neuron", mapped.network.neurons, run.chip.times, run.chip.neurons)
        write_spikes(asked.spikes, trains, max(run.duration, float(run.chip.times.max(initial=0.0))))
    if asked.as_json:
        print_json(_document(path, asked, silicon, mapped, run))
    else:
        _print(title, run)


def _silicon(asked: RunProgram, celsius: float) -> Silicon:
    """The silicon of the run: a drawn die unless one is named."""
    choice = replace(asked.silicon, temperature=f"{celsius}degC")
    return silicon_of(replace(choice, die=DRAWN) if asked.die is None else choice)


def _document(
    path: str, asked: RunProgram, silicon: Silicon, mapped: Mapped, run: MappedRun
) -> dict[str, Any]:
    return {
        "program": path,
        "chip": "rolls",
        **describe_die(silicon.die),
        "temperature_C": silicon.temperature_c,
        "bias_kind": asked.bias_kind,
        "codes": asked.codes,
        "begin_s": run.begin,
        "duration_s": run.duration,
        "populations": [
            {
                "name": p.name, "asked_Hz": run.rates["asked"][p.name],
                "expected_Hz": run.rates["expected"][p.name], "rate_Hz": run.rates["chip"][p.name],
                "trains_from_asked": run.from_asked.trains[p.name],
                "trains_from_expected": run.from_expected.trains[p.name],
            }
            for p in mapped.placed
        ],
        "outputs": [
            {"name": name, "from_asked": off, "from_expected": run.from_expected.outputs[name]}
            for name, off in run.from_asked.outputs.items()
        ],
        "events_lost": run.lost_in,
        "spikes_lost": run.lost_out,
        "events_later": run.later,
        "held": run.held,
        "cautions": run.cautions,
    }  # fmt: skip


def _print(title: str, run: MappedRun) -> None:
    rows = [
        (
            name, *(f"{run.rates[k][name]:.4g}" for k in ("asked", "expected", "chip")),
            f"{run.from_asked.trains[name]:.3g}", f"{run.from_expected.trains[name]:.3g}",
        )
        for name in run.rates["chip"]
    ]  # fmt: skip
    columns = ("population", "asked for:", "as mapped:", "on the die:", "to asked:", "to mapped:")
    print_table(
        f"{title}: mean rates (Hz) from {run.begin:g} to {run.duration:g} s, van Rossum distances",
        columns,
        rows,
    )
    outputs = [
        (name, share_or_none(off, 1), share_or_none(run.from_expected.outputs[name], 1))
        for name, off in run.from_asked.outputs.items()
    ]
    if outputs:
        print_table("outputs, rms over the largest value", ("output", "off asked:", "off mapped:"), outputs)
    print_line(f"events lost on the way in: {run.lost_in}, spikes on the way out: {run.lost_out}")
    if run.later:
        print_line(f"events not sent, for times after the end of the run: {run.later}")
    for caution in run.cautions:
        say(caution)
