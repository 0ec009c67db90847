"""What noctule's defaults make of every robot: the full law and the bias generator's circuit, on dies.

No figure of a paper. Every robot runs with its chips in the loop and their noise, on the nominal die and on
drawn ones, at the codes of the die where its biases have codes. Its silicon is that of the paper (ideal law,
and the kind of biases that its experiments have), then with one of both changed, then as the defaults have
it. In these rows `paper` is the number on the paper's silicon and ours that under the defaults; they tell
what moved and by how much, and none passes or fails.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.silicon.die import Die
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import FIXED_GATES, IDEAL_CURRENTS, Conditions
from system.plot import COLOURS
from system.registry import load_system
from system.rule import unjudged
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

FIRST, DIES = 1000, 5  # of the drawn dies, whose numbers are the seeds too
NOMINAL = 0  # number of a run on the nominal die


@dataclass(frozen=True, slots=True)
class Robot:
    """How a robot is run, and the number that tells most of it.

    options : by which its chips are in the loop.
    number : name of the number, with its unit at its end.
    paper : on which silicon its experiments run.
    """

    options: Mapping[str, Any]
    number: str
    paper: Conditions


ROBOTS: Mapping[str, Robot] = {
    "approach": Robot({"level": "behavioural"}, "range_error_mean_m", FIXED_GATES),
    "head": Robot({}, "error_rms_deg", FIXED_GATES),
    "forest": Robot({"ranges": "chip", "selection": "chip", "pings": 5000}, "avoided", FIXED_GATES),
    "car": Robot({"ranges": "chip"}, "time_s", FIXED_GATES),
    "spiking-bat": Robot({"brain": "chip"}, "avoided", FIXED_GATES),
    "bug": Robot({"brain": "chip"}, "final_distance", FIXED_GATES),
    "pushbot": Robot({}, "distance_m", IDEAL_CURRENTS),
    "rolls": Robot({}, "population_rate", FIXED_GATES),
    "rover": Robot({"cells": "chip"}, "regret_share", FIXED_GATES),
}
WAYS: Mapping[str, Mapping[str, Any]] = {
    "paper": {},
    "generator": {"bias_kind": "generator"},
    "full law": {"law": "full"},
    "defaults": {"bias_kind": "generator", "law": "full"},
}
"""What differs from the paper's silicon, by name."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a run came to: whether it succeeded, and its number, None where it has none."""

    succeeded: bool
    number: float | None


Found = Mapping[str, Sequence[Outcome]]  # by robot and way


def reproduce(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
    """Run every robot in every way on the nominal die and on drawn ones."""
    numbers = (NOMINAL, *range(FIRST, FIRST + dies))
    keys = [Numbered(_named(robot, way), n) for robot in ROBOTS for way in WAYS for n in numbers]
    campaign = Campaign("defaults", run_one, Numbered, Outcome, (version("noctule"), ROBOTS, WAYS))
    found = execution.by_condition(campaign, keys, progress)
    rows = tuple(row for robot in ROBOTS for row in _rows(robot, found))
    return Report(rows, lambda figure: _draw(found, figure), notes(found))


def run_one(key: Numbered) -> Outcome:
    """Run a robot in a way on a die, whose number is the seed too."""
    name, way = key.condition.split(", ")
    robot, system = ROBOTS[name], load_system(name)
    die = Die(number=key.number) if key.number != NOMINAL else Die()
    options = {**robot.options, **robot.paper, **WAYS[way]}
    found = system.summarise(system.run(system.scenario(die=die, seed=key.number or FIRST, **options)))
    number = found[robot.number]
    return Outcome(bool(found["succeeded"]), None if number is None else float(number))


def _named(robot: str, way: str) -> str:
    return f"{robot}, {way}"


def _rows(robot: str, found: Found) -> tuple[Statement, ...]:
    """Numbers of the nominal die, then the median and the share of success over the drawn dies."""
    before, after = (found[_named(robot, way)] for way in ("paper", "defaults"))
    name = f"{robot.replace('-', '_')}_{{}}_{ROBOTS[robot].number}"
    return (
        _moved(name.format("nominal"), before[0].number, after[0].number),
        _moved(name.format("dies_median"), _median(before[1:]), _median(after[1:])),
        _moved(f"{robot.replace('-', '_')}_dies_succeed", _share(before[1:]), _share(after[1:])),
    )


def _moved(name: str, before: float | None, after: float | None) -> Statement:
    if before is None or after is None:
        return Statement(name, before, after, unjudged("one of both has none"))
    share = f" ({100.0 * (after / before - 1.0):+.3g} %)" if before else ""
    return Statement(name, before, after, unjudged(f"moved by {after - before:+.3g}{share}"))


def _median(runs: Sequence[Outcome]) -> float | None:
    """Median of the runs that have a number."""
    numbers = [r.number for r in runs if r.number is not None]
    return float(np.median(numbers)) if numbers else None


def _share(runs: Sequence[Outcome]) -> float:
    return float(np.mean([r.succeeded for r in runs]))


def notes(found: Found) -> tuple[str, ...]:
    """Each robot's drawn dies that succeed, in every way."""
    return tuple(
        f"{robot}: of {len(found[_named(robot, 'paper')]) - 1} drawn dies succeed "
        + ", ".join(f"{sum(r.succeeded for r in found[_named(robot, way)][1:])} ({way})" for way in WAYS)
        + "."
        for robot in ROBOTS
    )


def _draw(found: Found, figure: Figure) -> None:
    """Share of drawn dies on which each robot succeeds, in every way; a ring where the nominal die does."""
    figure.set_size_inches(8.0, 3.6)
    ax = figure.add_subplot()
    width = 0.8 / len(WAYS)
    for k, way in enumerate(WAYS):
        runs = [found[_named(robot, way)] for robot in ROBOTS]
        at = np.arange(len(ROBOTS)) + width * (k - 0.5 * (len(WAYS) - 1))
        ax.bar(at, [_share(r[1:]) for r in runs], width, color=COLOURS[k], label=way)
        nominal = [x for x, r in zip(at, runs, strict=True) if r[0].succeeded]
        label = "nominal die succeeds" if k == 0 else None
        ax.plot(nominal, np.full(len(nominal), 1.06), "o", mfc="none", color="k", ms=4, label=label)
    ax.set_xticks(range(len(ROBOTS)), list(ROBOTS), rotation=20, ha="right")
    ax.set_ylim(0.0, 1.12)
    ax.set_ylabel("drawn dies that succeed, share")
    ax.legend(fontsize=8, ncols=len(WAYS) + 1, loc="lower center", bbox_to_anchor=(0.5, 1.0))


EXPERIMENT = Experiment(
    "defaults", "what the full law and the bias generator make of every robot", reproduce, {"dies": DIES}
)
