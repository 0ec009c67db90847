"""The verb `noctule blame SYSTEM`: which devices of a die make a robot fail, in words, JSON and a page."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.cli.exit_status import DONE, NO
from system.cli.option_names import as_options, option_of, words_of
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.run import scenario_of
from system.cli.study_verbs import Blame as Asked
from system.files.writing import write_text_atomic
from system.options.block import describe_die
from system.options.die.file import write_die_file
from system.plot import check_picture, save_picture
from system.registry import load_system
from system.study.blame.blame import Blame, Culprit, blame
from system.study.blame.picture import draw_blame
from system.study.blame.report import blame_page
from system.study.blame.story import (
    DIE,
    Told,
    device_lines,
    mended_options,
    number_rows,
    opening_lines,
    told_runs,
    train_rows,
)
from system.study.blame.trial import Case
from system.study.mission.mission import wanted_of
from system.study.statistics.share import Share

FEWEST_TRIALS = 150


def blame_system(name: str, asked: Asked, options: Mapping[str, Any], said: Mapping[str, str]) -> int:
    """Print what is to blame, and write the files that are asked for; arguments as of `run_system`.

    Returns the exit status, `NO` where nothing was found that mends.
    """
    system = load_system(name)
    check_picture(asked.plot)
    if asked.trials < FEWEST_TRIALS:
        raise ParameterError(f"--trials: {asked.trials}, must be at least {FEWEST_TRIALS}")
    levels = {} if "level" not in system.settings else {"level": "behavioural"}
    texts = {**levels, **options}
    scenario = scenario_of(system, asked, texts)
    remedy = system.no_silicon(scenario)
    if remedy:
        raise ParameterError(f"{name}: no chip is in the loop; {as_options(remedy, said)}")
    case = Case(system, scenario, None if asked.success is None else wanted_of(system, asked.success))
    with progress_bar(f"blame {name}") as progress:
        found = blame(case, asked.trials, progress)
    told = told_runs(found)
    if asked.mended is not None:
        write_die_file(Path(asked.mended), found.mended)
    if asked.report is not None:
        write_text_atomic(asked.report, blame_page(found, told, command(found, texts)))
    save_picture(asked.plot, lambda figure: draw_blame(found, told, figure))
    if asked.as_json:
        print_json(document(found, told, command(found, texts)))
    else:
        _print(found, told, command(found, texts))
    return DONE if found.verified is not None and found.verified.mends else NO


def command(found: Blame, texts: Mapping[str, Any]) -> str:
    """Give the command that runs the mended robot."""
    scenario = found.case.scenario
    words = ["noctule", "run", found.case.system.name]
    for name, value in texts.items():
        each = value if isinstance(value, list) else [value]
        words += [word for one in each for word in _option(name, one)]
    words += [*_silicon(scenario.die), "--seed", str(scenario.seed), *_temperature(scenario)]
    return shlex.join([*words, *words_of(mended_options(found))])


def _silicon(die: Die) -> list[str]:
    """Options of a die as it was drawn."""
    words = ["--die", "nominal" if die.number is None else str(die.number)]
    usual = Die()
    for name in ("lot", "corner", "variation"):
        if getattr(die, name) != getattr(usual, name):
            words += [option_of(name), getattr(die, name)]
    words += [] if die.mismatch else ["--no-mismatch"]
    return words if die.process else [*words, "--no-process-variation"]


def _temperature(scenario: Any) -> list[str]:
    course = getattr(scenario, "course", ())
    text = ",".join(f"{time:g}s:{celsius:g}" for time, celsius in course) or f"{scenario.temperature_c:g}"
    return ["--temperature", text]


def _option(name: str, value: Any) -> list[str]:
    if isinstance(value, bool):
        return [option_of(name if value else f"no_{name}")]
    return [option_of(name), str(value)]


def document(found: Blame, told: Told, again: str) -> dict[str, Any]:
    """Give what was found by the names that JSON has for it."""
    accused, verified, scenario = found.accused, found.verified, found.case.scenario
    return {
        "system": found.case.system.name,
        **describe_die(scenario.die),
        "success": found.case.definition,
        "seed": scenario.seed,
        "temperature_C": scenario.temperature_c,
        "trials": found.trials,
        "guilty": accused.guilty,
        "die_succeeds": _share(accused.pairs.first_share),
        "healed_succeeds": _share(accused.pairs.second_share),
        "recalibrated": found.case.recalibrated,
        "healed_succeeds_at_die_codes": None if found.held is None else _share(found.held.pairs.second_share),
        "finished": found.finished,
        "steps": [
            {"level": s.level, "among": s.among, "kept": s.kept, "trials": s.trials} for s in found.steps
        ],
        "culprits": [_culprit(found, each) for each in found.culprits],
        "mends": None if verified is None else verified.mends,
        "verified": None if verified is None else {
            "trials": len(verified.pairs.seeds), "wanted": verified.wanted,
            "mended_succeeds": _share(verified.pairs.second_share),
            "healed_succeeds": _share(verified.pairs.first_share),
            "difference": {"low": verified.interval.low, "high": verified.interval.high},
        },
        "random_mends": None if found.random is None else _share(found.random),
        "area_that_mends": found.area,
        "codes": [
            {"name": r.name, "succeeds": None if r.share is None else _share(r.share)}
            for r in found.remedies
        ],
        "story": [*opening_lines(found, told), *device_lines(found)],
        "runs": [
            {"name": name, "seed": told.seed, "succeeded": found.case.success(s), "reason": s["reason"]}
            for name, s in told.summaries.items()
        ],
        "command": again,
    }  # fmt: skip


def _culprit(found: Blame, each: Culprit) -> dict[str, Any]:
    deviations = [
        {"parameter": name, "value": value, "sigma": sigma, "gradient": each.slopes.get(name, 0.0)}
        for name, (value, sigma) in each.deviations.items()
    ]
    return {"path": each.path, "devices": found.counts[each.path], "deviations": deviations}


def _share(share: Share) -> dict[str, Any]:
    interval = {"low": share.interval.low, "high": share.interval.high}
    return {"passed": share.passed, "of": share.of, "interval": interval}


def _print(found: Blame, told: Told, again: str) -> None:
    print_line(f"success: {found.case.definition}")
    for line in opening_lines(found, told):
        print_line(line)
    if not found.accused.guilty:
        return
    rows = [
        (s.level, s.among, len(s.kept), s.trials, ", ".join(s.kept[:4]) + (" ..." if len(s.kept) > 4 else ""))
        for s in found.steps
    ]
    print_table("search", ("level", "parts:", "kept:", "trials:", "the fewest whose healing mends"), rows)
    for line in device_lines(found):
        print_line(line)
    names = tuple(f"{name}:" for name in told.traces)
    if trains := train_rows(found, told):
        print_table(f"spikes, seed {told.seed}", ("of", *names), trains)
    if DIE in told.traces:
        print_table(f"numbers, seed {told.seed}", ("number", *names), number_rows(told))
    print_line(f"the mended robot: {again}")
