"""The verb `noctule simulate`: one transient of a block under its testbench."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from circuits.catalogue import loaded
from circuits.errors import ParameterError
from circuits.measure.branch import waveform
from circuits.measure.measure import Reading
from circuits.measure.scope import TransientRecord, device_currents
from circuits.measure.unit import value_text
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import DEFAULT_RTOL, Result, simulate
from circuits.testbench import Testbench
from system.cli.beginning_output import told, told_lines
from system.cli.block_choice import choose_block
from system.cli.deadline import deadline_of
from system.cli.deck_measures import own_measures
from system.cli.measure_output import measured_document
from system.cli.output import plain, print_json, print_line, print_table, quantity_cell, working
from system.cli.simulate_verb import Simulate, check_options
from system.cli.study_verbs import Replay
from system.files.writing import replace_atomic, write_text_atomic
from system.options.block import Choice, describe_silicon, law_text, silicon_line
from system.options.cards import cards_lines, describe_cards
from system.options.target import deck_of
from system.plot import check_picture, draw_waveforms, save_picture, silicon_text
from system.spikes.file import check_spikes, write_spikes
from system.study.metrics.measure import measures_of

# loaded when asked for: labelled arrays are slow to import, and a transient must not wait for them
_COMMANDS = {
    "ac": "system.cli.small_signal:ac_command",
    "noise": "system.cli.noise:noise_command",
    "tran-noise": "system.cli.tran_noise:tran_noise_command",
}


def simulate_command(asked: Simulate) -> None:
    """Simulate a block, print its outcome, and write the waveforms and the picture that are asked for."""
    deadline_s = deadline_of(asked.deadline, asked.engine)
    check_options(asked)
    if asked.analysis == "dc" or deck_of(asked.block) is not None:
        if loaded("system.cli.deck:simulated_as_deck")(asked):
            return
        asked = loaded("system.cli.deck:with_own_spectrum")(asked)
    if asked.analysis != "tran":
        loaded(_COMMANDS[asked.analysis])(asked)
        return
    check_picture(asked.plot)
    viewed = asked.view is not None or asked.output is not None
    if viewed:
        loaded("system.cli.simulate_view:check_view")(asked)
    if asked.spikes is not None:
        check_spikes(asked.spikes)
    if asked.begin.begin == "at_rest" and asked.engine != "native":
        raise ParameterError(
            f"--at-rest: {asked.engine} leaves such a state by its rounding; only native stays there"
        )
    choice = choose_block(asked.block, asked.values, asked.silicon, asked.stimulus, asked.begin)
    check_watched(asked.spikes, choice)
    run = _engine(asked, deadline_s)
    own = own_measures(asked.block, asked.silicon, lambda: choice)
    measures = measures_of(choice, (*own, *asked.measure))
    with working(f"simulating {asked.block}"):
        result = run(choice.testbench(), choice.silicon)
        record = TransientRecord(result)
        engine = asked.engine if asked.verilog_a is None else f"{asked.engine}, on {asked.verilog_a}"
        document = _describe(choice, result, engine, [each.of(record) for each in measures])
    write_run(asked, choice, result)
    if viewed:
        loaded("system.cli.simulate_view:leave_view")(asked.block, choice, result, asked.view, asked.output)
    if asked.as_json:
        print_json(document)
    else:
        _print(choice, document)
        for line in told_lines(result):
            print_line(line)


def _engine(asked: Simulate, deadline_s: float) -> Callable[[Testbench, Silicon], Result]:
    """What runs the testbench: an engine, or the native one on models in Verilog-A."""
    if asked.verilog_a is None:
        return engine_named(asked.engine, asked.rtol, deadline_s)
    if asked.engine != "native":
        raise ParameterError(f"--verilog-a: of the native engine, not of {asked.engine}; leave one out")
    models = loaded("netlists.verilog_a.host.models:read_models")(Path(asked.verilog_a))
    run: Callable[..., Result] = loaded("netlists.verilog_a.host.engine:simulate")
    tolerance = {} if asked.rtol is None else {"rtol": asked.rtol}
    return lambda testbench, silicon: run(testbench, models, silicon, **tolerance)


def write_run(asked: Simulate | Replay, choice: Choice, result: Result) -> None:
    """Write the waveforms and the picture of a run that are asked for."""
    if asked.csv is not None:
        names = asked.current if isinstance(asked, Simulate) else ()
        write_text_atomic(asked.csv, _waveform_table(result, names))
    if asked.raw is not None:
        with replace_atomic(asked.raw) as temporary:
            loaded("netlists.ngspice.raw:write_raw")(result, temporary)
    if asked.spikes is not None:
        write_spikes(asked.spikes, result.spikes, float(result.time[-1]))
    shown = choice.block.plotted or tuple(result.spikes) or result.nodes[1:5]
    silicon = choice.silicon
    title = f"{choice.block.name}, {silicon_text(silicon.die, silicon.temperature_c)}{law_text(silicon)}"
    title += f", outcome: {choice.block.outcome(result)}"
    save_picture(asked.plot, lambda figure: draw_waveforms(result, shown, figure, title))


def check_watched(spikes: str | None, choice: Choice) -> None:
    """Raise `ParameterError` where a file of spikes is asked for and the testbench watches no node."""
    if spikes is not None and not choice.testbench().watch:
        raise ParameterError(f"--spikes: {choice.block.name} watches no node for them; write --csv")


def _waveform_table(result: Result, currents: Sequence[str] = ()) -> str:
    """Waveforms as CSV: `time_s`, `NODE_V` for every node, `NAME_A` for `currents`; a row a point.

    A node that stands for the current of an element is `i(ELEMENT)_A`.
    """
    text = io.StringIO()
    found = device_currents(result, currents)
    told = [waveform(result, node) for node in result.nodes]
    words = ["time_s", *(f"{t.name}_{t.unit}" for t in told), *(f"{n}_A" for n in found)]
    names = [f'"{word}"' if "," in word else word for word in words]
    table = np.column_stack([result.time, *(t.values for t in told), *found.values()])
    np.savetxt(text, table, fmt="%.12g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue()


def engine_named(name: str, rtol: float | None, deadline_s: float) -> Callable[[Testbench, Silicon], Result]:
    """Give the function that runs a testbench on silicon.

    Parameters
    ----------
    name : `native` or `ngspice`.
    rtol : relative tolerance of the native engine; None for its default.
    deadline_s : wall-clock time that a run in ngspice may take, s.

    Raises
    ------
    ParameterError
        A tolerance is given for ngspice.
    """
    if name == "native":
        tolerance = DEFAULT_RTOL if rtol is None else rtol
        return lambda testbench, silicon: simulate(testbench, silicon, rtol=tolerance)
    if rtol is not None:
        raise ParameterError(f"--rtol: {rtol:g}, only the native engine takes it; leave it out")
    # PySpice is slow to import, and the native engine must not wait for it
    run: Callable[..., Result] = loaded("netlists.foundry.engine:simulate")
    return partial(run, deadline_s=deadline_s)


def _describe(choice: Choice, result: Result, engine: str, readings: Sequence[Reading]) -> dict[str, Any]:
    return {
        "block": choice.block.name,
        **describe_silicon(choice.silicon),
        **describe_cards(choice.silicon, engine),
        "engine": engine,
        "stimuli": choice.stimuli,
        "outcome": choice.block.outcome(result),
        "spikes_s": _spikes(choice, result),
        **told(result),
        "measures": plain(choice.block.measured(result)),
        "measured": [measured_document(each) for each in readings],
        "steps": result.steps.accepted,
        "rejected_steps": result.steps.rejected,
        "iterations": result.steps.iterations,
    }


def _spikes(choice: Choice, result: Result) -> Any:
    """A list where one scalar port is watched, else lists by port."""
    watch = choice.testbench().watch
    if len(watch) == 1 and list(result.spikes) == list(watch):
        return result.spikes[watch[0]].tolist()
    return {port: times.tolist() for port, times in result.spikes.items()}


def _print(choice: Choice, document: dict[str, Any]) -> None:
    spikes = document["spikes_s"]
    trains = spikes if isinstance(spikes, dict) else {"spikes": spikes}
    rows = [("outcome", document["outcome"])]
    rows += [(port, " ".join(f"{t:.9g} s" for t in times) or "none") for port, times in trains.items()]
    rows += [(k, "not defined" if v is None else f"{v:.6g}") for k, v in document["measures"].items()]
    rows += [(m["name"], m["reason"] or value_text(m["value"], m["unit"])) for m in document["measured"]]
    rows.append(("steps", f"{document['steps']} ({document['rejected_steps']} rejected)"))
    where = f"{silicon_line(choice.silicon)}, {document['engine']}"
    title = f"{document['block']} at {where}"
    print_table(title, ("quantity", "value"), rows)
    print_stimuli(choice)
    for line in cards_lines(choice.silicon, document["engine"]):
        print_line(line)


def print_stimuli(choice: Choice) -> None:
    """Print the stimuli that the testbench of a block applied."""
    stimuli = (f"{s.name}={quantity_cell(choice.stimuli[s.name], s.unit)}" for s in choice.block.stimuli)
    print_line(f"stimuli: {', '.join(stimuli) or 'none'}")
