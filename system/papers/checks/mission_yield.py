"""Yield of every robot: of drawn dies, how many do what the robot is for, before and after calibration.

No figure of a paper. Every robot runs with its chips in the loop and their noise, under the full law, its
biases from the bias generator's circuit. Each die has a world and noise of its own, of its number. It runs at
the design's codes, then at those of its calibration at 27 degC, at 27, 17 and 37 degC; beside it the ideal
program, or the nominal chip under its paper's equations, in the same worlds. A die that cannot be calibrated
counts as one that fails.

The rules were written before the dies from `FIRST` on were run. No code, tuning or test has seen those.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.errors import CircuitError
from circuits.silicon.die import Die
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS
from system.registry import load_system
from system.rule import Rule, above, at_least, at_most, unjudged
from system.statement import Statement
from system.study.blame.trial import outcome_of
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.study.statistics.share import Share, share_where
from system.verdict.null import nulls_of

NEVER, UNCALIBRATED = "never succeeds", "codes of the design"  # nulls
FIRST, DIES = 5000, 5  # of the dies, whose numbers are the seeds too
WARM_SHARE = 0.8  # of a figure at 27 degC, that is left at 17 and 37 degC
RUNAWAY = 500.0  # spikes of a flight; the nominal die makes some 100


@dataclass(frozen=True, slots=True)
class Robot:
    """How a robot is run and judged.

    options : beside those of its silicon.
    number : of its summary, whose mean is told; empty for none.
    share : least share of calibrated dies that succeed at 27 degC, None for none that is stated.
    of_ideal : least share of the ideal program's successes, or of its `number` for the forest, whose flights
        end.
    """

    options: Mapping[str, Any] = field(default_factory=dict)
    number: str = ""
    share: float | None = None
    of_ideal: float | None = None


ROBOTS: Mapping[str, Robot] = {
    "approach": Robot({"level": "behavioural"}, "held_fraction", share=0.9),
    "rover": Robot({}, "regret_share", share=0.99),
    "forest": Robot({"pings": 4000}, "avoided", of_ideal=0.8),
    "spiking-bat": Robot({"pings": 600}, "avoided"),
    "car": Robot({}, of_ideal=0.9),
    "head": Robot({}, "settled_rms_deg", of_ideal=0.9),
    "bug": Robot({"agent": "bug0", "map": "bug-field"}, "path_ratio"),
    "pushbot": Robot({"scene": "single-block"}, "distance_cm"),
    "rolls": Robot({"duration": 0.5}, "rate_cv"),
}
WAYS: Mapping[str, Mapping[str, Any]] = {
    "default": {"codes": "default"},
    "calibrated": {},
    "17 degC": {"temperature_c": 17.0},
    "37 degC": {"temperature_c": 37.0},
    "ideal": {"ideal": True},
}
"""What differs between the runs of a die, by name."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a run came to: whether it succeeded, its numbers where it has them, and why there is none.

    number : that of its robot.
    emergencies : share of its decisions.
    spikes : of its chip.
    failed : why it was not run; empty where it was.
    """

    succeeded: bool
    number: float | None = None
    emergencies: float | None = None
    spikes: float | None = None
    failed: str = ""


Found = Mapping[str, Sequence[Outcome]]  # by robot and way


def reproduce(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
    """Run every robot in every way on the dies."""
    keys = [Numbered(_named(r, way), FIRST + k) for r in ROBOTS for way in WAYS for k in range(dies)]
    campaign = Campaign("mission-yield", run_one, Numbered, Outcome, (version("noctule"), ROBOTS, WAYS))
    found = execution.by_condition(campaign, keys, progress)
    nulls = nulls_of(statements, {NEVER: _never(found), UNCALIBRATED: _uncalibrated(found)})
    return Report(statements(found), lambda figure: _draw(found, figure), notes(found), nulls)


def statements(found: Found) -> tuple[Statement, ...]:
    """Make the rows of all robots."""
    return tuple(row for robot in ROBOTS for row in _rows(robot, found))


def _never(found: Found) -> Found:
    """Robots that never succeed and do nothing, beside the same ideal programs."""
    idle = Outcome(succeeded=False, number=0.0, emergencies=0.0, spikes=0.0)
    return {key: runs if key.endswith("ideal") else [idle] * len(runs) for key, runs in found.items()}


def _uncalibrated(found: Found) -> Found:
    """The codes of the design in place of those of the calibration, beside the same ideal programs."""
    swapped = {_named(robot, "calibrated"): found[_named(robot, "default")] for robot in ROBOTS}
    return {**found, **swapped}


def run_one(key: Numbered) -> Outcome:
    """Run a robot in a way on a die, whose number is the seed too."""
    name, way = key.condition.split(", ")
    robot, system = ROBOTS[name], load_system(name)
    options = {**robot.options, **WAYS[way], "seed": key.number}
    if way != "ideal":
        options["die"] = Die(number=key.number)
    found = outcome_of(lambda: system.summarise(system.run(system.on_silicon(**options))))
    if isinstance(found, CircuitError):
        return Outcome(succeeded=False, failed=str(found))
    return Outcome(
        bool(found["succeeded"]), _number(found.get(robot.number)), _number(found["emergency_share"]),
        _number(found.get("spikes")),
    )  # fmt: skip


def _number(value: Any) -> float | None:
    return None if value is None else float(value)


def _named(robot: str, way: str) -> str:
    return f"{robot}, {way}"


def _share(found: Found, robot: str, way: str) -> Share:
    return share_where(run.succeeded for run in found[_named(robot, way)])


def _mean(found: Found, robot: str, way: str) -> float:
    """Mean of a robot's number over the dies that were run; NaN where there is none."""
    numbers = [r.number for r in found[_named(robot, way)] if r.number is not None]
    return float(np.mean(numbers)) if numbers else float("nan")


