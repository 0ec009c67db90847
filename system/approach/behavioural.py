"""The approach of a sonar with every box as a measured model, run by one compiled loop.

Takes the parts that `system.approach.loop` builds, so that both loops have the same models and the same
numbers; here is only their bringing together: targets as waypoints, states, and the log that the loop leaves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from chips.boards.centroid.model import CentroidModel
from chips.boards.isolation.model import IsolationModel
from chips.boards.vocalization.model import VocalizationModel
from chips.ranging.chip import RangingChip
from chips.ranging.kernel import MERGED as CHIP_MERGED
from chips.ranging.kernel import Chip, doubts, new_chip
from chips.ranging.temperature import Conditions, conditions_of, moved
from circuits.arrays import F64
from circuits.silicon.course import told_when
from system.approach.kernel import CLIPPED, COUNTS, MERGED, ROW, SOUNDS, UNDECIDED, Boards, Run, Scene, fly
from system.worlds.sound.acoustics import speed_of_sound
from system.worlds.sound.hearing import Hearing
from system.worlds.sound.microphone import direct_amplitude, echo_amplitude, headroom
from system.worlds.sound.targets import Approach, Target, Waypoints, range_at

Stretch = tuple[float, float, float]  # its begin and end, s, and its temperature, degC
Progress = Callable[[float], None]  # told the share that is done, or the time, s
ROWS = 4096  # of the log, worked through at once
_BEYOND = 1.0  # s after the end up to which a target's path is laid out: longer than any echo


@dataclass(frozen=True, slots=True)
class Models:
    """The measured models of all boxes of the approach.

    `amplitude` is a second centroid board, which only the law of the fourth power has; `isolation` is None
    without first-target isolation.

    chip : the ranging chip.
    off : its neurons whose spikes reach nothing.
    proximity : the centroid board whose voltage is the proximity.
    vocalization : the vocalization controller.
    hearing : ear, envelope detector and both neurons in one.
    """

    chip: RangingChip
    off: tuple[int, ...]
    proximity: CentroidModel
    amplitude: CentroidModel | None
    vocalization: VocalizationModel
    hearing: Hearing
    isolation: IsolationModel | None


@dataclass(frozen=True, slots=True)
class Flight:
    """What the compiled loop leaves: its log and its counters.

    rows : pieces of the log, float64[rows, 4] each: kind of event, time (s), and two numbers of the event.
    counts : what a run reports beside its arrays.
    """

    rows: Sequence[F64]
    counts: dict[str, int]


def fly_behavioural(
    models_at: Callable[[float], Models],
    stretches: Iterable[Stretch],
    duration: float,
    progress: Progress | None,
) -> Flight:
    """Run the models for `duration` s and return the log.

    models_at: the models at a temperature, degC; stretches: begin and end, s, of each stretch of one
    temperature, and that; the air's is that of the first.
    """

    def told(time: float) -> None:
        if progress is not None:
            progress(time / duration)

    (_, end, celsius), *later = stretches
    models = models_at(celsius)
    known = models.chip  # of which every temperature's noise goes on with the same state
    on = conditions_of(known.neurons_at(celsius), known.jitter_at(celsius))
    chip = new_chip(on.neurons, on.plan, jitter=on.jitter)
    run, scene = _begin(models), _scene(models.hearing, duration)
    rows = _fly(scene, _boards(models), on, chip, run, end, told)
    for begin, end, celsius in later:
        with told_when(begin):
            models = models_at(celsius)
            after = conditions_of(known.neurons_at(celsius), known.jitter_at(celsius))
        chip, on = moved(chip, on, after, begin), after
        _move_levels(run, models)
        rows += _fly(scene, _boards(models), on, chip, run, end, told)
    return Flight(rows, _counts(run, chip))


def _fly(
    scene: Scene, boards: Boards, on: Conditions, chip: Chip, run: Run, end: float, progress: Progress
) -> list[F64]:
    """Go on to `end` s at one temperature; pieces of the log."""
    rows, reached = [], -math.inf
    while reached < end:
        reached = fly(scene, boards, on.neurons, on.plan, chip, run, end)
        rows.append(run.log[: run.used[2]].copy())
        run.used[2] = 0
        progress(reached)
    return rows


def _boards(models: Models) -> Boards:
    second, ears = models.amplitude or models.proximity, models.hearing.model
    heard = np.ones(len(models.chip.spikes), np.bool_)
    heard[list(models.off)] = False
    return Boards(
        models.proximity.numbers, second.numbers, models.vocalization.numbers, ears.onset,
        ears.high_threshold, models.vocalization.noise, ears.noise,
        heard,
    )  # fmt: skip


def _move_levels(run: Run, models: Models) -> None:
    """Take the levels of the isolation to those of another temperature."""
    if models.isolation is None:
        return
    isolated = bool(run.levels[0] == run.levels[2])
    run.levels[1:] = models.isolation.open_level, models.isolation.isolated_level
    run.levels[0] = run.levels[2 if isolated else 1]


def _begin(models: Models) -> Run:
    boards = [models.proximity] if models.amplitude is None else [models.proximity, models.amplitude]
    states = [b.begin() for b in boards]
    oscillator = models.vocalization.begin()
    levels = np.full(3, math.nan)
    if models.isolation is not None:
        opened = models.isolation.open_level
        levels[:] = opened, opened, models.isolation.isolated_level
    return Run(
        boards=np.array([s.board for s in states]),
        ends=np.array([s.ends for s in states]),
        oscillator=np.array([oscillator.phase, oscillator.free]),
        sounds=np.zeros((SOUNDS, 2)),
        due=np.zeros((2 * SOUNDS, 2)),
        used=np.zeros(3, np.int64),
        levels=levels,
        counts=np.zeros(COUNTS, np.int64),
        log=np.zeros((ROWS, ROW)),
    )


def _scene(hearing: Hearing, duration: float) -> Scene:
    """Lay the targets' paths out; raises where a path is refused within the run."""
    ear = hearing.parameters
    paths = [list(_waypoints(t, duration + _BEYOND)) for t in hearing.targets]
    points = max((len(p) for p in paths), default=1)
    full = np.array([p + [p[-1]] * (points - len(p)) for p in paths]).reshape(-1, points, 2)
    return Scene(
        time=full[:, :, 0].copy(),
        distance=full[:, :, 1].copy(),
        strength=np.array([t.target_strength for t in hearing.targets]),
        speed=speed_of_sound(ear.air.temperature),
        absorption=ear.air.absorption,
        mouth_ear_delay=ear.mouth_ear_delay,
        direct=direct_amplitude(ear, 1.0),
        echo=echo_amplitude(ear, 1.0, 1.0, 1.0),
        headroom=headroom(ear),
    )


def _waypoints(target: Target, end: float) -> Iterator[tuple[float, float]]:
    path = target.trajectory
    if isinstance(path, Waypoints):
        yield from zip(path.time_s, path.range_m, strict=True)
        return
    times = [0.0, end]
    if isinstance(path, Approach):
        times.insert(1, abs(path.start_range_m - path.end_range_m) / path.speed_m_per_s)
    for time in sorted(times):
        yield time, float(range_at(path, time))


def _counts(run: Run, chip: Chip) -> dict[str, int]:
    merged = int(run.counts[MERGED] + chip.counts[CHIP_MERGED])
    return {
        "solver_steps": 0,
        "merged_events": merged,
        "repeated_advances": 0,
        "undecided_sounds": int(run.counts[UNDECIDED]),
        "clipped_sounds": int(run.counts[CLIPPED]),
        "undecided_spikes": doubts(chip),
    }
