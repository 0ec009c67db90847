"""Flights of a bat through forests until a collision: runs, what ends them, and what is counted.

Wen & Horiuchi 2022, section 4.1: a run ends by a collision, after 2,500 s without a crossing of the left
border (trapped), or after 250,000 s. After the latter two another run begins, in another forest, and the
avoided obstacles add up: a sample spans as many runs as it takes to a collision. Avoided are the obstacles
that were detected and not collided with, each once until the bat has crossed the left border.

Ours: a crossing is new where the bat has never been farther left, so that flying to and fro across the border
makes no new forest of an old one; a run begins at a place drawn anywhere with nothing within `CLEAR`, heading
left; a sample may end undecided, after a number of pings.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.meaning import meanings
from system.openspace.kernel import COLLIDED, GOING, OVER, TRAPPED, fly
from system.openspace.law import DIRECTIONS, Arcs
from system.openspace.map import OBSTACLES, SIDE, Forest, cells_of, clearance, plant, read_forest
from system.openspace.moving import Moving, still
from system.openspace.senses import EXACT, begin_again
from system.openspace.senses_kernel import Senses
from system.openspace.state import (
    AVOIDED,
    DECIDING,
    EMERGENCIES,
    GHOSTS,
    HEARD,
    LAP,
    LAPS_X,
    LATE,
    LOGGED,
    MASKED,
    MISSED,
    OCCLUDED,
    OTHER,
    PINGS,
    SCANS,
    TIES,
    Flight,
    new_flight,
)
from system.openspace.state import DISTANCE as WAY
from system.openspace.state import TIME as NOW

CLEAR = 1.0  # m about a drawn start; ours
_GETS_ON = 0.1  # of its full speed, that a bat must come on to the left; ours
SUCCESS = (
    "it flies all its pings without a collision and without being trapped, and comes on to the left at"
    f" {100.0 * _GETS_ON:g} % of its full speed at least"
)
_WORDS = {GOING: "undecided", COLLIDED: "collided", TRAPPED: "trapped", OVER: "over"}
_STARTS = 1000  # places that are tried
_AT_ONCE = 200_000  # pings between signs of life


@dataclass(frozen=True, slots=True)
class Run:
    """One flight.

    forest : where it went; start, end : places, m; ended : as `undecided` or `collided`; log : float64[pings,
    8], its columns as `system.openspace.state` has them.
    """

    forest: Forest
    start: tuple[float, float]
    ended: str
    log: F64
    end: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Sample:
    """What was counted from the start to a collision, or to as many pings as were allowed.

    Of echoes, with ranges that are not exact: heard, missed by the chip, masked by an earlier one, occluded,
    and heard by way of two obstacles. Of selections on a chip: late, ties that its model cannot tell, choices
    that the desirabilities themselves would not have made, and the time (s) that they took. progress_m: how
    far the way led to the left.

    avoided : obstacles that were detected and not collided with.
    collided : whether it ended by a collision.
    time_s : of all flights, s.
    distance_m : way of all flights, m.
    laps : crossings of the left border.
    runs : how many flights it took.
    trapped : flights that ended without a new crossing for long.
    emergencies : times that it turned round.
    scans : pings after which only the head turned.
    ghosts : echoes by way of two obstacles.
    other_choices : selections that the desirabilities would not have made.
    deciding_s : time that selections took, s.
    """

    avoided: int
    collided: bool
    pings: int
    time_s: float
    distance_m: float
    laps: int
    runs: int
    trapped: int
    emergencies: int
    scans: int
    heard: int = 0
    missed: int = 0
    masked: int = 0
    occluded: int = 0
    ghosts: int = 0
    late: int = 0
    ties: int = 0
    other_choices: int = 0
    deciding_s: float = 0.0
    progress_m: float = 0.0


Planter = Callable[[np.random.Generator], Forest]


def planter(obstacles: int = OBSTACLES, path: str | None = None) -> Planter:
    """Return what plants a new forest of so many obstacles for every run, or gives that of a file."""
    if path is None:
        return lambda random: plant(obstacles, random)
    forest = read_forest(path)
    return lambda _: forest


def fly_sample(
    arcs: Arcs,
    forests: Planter,
    key: tuple[int, ...],
    pings: int,
    start: tuple[float, float] | None = None,
    rows: int = 0,
    progress: Callable[[float], None] | None = None,
    senses: Senses | Moving = EXACT,
) -> tuple[Sample, Run]:
    """Fly until a collision, or until so many pings are made.

    Parameters
    ----------
    key : of the forests and starts; a run adds its number.
    start : of every run, m; drawn unless given.
    rows : pings of the first run that are kept in its log.
    senses : exact ranges and the ideal selection unless given; where they move, a ping has its time's.

    Returns the sample and its first run. Raises `ParameterError` for a start inside a zone of collision.
    """
    if pings < 1:
        raise ParameterError(f"pings: {pings}, must be at least 1")
    moving = senses if isinstance(senses, Moving) else still(senses)
    first, flight, ended = _fly_run(arcs, forests, (*key, 0), pings, start, rows, progress, moving)
    flights, used, trapped = [flight], int(flight.counts[PINGS]), int(ended == TRAPPED)
    left = first.start[0] - float(flight.pose[LAPS_X])
    while ended != COLLIDED and used < pings:
        later = moving.after(sum(float(f.pose[NOW]) for f in flights))
        again, flight, ended = _fly_run(
            arcs, forests, (*key, len(flights)), pings - used, start, 0, None, later
        )
        used += int(flight.counts[PINGS])
        trapped += ended == TRAPPED
        left += again.start[0] - float(flight.pose[LAPS_X])
        flights.append(flight)
        if progress is not None:
            progress(used / pings)
    return _sum_up(flights, trapped, left, collided=ended == COLLIDED), first


def gets_on(progress: float, straight: float) -> bool:
    """Whether a bat came on to the left, by `progress` (m), where it could have flown `straight` (m)."""
    return progress >= _GETS_ON * straight


def ended_because(pings: int, *, collided: bool) -> str:
    """Say why a sample or flight of so many pings ended."""
    return "collided with an obstacle" if collided else f"all {pings} pings flown"


WAY_KEYS = meanings("""
time_s          number[]    s    times of the pings
path_m          number[][]  m    places at the pings and at the end, east and north
heading_rad     number[]    rad  headings at the pings, from east to north
ping_direction  integer[]   -    number of the direction of each ping, from the left
""")  # of `entries_of`
FLIGHT_KEYS = {
    **meanings("""
