"""Networks of values on the NEF chip at the command line: what `map`, `show` and `run` print of them."""

from __future__ import annotations

import math
from dataclasses import asdict
from functools import partial
from typing import Any

from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon
from circuits.units import parse_quantity
from system.cli.map_verb import RunProgram
from system.cli.output import print_json, print_line, print_table, working
from system.mapping.nef.mapped import MappedValues
from system.mapping.nef.picture import draw_value_run
from system.mapping.nef.run import ValueRun, read_values, run_values
from system.mapping.report import counted
from system.options.block import describe_die, silicon_line
from system.options.temperature import read_course
from system.plot import save_picture


def document_of_values(mapped: MappedValues) -> dict[str, Any]:
    """Give what map and show tell of a network of values by the names that JSON has for it."""
    placed = [p for (p,) in mapped.built.populations.values()]
    return {
        "chip": "nef",
        "neurons": mapped.built.network.neurons,
        "channels": mapped.network.channels,
        "ensembles": [
            {
                "name": p.ensemble.name,
                "first": p.first,
                "neurons": p.ensemble.neurons,
                "dimensions": p.ensemble.dimensions,
            }
            for p in placed
        ],
        "filters": int((mapped.built.net.goes >= 0).sum()),
        **counted(mapped.findings),
        "findings": [asdict(f) for f in mapped.findings],
    }


def size_of_values(mapped: MappedValues) -> str:
    """Say how much of the chip a network of values takes."""
    told = document_of_values(mapped)
    chip = mapped.built.where
    most = "" if chip is None else f" of {chip.chip.neurons}"
    size = f"{told['neurons']}{most} neurons, {told['filters']} filters"
    return f"{size}, {told['channels']} channels of inputs"


def share_or_none(share: float, digits: int) -> str:
    """Return how far an output is off as text; that there is none to compare with where it is NaN."""
    return "silent" if math.isnan(share) else f"{share:.{digits}%}"


def run_value_program(path: str, asked: RunProgram, mapped: MappedValues, silicon: Silicon) -> None:
    """Run a network of values on a die once, and print and draw the result.

    Raises `ParameterError` for spikes, or a temperature that changes.
    """
    if asked.spikes is not None:
        raise ParameterError("spikes: of populations alone; leave it out")
    if not isinstance(read_course(asked.temperature), float):
        raise ParameterError("temperature: a course, must be one; networks of values run at one")
    duration = None if asked.duration is None else parse_quantity(asked.duration, "s", "duration")
    rows = read_values(asked.input, mapped.network)
    with working(f"running {path}"):
        run = run_values(mapped, rows, silicon, duration, kind=asked.bias_kind, codes=asked.codes)
    title = f"{path}, {silicon_line(silicon)}, {asked.codes} codes"
    save_picture(asked.plot, partial(draw_value_run, run, title.replace("degC", "°C")))
    if asked.as_json:
        print_json(_document(path, asked, silicon, run))
    else:
        _print(title, run)


def _document(path: str, asked: RunProgram, silicon: Silicon, run: ValueRun) -> dict[str, Any]:
    return {
        "program": path,
        "chip": "nef",
        **describe_die(silicon.die),
        "temperature_C": silicon.temperature_c,
        "bias_kind": asked.bias_kind,
        "codes": asked.codes,
        "begin_s": run.begin,
        "duration_s": run.duration,
        "outputs": [
            {
                "name": name,
                "from_asked": run.from_asked[name],
                "from_ideal": run.from_ideal[name],
                "ideal_from_asked": run.ideal_from_asked[name],
            }
            for name in run.chip
        ],
        "spikes": run.counters["spikes"],
        "spikes_dropped": run.counters["dropped"],
        "values_clipped": run.counters["clipped"],
        "values_lost": run.counters["lost"],
        "rows_later": run.later,
    }


def _print(title: str, run: ValueRun) -> None:
    every = (run.from_asked, run.ideal_from_asked, run.from_ideal)
    rows = [(name, *(share_or_none(off[name], 2) for off in every)) for name in run.chip]
    columns = ("output", "die from asked:", "ideal from asked:", "die from ideal:")
    print_table(f"{title}: rms over the largest value, {run.begin:g} to {run.duration:g} s", columns, rows)
    c = run.counters
    print_line(
        f"{c['spikes']} spikes, {c['dropped']} dropped; {c['clipped']} values clipped by converters,"
        f" {c['lost']} lost"
    )
    if run.later:
        print_line(f"rows of inputs not used, for times after the end of the run: {run.later}")
