"""Reflectors that a sonar hears, and how far they are at any time.

A target is a range r(t) from the sonar head, which rests at range 0, and a strength: the amplitude of
its echo relative to a reference reflector, both at 1 m. Only range matters to a narrowband sonar with
one speaker, so a head that flies at a resting target and a target that flies at a resting head are the
same thing here.

Source: Cheely & Horiuchi 2003, section 4, gives no scene; the numbers of `default_scene` are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import assert_never

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.option import option, required
from system.rows import read_rows, refusal, shortened

MAX_SPEED = 100.0  # m/s, ours: well below sound, so an echo's delay has one solution
_START_RANGE = 4.0  # m, ours
_END_RANGE = 0.5  # m, ours
_APPROACH_SPEED = 1.0  # m/s, ours
_TARGET_STRENGTH = 1.0  # relative to the reference reflector, ours
_CLUTTER_GAP = 1.0  # m behind the target, ours
_CLUTTER_STRENGTH = 1.5  # relative to the reference reflector, ours: louder than the target at equal range


@dataclass(frozen=True, slots=True)
class ConstantVelocity:
    """A range that changes at constant velocity: r(t) = range_m + velocity_m_per_s * t.

    Attributes
    ----------
    range_m : float
        Range at t = 0, m, > 0.
    velocity_m_per_s : float
        Velocity, m/s, at most `MAX_SPEED` either way; a negative one approaches.
    """

    range_m: float
    velocity_m_per_s: float = 0.0

    def __post_init__(self) -> None:
        _require_positive("constant_velocity.range_m", self.range_m, "m")
        _require_speed("constant_velocity.velocity_m_per_s", self.velocity_m_per_s)


@dataclass(frozen=True, slots=True)
class Waypoints:
    """A range that goes through points in straight lines, and is held before the first and after the last.

    Attributes
    ----------
    time_s : tuple of float
        Strictly increasing times in s, shape (n,), n >= 1.
    range_m : tuple of float
        Ranges in m, shape (n,), > 0, no step faster than `MAX_SPEED`.

    Raises
    ------
    ParameterError
        A time or range breaks its rule, or there are not as many of each.
    """

    time_s: tuple[float, ...]
    range_m: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.time_s or len(self.time_s) != len(self.range_m):
            raise ParameterError(
                f"waypoints.time_s: {len(self.time_s)} times for {len(self.range_m)} ranges, must be as many "
                "of each and at least one; add or remove waypoints"
            )
        for time, distance in zip(self.time_s, self.range_m, strict=True):
            _require_finite("waypoints.time_s", time, "s")
            _require_positive("waypoints.range_m", distance, "m")
        for before, after in pairwise(zip(self.time_s, self.range_m, strict=True)):
            if after[0] <= before[0]:
                raise ParameterError(
                    f"waypoints.time_s: {after[0]:g} s, must be later than {before[0]:g} s; "
                    "sort the waypoints"
                )
            _require_speed("waypoints.range_m", _step_speed(before, after))


@dataclass(frozen=True, slots=True)
class Approach:
    """A range that changes at constant speed from t = 0 on, and then rests.

    Attributes
    ----------
    start_range_m, end_range_m : float
        First and last range, m, > 0; a larger last one recedes.
    speed_m_per_s : float
        Speed, m/s, > 0, at most `MAX_SPEED`.
    """

    start_range_m: float
    end_range_m: float
    speed_m_per_s: float

    def __post_init__(self) -> None:
        _require_positive("approach.start_range_m", self.start_range_m, "m")
        _require_positive("approach.end_range_m", self.end_range_m, "m")
        _require_positive("approach.speed_m_per_s", self.speed_m_per_s, "m/s")
        _require_speed("approach.speed_m_per_s", self.speed_m_per_s)


Trajectory = ConstantVelocity | Waypoints | Approach


@dataclass(frozen=True, slots=True)
class Target:
    """One reflector that a sonar hears.

    Attributes
    ----------
    name : str
        What reports, pictures and errors call it; not blank.
    trajectory : Trajectory
        Its range over time.
    target_strength : float
        Echo amplitude over that of the reference reflector, both at 1 m: a ratio > 0.

    Raises
    ------
    ParameterError
        The name is blank, or the strength is not above 0.
    """

    name: str
    trajectory: Trajectory
    target_strength: float = _TARGET_STRENGTH

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise ParameterError(f"target.name: {self.name!r}, must not be blank; name the target")
        _require_positive(f"{self.name}.target_strength", self.target_strength, "")


def range_at(trajectory: Trajectory, time_s: ArrayLike) -> F64:
    """Range in m at the times `time_s` in s, in their shape.

    Raises
    ------
    ParameterError
        A `ConstantVelocity` has reached the sonar head, where range has no meaning.
    """
    time = np.asarray(time_s, dtype=np.float64)
    match trajectory:
        case ConstantVelocity():
            distance = np.asarray(trajectory.range_m + trajectory.velocity_m_per_s * time)
            _require_in_front(distance, time)
            return distance
        case Waypoints():
            return np.asarray(np.interp(time, trajectory.time_s, trajectory.range_m))
        case Approach():
            start, end = trajectory.start_range_m, trajectory.end_range_m
            travelled = trajectory.speed_m_per_s * np.maximum(time, 0.0)
            distance = np.asarray(start + math.copysign(1.0, end - start) * travelled)
            return distance.clip(min(start, end), max(start, end))
        case _:
            assert_never(trajectory)


def describe(target: Target) -> str:
    """One line that says what the target does, and that its range is held where its trajectory ends."""
    trajectory = target.trajectory
    match trajectory:
        case ConstantVelocity():
            path = f"{trajectory.range_m:g} m at 0 s, {trajectory.velocity_m_per_s:+g} m/s"
        case Waypoints():
            first, last = trajectory.range_m[0], trajectory.range_m[-1]
            path = (
                f"{len(trajectory.time_s)} waypoints, held at {first:g} m before {trajectory.time_s[0]:g} s "
                f"and at {last:g} m after {trajectory.time_s[-1]:g} s"
            )
        case Approach():
            start, end = trajectory.start_range_m, trajectory.end_range_m
            stop = abs(end - start) / trajectory.speed_m_per_s
            path = (
                f"{start:g} m to {end:g} m at {trajectory.speed_m_per_s:g} m/s, "
                f"held at {end:g} m after {stop:g} s"
            )
        case _:
            assert_never(trajectory)
    return f"{target.name}: {path}, strength {target.target_strength:g}"


def default_scene(
    start_range: float = _START_RANGE,
    end_range: float = _END_RANGE,
    speed: float = _APPROACH_SPEED,
    target_strength: float = _TARGET_STRENGTH,
    clutter_gap: float = _CLUTTER_GAP,
    clutter_strength: float = _CLUTTER_STRENGTH,
) -> tuple[Target, Target]:
    """Make one target that is closed in on, and clutter that stays a fixed gap behind it.

    The head flies at both, so the clutter moves along: its range is always the target's plus the gap. It
    is the louder reflector, so that ranging the first echo and ranging the loudest differ.

    Parameters
    ----------
    start_range, end_range
        Range of the target at first and when it comes to rest, m.
    speed
        Speed of the head, m/s.
    target_strength, clutter_strength
        Strengths relative to the reference reflector.
    clutter_gap
        Distance of the clutter behind the target, m, > 0.
    """
    _require_positive("scene.clutter_gap", clutter_gap, "m")
    target = Approach(start_range, end_range, speed)
    clutter = Approach(start_range + clutter_gap, end_range + clutter_gap, speed)
    return Target("target", target, target_strength), Target("clutter", clutter, clutter_strength)


def read_targets(path: str | Path) -> tuple[Target, ...]:
    """Read targets from the CSV file at `path`, with the header `target,time_s,range_m[,strength]`.

    Rows with the same name are one target's waypoints, in the order of time; targets come in the order in
    which they first appear. Each range is held before its first and after its last row. Blank lines are
    skipped.

    Raises
    ------
    DataError
        The file cannot be read, or a row breaks a rule; the text names file and row.
    """
    found: dict[str, list[_Row]] = {}
    for line, row in read_rows(path, _Row):
        earlier = found.setdefault(row.target, [])
        if earlier:
            _check_after(path, line, earlier[-1], row)
        earlier.append(row)
    return tuple(Target(name, _waypoints(rows), rows[0].strength) for name, rows in found.items())


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of a file of targets."""

    target: str = required("name of the target")
    time_s: float = required("time of the waypoint", unit="s")
    range_m: float = required("range from the sonar head", unit="m", above=0.0)
    strength: float = option(
        _TARGET_STRENGTH, "strength over that of the reference reflector", unit="", above=0.0
    )


