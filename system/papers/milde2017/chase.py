"""Section 3.7 and Figure 15 of Milde et al. 2017: after a robot that drives around with a blinking LED.

The paper says that the field selects the LED "in most cases", losing it twice. Here the robot drives after
another one on several dies, and what the field selects is compared with where the LED is. The rule: for at
least 80 % of the time in which the LED is in view, the field's median spike is within six columns of it
(ours); a silent field counts as lost. Speed factor 0.25, a little more than the other robot's 0.15 m/s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import ROBOTS, Robot, runs_of
from system.papers.milde2017.picture import draw_first
from system.pushbot.campaign import Drive, Runs, Summary, drive_repeats, mean_sd, summaries_of
from system.pushbot.loop import all_spikes
from system.pushbot.run import Trace
from system.pushbot.scenario import Scenario
from system.rule import at_least
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.power import detectable_mean
from system.verdict.null import nulls_of
from system.worlds.arena.geometry import outline_at

RUNS, DIES = 5, 5
DURATION = 15.0  # s
ON_TARGET = 0.8
SPEED, WINDOW = 0.25, 0.1
BIN = 0.1  # s
COLUMNS = 6.0  # beside the LED that count as on it; ours
COLUMN = math.tan(math.radians(30.0)) / 64.0  # tangent of a column


def _looks_ahead(summary: Summary) -> Summary:
    """A field that is always straight ahead; it touches what ours touches."""
    return summary | {"on_target": summary.get("ahead")}


NULLS: dict[str, Robot] = {**ROBOTS, "always looks straight ahead": _looks_ahead}


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = RUNS, dies: int = DIES,
    duration: float = DURATION,
) -> Report:  # fmt: skip
    """Drive after the other robot on some dies; the picture shows the first run."""
    chase = Drive(
        Scenario(
            scene="chase",
            speed_factor=SPEED,
            window=WINDOW,
            duration=duration,
            silicon_noise="off",
            **IDEAL_CURRENTS,
        ),
        outcome,
    )
    asked, usual = Runs(count, dies), Runs(RUNS, DIES)
    driven = drive_repeats(execution, EXPERIMENT.name, {"chase": chase}, asked, usual, progress)
    found = summaries_of(driven)["chase"]
    nulls = {name: runs["chase"] for name, runs in runs_of(NULLS, {"chase": found}).items()}
    return Report(rows(found), partial(draw_first, chase, asked), notes(found), nulls_of(rows, nulls))


def outcome(trace: Trace) -> Summary:
    """Give the shares of the time in which the LED is in view, and of that in which the field is on it.

    `ahead` is the share in which a field would be on it that is always straight ahead.
    """
    columns = led_columns(trace)
    times, neurons = all_spikes(trace.record)
    field = np.array(trace.brain.network["target"].neurons)
    mine = np.isin(neurons, field)
    bins = (times[mine] / BIN).astype(np.int64)
    place = neurons[mine] - field[0]
    hit, seen, middle = 0, 0, 0
    for k, column in enumerate(columns):
        if not 0.0 <= column < field.size:
            continue
        seen += 1
        middle += bool(abs(0.5 * (field.size - 1) - column) <= COLUMNS)
        here = place[bins == k]
        hit += bool(here.size and abs(np.median(here) - column) <= COLUMNS)
    return {
        "on_target": hit / seen if seen else None,
        "ahead": middle / seen if seen else None,
        "in_view": seen / max(len(columns), 1),
        "touched": float(trace.drive.touched is not None),
        "time": float(trace.drive.path[-1][0]),
    }


def led_columns(trace: Trace) -> F64:
    """Give the column of the sensor in which the LED is in the middle of each bin; NaN where it is behind."""
    path = np.array(trace.drive.path)
    found = []
    lamps = [k for k, b in enumerate(trace.scene.bodies) if b.led is not None]
    for moment in np.arange(BIN / 2, path[-1, 0], BIN):
        _, x, y, heading = path[int(np.searchsorted(path[:, 0], moment))]
        where = outline_at(trace.drive.obstacles, lamps[0], float(moment)).centroid
        dx, dy = where.x - x, where.y - y
        ahead = dx * math.cos(heading) + dy * math.sin(heading) - trace.drive.sensor.dvs.ahead
        left = dy * math.cos(heading) - dx * math.sin(heading)
        found.append(63.5 - left / ahead / COLUMN if ahead > 0.0 else math.nan)
    return np.array(found)


def rows(found: Sequence[Summary]) -> tuple[Statement, ...]:
    """Make the statement about the time on target."""
    mean, _, _ = mean_sd(found, "on_target")
    return (Statement("on_target", "most of the time", mean, at_least(ON_TARGET)),)


def notes(found: Sequence[Summary]) -> tuple[str, ...]:
    """Tell how each run went."""
    out = []
    for k, s in enumerate(found):
        share = "never in view" if s["on_target"] is None else f"on target {s['on_target']:.2f}"
        end = "touched something" if s["touched"] else "free"
        out.append(f"run {k}: {share}, in view {s['in_view']:.2f} of {s['time']:.3g} s, {end}")
    return (*out, _power(found))


def _power(found: Sequence[Summary]) -> str:
    """The least distance from `ON_TARGET` that so many runs tell."""
    _, deviation, count = mean_sd(found, "on_target")
    apart = detectable_mean(count) * deviation
    told = f"{apart:.2g} from {ON_TARGET:g}" if count > 1 else "none: one run tells no spread"
    return f"power: {count} runs tell a share on target (80 %, two-sided 5 %) that is off by {told}"


EXPERIMENT = Experiment(
    "milde2017-chase", "after a robot with a blinking LED", reproduce, {"count": RUNS, "dies": DIES},
    tuple(NULLS),
)  # fmt: skip
