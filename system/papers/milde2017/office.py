"""Section 3.6 and Figure 13 of Milde et al. 2017: driving around in an office.

The paper reports four runs of 0.5 to 1.5 minutes with one crash, about 0.25 a minute. The robot drives
through an office of ours, and its crashes a minute are compared with that. A run begins at a place of
its own (by seed, a metre free ahead) and ends at its first touch or after a minute. People walk their ways
and look at nothing: where one walks into the robot from outside of the camera's field, the run ends, but it
is no crash of the robot's; such ends are told. Rule (ours): the lower end of the 95 % Poisson interval of our
crashes a minute is not above the upper end of the paper's, one crash in 4 minutes; in normal light. Other
lights are told. Turn factor 1 (ours), the better one of Table 1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from circuits.errors import ParameterError
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import ROBOTS, runs_of
from system.papers.milde2017.picture import draw_first
from system.pushbot.campaign import Drive, Runs, Summary, drive_repeats, summaries_of
from system.pushbot.course import stood
from system.pushbot.run import Trace, summarise
from system.pushbot.scenario import Scenario, scene_of
from system.rule import Measured, at_most
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.interval import Interval, poisson_interval
from system.verdict.null import nulls_of
from system.worlds.arena.geometry import Obstacles, collision, obstacles_of, outline_at
from system.worlds.arena.scene import LIGHTS, Scene
from system.worlds.camera.sensor import Dvs

RUNS, DIES = 50, 10  # of each light
DURATION = 60.0  # s
PAPER_CRASHES, PAPER_MINUTES = 1, 4.0
TURN = 1.0  # turn factor; ours
FREE, EVERY = 1.0, 0.05  # m free ahead of a start, and m between two looks at them; ours
TRIES = 10_000  # draws of a start


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = RUNS, dies: int = DIES,
    duration: float = DURATION, lights: Sequence[str] = tuple(LIGHTS),
) -> Report:  # fmt: skip
    """Drive through the office in all lights; the picture shows the first run."""
    base = Scenario(
        scene="office", duration=duration, turn_factor=TURN, silicon_noise="off", **IDEAL_CURRENTS
    )
    cells = {light: Drive(replace(base, light=light), outcome, started) for light in lights}
    asked, usual = Runs(count, dies), Runs(RUNS, DIES)
    found = summaries_of(drive_repeats(execution, EXPERIMENT.name, cells, asked, usual, progress))
    nulls = nulls_of(rows, runs_of(ROBOTS, found))
    return Report(rows(found), partial(draw_first, cells[lights[0]], asked), notes(found), nulls)


def outcome(trace: Trace) -> Summary:
    """Give whether somebody walked into the robot, and the share of the time at rest."""
    walked, still = is_walked_into(trace), stood(np.array(trace.drive.path))
    return summarise(trace) | {"walked_into": float(walked), "stood": still}


def started(scenario: Scenario) -> Scene:
    """Give the scene with a start that is drawn from the scenario's seed."""
    scene, random = scene_of(scenario), np.random.default_rng((scenario.seed, 6))
    obstacles, corners = obstacles_of(scene), np.array(scene.corners)
    for _ in range(TRIES):
        x, y = (float(v) for v in random.uniform(corners.min(axis=0), corners.max(axis=0)))
        start = x, y, float(random.uniform(-math.pi, math.pi))
        if is_free(obstacles, start):
            return replace(scene, start=start)
    raise ParameterError(f"{scene.name}: no start with {FREE:g} m free ahead, must have one; move furniture")


def is_free(obstacles: Obstacles, start: tuple[float, float, float]) -> bool:
    """Tell whether a robot could drive FREE straight ahead from a start if nothing moved."""
    cos, sin = math.cos(start[2]), math.sin(start[2])
    ways = np.arange(0.0, FREE + 1e-9, EVERY).tolist()
    return all(
        collision(obstacles, (start[0] + way * cos, start[1] + way * sin, start[2]), 0.0) is None
        for way in ways
    )


def is_walked_into(trace: Trace) -> bool:
    """Tell whether what touched the robot at the end is a leg that is not before the camera."""
    drive, touched = trace.drive, trace.drive.touched or ""
    if not touched.startswith("person"):
        return False
    k = [b.name for b in drive.scene.bodies].index(touched)
    leg, (x, y, heading) = outline_at(drive.obstacles, k, drive.time).centroid, drive.pose
    dvs = Dvs()
    dx, dy = leg.x - x - dvs.ahead * math.cos(heading), leg.y - y - dvs.ahead * math.sin(heading)
    aside = math.remainder(math.atan2(dy, dx) - heading, 2.0 * math.pi)
    return abs(aside) > 0.5 * dvs.field


def poisson(count: int, minutes: float) -> Interval:
    """Give the exact 95 % interval of a rate, 1/min."""
    found = poisson_interval(count)
    return Interval(found.low / minutes, found.high / minutes)


def rows(found: Mapping[str, Sequence[Summary]]) -> tuple[Statement, ...]:
    """Make the statement about crashes a minute in the first light."""
    theirs = poisson(PAPER_CRASHES, PAPER_MINUTES)
    crashes, minutes = crashes_in(next(iter(found.values())))
    ours = poisson(crashes, minutes)
    shown = f"{crashes / minutes:.2f} ({ours.low:.2f} to {ours.high:.2f})"
    rule = at_most(theirs.high, "lower end at most {limit:.2f}")
    return (Statement("crashes_a_minute", PAPER_CRASHES / PAPER_MINUTES, Measured(ours.low, shown), rule),)


def crashes_in(found: Sequence[Summary]) -> tuple[int, float]:
    """Count the crashes that are the robot's own, and the minutes driven."""
    return sum(bool(s["collided"]) and not s["walked_into"] for s in found), sum(
        s["time_s"] or 0.0 for s in found
    ) / 60.0


def stood_in(runs: Sequence[Summary]) -> float:
    """Give the share of all time in which the robots stand."""
    still = sum((s["stood"] or 0.0) * (s["time_s"] or 0.0) for s in runs)
    return still / sum(s["time_s"] or 0.0 for s in runs)


def notes(found: Mapping[str, Sequence[Summary]]) -> tuple[str, ...]:
    """Tell crashes, minutes and way by light."""
    out = []
    for light, runs in found.items():
        crashes, minutes = crashes_in(runs)
        ends = poisson(crashes, minutes)
        way = sum(s["path_m"] or 0.0 for s in runs)
        out.append(
            f"{light}: {crashes} crashes in {len(runs)} runs, {minutes:.1f} min and {way:.0f} m,"
            f" {crashes / minutes:.2f} a minute ({ends.low:.2f} to {ends.high:.2f}); people walked into it in"
            f" {sum(bool(s['walked_into']) for s in runs)}; stands {100.0 * stood_in(runs):.0f} % of the time"
        )
    return tuple(out)


EXPERIMENT = Experiment(
    "milde2017-office", "crashes a minute in an office", reproduce, {"count": RUNS, "dies": DIES},
    tuple(ROBOTS),
)  # fmt: skip