def _rows(robot: str, found: Found) -> tuple[Statement, ...]:
    """Chips that are calibrated, dies that succeed, and the robot's own number, in every way."""
    rows: list[Statement] = []
    name = robot.replace("-", "_")
    chips = share_where(not run.failed for run in found[_named(robot, "calibrated")])
    rows.append(Statement(f"{name}_chips_calibrated", None, chips.measured(), unjudged("told")))
    ideal = _share(found, robot, "ideal")
    for way in WAYS:
        share = _share(found, robot, way)
        rule = _rule(robot, way, ideal.value, _share(found, robot, "calibrated").value)
        rows.append(Statement(f"{name}_{_word(way)}_succeed", ideal.value, share.measured(), rule))
    return (*rows, *_own_rows(robot, found))


def _word(way: str) -> str:
    return way.replace(" degC", "_C").replace(" ", "_")


def _rule(name: str, way: str, ideal: float, at_27: float) -> Rule:
    """When a share of dies that succeed is enough; ideal, at_27: that of the program, and at 27 degC."""
    robot = ROBOTS[name]
    if way.endswith("degC"):
        left = at_least(WARM_SHARE * at_27, f"at least {{limit:.3g}}, {WARM_SHARE:g} of that at 27 degC")
        return left & above(0.0, "more than none")
    if way == "calibrated" and robot.share is not None:
        return at_least(robot.share)
    if way == "calibrated" and robot.of_ideal is not None and name != "forest":
        limit = robot.of_ideal * ideal
        return at_least(limit, f"at least {{limit:.3g}}, {robot.of_ideal:g} of the ideal program's")
    return unjudged("told")


def _own_rows(robot: str, found: Found) -> tuple[Statement, ...]:
    """Rows about what a robot has of its own: its number, runaways of the sonar, emergencies of the bat."""
    name, asked = robot.replace("-", "_"), ROBOTS[robot]
    runs = found[_named(robot, "calibrated")]
    rows: list[Statement] = []
    if asked.number:
        ideal, ours = (_mean(found, robot, way) for way in ("ideal", "calibrated"))
        rule = unjudged("told, the mean over the dies that were run")
        if asked.of_ideal is not None and robot == "forest":
            text = f"at least {{limit:.3g}}, {asked.of_ideal:g} of the ideal program's"
            rule = at_least(asked.of_ideal * ideal, text)
        if robot == "rover":
            rule = at_most(0.01)
        rows.append(Statement(f"{name}_calibrated_{asked.number}", ideal, ours, rule))
    if robot == "approach":
        away = share_where(r.spikes is not None and r.spikes > RUNAWAY for r in runs)
        rows.append(Statement("approach_runs_away", 0.0, away.measured(), at_most(1.0 / 200.0)))
    if robot == "forest":
        rows.append(Statement("forest_emergency_share", None, _emergencies(runs), at_most(0.05)))
    return tuple(rows)


def _emergencies(runs: Sequence[Outcome]) -> float:
    """Mean share of decisions that were emergencies; NaN where nothing was run."""
    shares = [r.emergencies for r in runs if r.emergencies is not None]
    return float(np.mean(shares)) if shares else float("nan")


def notes(found: Found) -> tuple[str, ...]:
    """Each robot's dies that succeed in every way, and why those that were not run were not."""
    lines = []
    for robot in ROBOTS:
        shares = ", ".join(f"{_share(found, robot, way)} ({way})" for way in WAYS)
        lines.append(f"{robot}: succeed {shares}.")
        why = {run.failed for run in found[_named(robot, "calibrated")] if run.failed}
        lines += [f"{robot}: not run, {text}." for text in sorted(why)[:3]]
    return tuple(lines)


def _draw(found: Found, figure: Figure) -> None:
    """Share of dies on which each robot succeeds, in every way, with its interval."""
    figure.set_size_inches(9.0, 3.8)
    ax = figure.add_subplot()
    width = 0.8 / len(WAYS)
    for k, way in enumerate(WAYS):
        shares = [_share(found, robot, way) for robot in ROBOTS]
        at = np.arange(len(ROBOTS)) + width * (k - 0.5 * (len(WAYS) - 1))
        values = np.array([s.value for s in shares])
        ends = np.array([[s.value - s.interval.low, s.interval.high - s.value] for s in shares]).T
        label = f"{way}, 27 degC" if way in {"default", "calibrated"} else way
        ax.bar(at, values, width, color=COLOURS[k], label=label, yerr=ends, error_kw={"lw": 0.8})
    ax.set_xticks(range(len(ROBOTS)), list(ROBOTS), rotation=20, ha="right")
    ax.set_ylim(0.0, 1.05)
    ax.set_ylabel("dies that succeed, share")
    ax.legend(fontsize=8, ncols=len(WAYS), loc="lower center", bbox_to_anchor=(0.5, 1.0))


EXPERIMENT = Experiment(
    "mission-yield", "dies on which every robot does what it is for, calibrated or not", reproduce,
    {"dies": DIES}, (NEVER, UNCALIBRATED),
)  # fmt: skip
