"""The verb `noctule replay STUDY --die K`: one sample of a study again, with waveforms and a picture."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.measure.measure import Reading
from circuits.measure.scope import TransientRecord
from circuits.measure.unit import value_text
from circuits.solver.lanes.simulate import simulate_as_many
from circuits.solver.transient import Result
from circuits.units import parse_quantity
from system.cli.beginning_output import told, told_lines
from system.cli.deadline import deadline_of
from system.cli.exit_status import DONE, NO
from system.cli.measure_output import measured_document
from system.cli.output import plain, print_json, print_line, print_table, quantity_cell, working
from system.cli.simulate import check_watched, engine_named, print_stimuli, write_run
from system.cli.simulate_view import leave_view
from system.cli.study_verbs import Replay
from system.cli.view import check_page, leave, this_command
from system.notice import say
from system.options.block import Choice, describe_die
from system.options.temperature import temperature_text
from system.plot import check_picture, save_picture
from system.spikes.file import check_spikes
from system.study.metrics.measure import is_measure, measures_of
from system.study.replay import Replay as Sample
from system.study.replay import replay
from system.study.table import FAILED
from system.study.target import Measurement, SystemTarget


def replay_command(asked: Replay) -> int:
    """Measure a sample again, tell whether it equals the kept one, and write the files that are asked for.

    Returns the exit status, `NO` where it differs or could not be measured.
    """
    check_picture(asked.plot)
    if asked.view is not None:
        check_page(asked.view)
        if asked.engine != "native":
            raise ParameterError(f"--view: of the native engine, not of {asked.engine}; leave one out")
    if asked.spikes is not None:
        check_spikes(asked.spikes)
    folder, die, given = asked.study, asked.die, asked.temperature
    celsius = None if given is None else parse_quantity(given, "degC", "--temperature")
    deadline_s = deadline_of(asked.deadline, asked.engine)
    with working(f"measuring die {die} again"):
        found = replay(
            Path(folder), die, asked.corner, celsius, asked.trial, asked.metric, asked.code,
            changed=asked.changed,
        )  # fmt: skip
        if isinstance(found.target, SystemTarget):
            if asked.spikes is not None:
                name = found.study.subject.target
                raise ParameterError(f"--spikes: not of a replayed robot; noctule run {name} writes them")
            _show_run(found, found.target, asked)
            choice, extra = None, {}
        else:
            choice = found.choice()
            extra = _waveforms(asked, found, choice, deadline_s)
    if asked.as_json:
        print_json(_document(found) | extra)
    else:
        _print(found, choice, extra)
    if found.changed:
        say(f"replay: {found.study.subject.target} has changed since {folder} was measured")
    if found.again.outcome == FAILED:
        say(f"replay: die {die} could not be measured: {found.again.reason}")
    elif found.kept is not None and not found.identical:
        say(f"replay: die {die} is not what {folder} has of it; the study is of another version")
    else:
        return DONE
    return NO


def _show_run(found: Sample, system: SystemTarget, asked: Replay) -> None:
    """Draw a system's run, and write its page, where they are asked for."""
    if asked.plot is not None or asked.view is not None:
        trace = system.run(found.die, found.condition, shown=True)
        save_picture(asked.plot, lambda figure: system.draw(trace, figure))
        if asked.view is not None:
            film = dataclasses.replace(system.film(trace), command=this_command())
            leave(film, asked.view, None)


def _readings(found: Sample, choice: Choice, result: Result) -> list[Reading]:
    """The study's measures in a run of the testbench, whichever engine it is by."""
    texts = [name for name in found.study.subject.metrics if is_measure(name)]
    record = TransientRecord(result)
    return [each.of(record) for each in measures_of(choice, texts)]


def _waveforms(asked: Replay, found: Sample, choice: Choice, deadline_s: float) -> dict[str, Any]:
    check_watched(asked.spikes, choice)
    if asked.engine == "native":
        result = simulate_as_many(to_kernel(choice.testbench(), choice.silicon))  # as the study had it
    else:
        result = engine_named(asked.engine, None, deadline_s)(choice.testbench(), choice.silicon)
    write_run(asked, choice, result)
    if asked.view is not None:
        leave_view(found.study.subject.target, choice, result, asked.view, None)
    return {
        "engine": asked.engine,
        "stimuli": choice.stimuli,
        "testbench_outcome": choice.block.outcome(result),
        "spikes_s": {port: times.tolist() for port, times in result.spikes.items()},
        "measures": plain(choice.block.measured(result)),
        "measured": [measured_document(each) for each in _readings(found, choice, result)],
        **told(result),
        "told": told_lines(result),
    }


def _document(found: Sample) -> dict[str, Any]:
    return {
        "target": found.study.subject.target,
        **describe_die(found.die),
        "plan": found.study.plan.name,
        "temperature_C": found.study.subject.course or found.condition.temperature_c,
        "trial": found.condition.trial,
        "kept": None if found.kept is None else _measured(found, found.kept),
        "again": _measured(found, found.again),
        "identical": found.identical,
        "note": found.note,
        "code_changed": found.changed,
    }


def _measured(found: Sample, one: Measurement) -> dict[str, Any]:
    names = [q.name for q in found.target.quantities]
    return {"class": one.outcome, **dict(zip(names, one.values, strict=True)), "reason": one.reason}


def _print(found: Sample, choice: Choice | None, extra: dict[str, Any]) -> None:
    kept_class = "-" if found.kept is None else found.kept.outcome
    rows: list[Sequence[object]] = [("class", kept_class, found.again.outcome)]
    for k, quantity in enumerate(found.target.quantities):
        kept = math.nan if found.kept is None else found.kept.values[k]
        cells = (_cell(v, quantity.unit) for v in (kept, found.again.values[k]))
        rows.append((quantity.name, *cells))
    warm = temperature_text(found.condition.temperature_c, found.study.subject.course)
    where = f"{warm} degC, {found.die}"
    print_table(f"{found.study.subject.target} at {where}", ("quantity", "kept:", "again:"), rows)
    if found.kept is None:
        print_line(f"nothing to compare with: {found.note}")
    else:
        print_line("identical to what was kept" if found.identical else "NOT what was kept: another version?")
    if found.again.reason:
        said = "failed" if found.again.outcome == FAILED else "not measured"
        print_line(f"{said}: {found.again.reason}")
    if choice is not None:
        print_stimuli(choice)
    for port, times in extra.get("spikes_s", {}).items():
        print_line(f"{port}, {extra['engine']}: {' '.join(f'{t:.9g} s' for t in times) or 'no spike'}")
    for each in extra.get("measured", ()):
        said = each["reason"] or value_text(each["value"], each["unit"])
        print_line(f"{each['name']}, {extra['engine']}: {said}")
    for line in extra.get("told", ()):
        print_line(line)


def _cell(value: float, unit: str) -> str:
    return quantity_cell(value, unit) if math.isfinite(value) else "-"