def _check_after(path: str | Path, line: int, before: _Row, row: _Row) -> None:
    """Refuse a row that does not go on where the one before of the same target ended."""
    name = shortened(row.target)
    if row.time_s <= before.time_s:
        rule = f"must be later than {before.time_s:g} s, the row before of {name}"
        raise refusal(path, line, "time_s", f"{row.time_s:g}", rule, "sort the rows of a target by time")
    if abs(_step_speed((before.time_s, before.range_m), (row.time_s, row.range_m))) > MAX_SPEED:
        rule = f"must be reached at no more than {MAX_SPEED:g} m/s"
        raise refusal(path, line, "range_m", f"{row.range_m:g}", rule, "add rows or correct the range")
    if row.strength != before.strength:
        rule = f"must be {before.strength:g} as in the rows before of {name}"
        raise refusal(path, line, "strength", f"{row.strength:g}", rule, "give a target one strength")


def _waypoints(rows: list[_Row]) -> Waypoints:
    return Waypoints(tuple(row.time_s for row in rows), tuple(row.range_m for row in rows))


def _step_speed(before: tuple[float, float], after: tuple[float, float]) -> float:
    return (after[1] - before[1]) / (after[0] - before[0])


def _require_finite(where: str, value: float, unit: str) -> None:
    if not math.isfinite(value):
        raise ParameterError(f"{where}: {value:g} {unit}, must be finite; give a number".replace("  ", " "))


def _require_positive(where: str, value: float, unit: str) -> None:
    _require_finite(where, value, unit)
    if value <= 0.0:
        raise ParameterError(f"{where}: {value:g} {unit}".rstrip() + ", must be > 0; give a positive value")


def _require_speed(where: str, value: float) -> None:
    _require_finite(where, value, "m/s")
    if abs(value) > MAX_SPEED:
        raise ParameterError(
            f"{where}: {value:g} m/s, must be at most {MAX_SPEED:g} m/s either way; slow the target down"
        )


def _require_in_front(distance: F64, time: F64) -> None:
    behind = distance <= 0.0
    if np.any(behind):
        when = float(time[behind].flat[0])
        raise ParameterError(
            f"constant_velocity.range_m: {float(distance[behind].flat[0]):g} m at {when:g} s, must be > 0; "
            "end the run earlier or use an Approach that stops"
        )
