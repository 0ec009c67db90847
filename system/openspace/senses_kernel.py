"""The compiled senses of the bat in the forest: from echoes to places, from currents to a selection.

A ping's obstacles become echoes, whose delays follow from the bat's own speed v at the ping,

    d = 2 r / (c + v cos(phi)),    phi: bearing from where it flies to

since it meets the echo on its way. What is heard of them, as the options say:

- occlusion: an obstacle in the geometric shadow of a nearer one, of half width asin(radius / r), is silent;
- multipath: sound by way of obstacles i, then j comes from the bearing of j after the way r_i + d_ij + r_j;
  it is heard where s R_MAX^2 b_i b_j >= r_i d_ij r_j, with s (m) what an obstacle scatters to 1 m and b the
  one-way beam e^(-theta^2 / 2 sigma^2): the two-way beam b^2 and 1 / r^2 together give the field of view;
- overlap: an echo less than a call's length after the last one that was heard is not told apart from it.

The range is c d / 2, or what a chip's reader makes of the delay, `reading`; a delay without a reading is an
echo that is missed. The bearing comes from elsewhere: the chip gives none.

A selection on a chip takes the excitations of equation (6) and the risks as currents of `unit` A. Its winner
counts where it comes within `deadline`; the head and body keep what they do otherwise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from chips.selection.kernel import Selection
from chips.selection.noise import SelectionNoise, noisy_decide
from chips.selection.whole_kernel import NOBODY
from circuits.arrays import F64
from circuits.compiled import compiled
from system.openspace.law import ARCS, Arcs
from system.openspace.population import Population, hear_ping
from system.openspace.reader_noise import Reader, next_ping, read
from system.openspace.state import (
    ARC,
    AVOIDED,
    DECIDING,
    ECHO_BEARING,
    ECHO_NUMBER,
    ECHO_RANGE,
    ECHO_SIDE,
    ECHO_X,
    ECHO_Y,
    ECHOES,
    GHOSTS,
    HEARD,
    LAP,
    LATE,
    MASKED,
    MISSED,
    OCCLUDED,
    OTHER,
    PINGS,
    TIES,
    TIME,
    WINNER,
    Flight,
)
from system.openspace.view import add_immediacies

_LEAST_RISK = 0.1e-9  # A, into a port of the selection: its standing current
SILENT, GHOST = -2.0, -1.0  # in the place of an obstacle's number
NO_CHOICE = -2  # of a selection that came too late


class Senses(NamedTuple):
    """How the bat senses and selects, as arrays for the compiled loop.

    exact: 1 for places as they are; occlusion, multipath: 1 to have them; sound_speed: m/s; overlap: s, 0 to
    tell all echoes apart; radius: m, of an obstacle's shadow; strength: m, s above; noise: float64[n], rad,
    of bearings, taken in turn, heard after heard; reading: float64[delays], m, NaN for none, empty for the
    range itself; per_second: entries of it a second of delay; reader: of a chip that makes noise, in place
    of `reading`; population: of a calibrated chip, in place of both; selecting: 1 for the chip's selection;
    unit: A a unit of desirability; deadline: s; margin: ln of the best two merits below which the model is
    unsure; chip_noise: drawn anew for each ping's choice; board: what excitations are multiplied by before
    the chip, float64[ARCS].
    """

    exact: int
    occlusion: int
    multipath: int
    sound_speed: float
    overlap: float
    radius: float
    strength: float
    noise: F64
    reading: F64
    per_second: float
    reader: Reader
    population: Population
    selecting: int
    unit: float
    deadline: float
    margin: float
    chip: Selection
    chip_noise: SelectionNoise
    board: F64


_compiled = compiled()


@_compiled
def collect(f: Flight, n: int, x: float, y: float, bearing: float, number: int) -> int:
    """Note an obstacle's echo: its place (m) in the body's frame, its bearing (rad) from the ping's own.

    Returns how many there are then; beyond the room echoes are missed.
    """
    if n == ECHOES:
        f.counts[MISSED] += 1
        return n
    row = f.echo[n]
    row[ECHO_NUMBER], row[ECHO_SIDE] = number, bearing
    return place_echo(f, n, x, y)


@_compiled
def place_echo(f: Flight, n: int, x: float, y: float) -> int:
    """Note the place (m) of an echo in the body's frame, where there is room; how many there are then."""
    if n == ECHOES:
        return n
    row = f.echo[n]
    row[ECHO_X], row[ECHO_Y] = x, y
    row[ECHO_RANGE], row[ECHO_BEARING] = math.sqrt(x * x + y * y), math.atan2(y, x)
    return n + 1