zone_m       number      m  distance from an obstacle at which it counts as touched
start_m      number[]    m  where it began, east and north
ended        string      -  why it ended
obstacles_m  number[][]  m  places of the obstacles, east and north
"""),
    **WAY_KEYS,
}  # of `flight_entries`


def entries_of(log: F64, path: F64) -> dict[str, Any]:
    """Return the entries of JSON of a way that begins with the columns of `system.openspace.state`.

    log : float64[n, 5 or more]; path : float64[n + 1, 2], places (m) of the log's rows and of the end.
    """
    return {
        "time_s": log[:, 0],
        "path_m": path,
        "heading_rad": log[:, 3],
        "ping_direction": log[:, 4].astype(int),
    }


def flight_entries(
    forest: Forest, zone: float, start: tuple[float, float], ended: str, log: F64, path: F64
) -> dict[str, Any]:
    """Return the entries of JSON of a flight from `start` (m), which ended for a reason, and its forest.

    zone : of collision, m; log, path : as of `entries_of`.
    """
    entries = {"zone_m": zone, "start_m": start, "ended": ended, "obstacles_m": forest.place}
    return {**entries, **entries_of(log, path)}


def margin_of(arcs: Arcs) -> float:
    """How far (m) a bat may look or fly beyond a border before it is put back."""
    return max(arcs.max_range, float(arcs.speed.max()) * arcs.step + arcs.zone)


def _fly_run(
    arcs: Arcs,
    forests: Planter,
    key: tuple[int, ...],
    pings: int,
    start: tuple[float, float] | None,
    rows: int,
    progress: Callable[[float], None] | None,
    senses: Moving,
) -> tuple[Run, Flight, int]:
    """Fly one run, at most so many pings; also its state and how it ended."""
    random = np.random.default_rng(key)
    forest = forests(random)
    x, y = begin(arcs, forest, random, start)
    cells = cells_of(forest, margin_of(arcs))
    flight = new_flight(x, y, -math.pi, DIRECTIONS, len(forest.place), rows)
    now = senses.at(0.0)
    begin_again(now)
    ended, used = GOING, 0
    while ended == GOING and used < pings:
        time = float(flight.pose[NOW])
        now = senses.at(time)
        ended = fly(arcs, now, cells, flight, senses.pings(time, min(_AT_ONCE, pings - used)))
        used = int(flight.counts[PINGS])
        if progress is not None:
            progress(used / pings)
    end = float(flight.pose[0]), float(flight.pose[1])
    return Run(forest, (x, y), _WORDS[ended], flight.log[: flight.counts[LOGGED]], end), flight, ended


def begin(
    arcs: Arcs, forest: Forest, random: np.random.Generator, start: tuple[float, float] | None
) -> tuple[float, float]:
    """The start of a run: the one that is given, or a clear one that is drawn.

    Raises `ParameterError` for one inside a zone of collision, or where no clear one was found.
    """
    if start is not None:
        room = clearance(forest, *start)
        if room < arcs.zone:
            raise ParameterError(
                f"start: {start[0]:g},{start[1]:g}, an obstacle is {room:.3g} m away, must be at least"
                f" {arcs.zone:g} m, the zone of collision; start elsewhere"
            )
        return start
    for _ in range(_STARTS):
        x, y = SIDE * random.random(), SIDE * random.random()
        if clearance(forest, x, y) >= max(CLEAR, arcs.zone):
            return x, y
    raise ParameterError(f"{forest.name}: no start with {CLEAR:g} m free about it was found; give `start`")


def _sum_up(done: list[Flight], trapped: int, left: float, *, collided: bool) -> Sample:
    def total(column: int) -> int:
        return sum(int(f.counts[column]) for f in done)

    return Sample(
        avoided=total(AVOIDED),
        collided=collided,
        pings=total(PINGS),
        time_s=sum(float(f.pose[NOW]) for f in done),
        distance_m=sum(float(f.pose[WAY]) for f in done),
        laps=total(LAP),
        runs=len(done),
        trapped=trapped,
        emergencies=total(EMERGENCIES),
        scans=total(SCANS),
        heard=total(HEARD),
        missed=total(MISSED),
        masked=total(MASKED),
        occluded=total(OCCLUDED),
        ghosts=total(GHOSTS),
        late=total(LATE),
        ties=total(TIES),
        other_choices=total(OTHER),
        deciding_s=sum(float(f.pose[DECIDING]) for f in done),
        progress_m=left,
    )