@_compiled
def end_of_echoes(f: Flight, n: int) -> None:
    """Mark the end of a ping's n echoes."""
    if n < ECHOES:
        f.echo[n, ECHO_RANGE] = math.nan


@_compiled
def _unheard(row: F64) -> None:
    row[ECHO_X] = math.nan


@_compiled
def hear(a: Arcs, s: Senses, f: Flight, n: int) -> int:
    """Make places of n echoes and add their immediacies to `fresh`; returns how many obstacles are heard.

    Where each is heard stays in `echo` (m, in the body's frame), not a number for none.
    """
    _sort(f.echo, n)
    if s.occlusion:
        _shade(s, f, n)
    if s.multipath:
        n = _reflect(a, s, f, n)
        _sort(f.echo, n)
    if s.reader.value.size > 0:
        next_ping(s.reader, f.pose[TIME])
    last, heard = -math.inf, 0
    pace = a.speed[f.counts[ARC]]
    if s.population.on.size > 0:
        _hear_all(s, f, n, pace)
    for k in range(n):
        row = f.echo[k]
        if row[ECHO_NUMBER] == SILENT:
            f.counts[OCCLUDED] += 1
            _unheard(row)
            continue
        delay = _delay(s, row, pace)
        if s.overlap > 0.0 and delay < last + s.overlap:
            f.counts[MASKED] += 1
            _unheard(row)
            continue
        last = delay
        distance = _read(s, k, delay)
        if math.isnan(distance):
            f.counts[MISSED] += 1
            _unheard(row)
            continue
        heard += _take(a, s, f, row, distance)
    end_of_echoes(f, n)
    return heard


@_compiled
def _take(a: Arcs, s: Senses, f: Flight, row: F64, distance: float) -> int:
    """Count an echo that was heard, and what it blocks; whether it is of an obstacle."""
    bearing = row[ECHO_BEARING] + s.noise[f.counts[HEARD] % s.noise.size]
    f.counts[HEARD] += 1
    row[ECHO_X], row[ECHO_Y] = distance * math.cos(bearing), distance * math.sin(bearing)
    add_immediacies(a, row[ECHO_X], row[ECHO_Y], f.fresh)
    number = int(row[ECHO_NUMBER])
    if number < 0:
        f.counts[GHOSTS] += 1
        return 0
    if f.met[number] <= f.counts[LAP]:
        f.met[number] = f.counts[LAP] + 1
        f.counts[AVOIDED] += 1
    return 1


@_compiled
def _delay(s: Senses, row: F64, pace: float) -> float:
    """Delay (s) of an echo for a bat of a pace, m/s."""
    delay: float = 2.0 * row[ECHO_RANGE] / (s.sound_speed + pace * math.cos(row[ECHO_BEARING]))
    return delay


@_compiled
def _hear_all(s: Senses, f: Flight, n: int, pace: float) -> None:
    """Let the population hear a ping: the echoes that sound, in the order of their delays."""
    p, found = s.population, 0
    for k in range(n):
        if f.echo[k, ECHO_NUMBER] == SILENT:
            continue
        delay, j = _delay(s, f.echo[k], pace), found
        while j > 0 and p.echo[j - 1, 0] > delay:
            p.echo[j, 0], p.row[j] = p.echo[j - 1, 0], p.row[j - 1]
            j -= 1
        p.echo[j, 0], p.row[j] = delay, k
        found += 1
    hear_ping(p, f.pose[TIME], found)
    for j in range(found):
        p.reading[p.row[j]] = p.echo[j, 1]


@_compiled
def _read(s: Senses, k: int, delay: float) -> float:
    """Range (m) of echo k, of a delay (s); NaN where the chip has none."""
    if s.population.on.size > 0:
        found: float = 0.5 * s.sound_speed * s.population.reading[k]
        return found
    if s.reader.value.size > 0:
        return 0.5 * s.sound_speed * read(s.reader, delay)
    if s.reading.size == 0:
        return 0.5 * s.sound_speed * delay
    k = int(delay * s.per_second + 0.5)
    return s.reading[k] if k < s.reading.size else math.nan


@_compiled
def _sort(echo: F64, n: int) -> None:
    """Put echoes in the order of their ranges."""
    for k in range(1, n):
        j = k
        while j > 0 and echo[j, ECHO_RANGE] < echo[j - 1, ECHO_RANGE]:
            for column in range(echo.shape[1]):
                kept = echo[j, column]
                echo[j, column] = echo[j - 1, column]
                echo[j - 1, column] = kept
            j -= 1


@_compiled
def _shade(s: Senses, f: Flight, n: int) -> None:
    """Silence obstacles in the shadow of nearer ones."""
    for k in range(1, n):
        for j in range(k):
            half = math.asin(min(1.0, s.radius / max(f.echo[j, ECHO_RANGE], s.radius)))
            if abs(f.echo[k, ECHO_SIDE] - f.echo[j, ECHO_SIDE]) < half:
                f.echo[k, ECHO_NUMBER] = SILENT
                break


@_compiled
def _reflect(a: Arcs, s: Senses, f: Flight, n: int) -> int:
    """Add what comes by way of two obstacles; returns how many echoes there are then."""
    found = n
    loud = s.strength * a.max_range * a.max_range
    for i in range(n):
        for j in range(n):
            if i == j or f.echo[i, ECHO_NUMBER] == SILENT or f.echo[j, ECHO_NUMBER] == SILENT:
                continue
            one, two = f.echo[i], f.echo[j]
            apart = math.hypot(one[ECHO_X] - two[ECHO_X], one[ECHO_Y] - two[ECHO_Y])
            off = (one[ECHO_SIDE] ** 2 + two[ECHO_SIDE] ** 2) / (2.0 * a.view_sigma * a.view_sigma)
            if loud * math.exp(-off) < one[ECHO_RANGE] * apart * two[ECHO_RANGE] or found == ECHOES:
                continue
            row = f.echo[found]
            row[ECHO_X], row[ECHO_Y], row[ECHO_SIDE] = two[ECHO_X], two[ECHO_Y], two[ECHO_SIDE]
            row[ECHO_BEARING] = two[ECHO_BEARING]
            row[ECHO_RANGE] = 0.5 * (one[ECHO_RANGE] + apart + two[ECHO_RANGE])
            row[ECHO_NUMBER] = GHOST
            found += 1
    return found


@_compiled
def select_on_chip(a: Arcs, s: Senses, f: Flight) -> tuple[int, bool]:
    """Winner by the chip, -2 where it comes too late, and whether it is below the emergency's threshold.

    `wish` has the excitations of equation (6), without the memory's inhibition.
    """
    excite, risk = f.current[0], f.current[1]
    suppression = a.spread[0, 0]
    for p in range(ARCS):
        excite[p] = s.unit * s.board[p] * max(f.wish[p], 0.0)
        risk[p] = max(s.unit * suppression * f.risk[p], _LEAST_RISK)
    winner, time, margin = noisy_decide(s.chip, s.chip_noise, f.counts[PINGS], excite, risk, f.current[2:6])
    if winner == NOBODY:
        return 0, True
    if margin <= s.margin:
        f.counts[TIES] += 1
    f.pose[DECIDING] += min(time, s.deadline)
    if not time <= s.deadline:
        f.counts[LATE] += 1
        return NO_CHOICE, False
    return winner, bool(f.current[2, winner] < s.unit * a.emergency_below)


@_compiled
def note_difference(f: Flight, winner: int) -> None:
    """Count a choice that is not that of the desirabilities themselves."""
    if winner != f.counts[WINNER]:
        f.counts[OTHER] += 1
