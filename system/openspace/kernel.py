"""The compiled loop of Curved Openspace: ping, evaluate, select, turn, and fly on, again and again.

At each time step the bat pings in the head's direction, updates the memory by equation (4), selects the arc
of the largest desirability by equation (6), directs the head, and, where the arc's direction was sensed of
late, the body; then it flies along its arc until the next ping. Distances along arcs, touches of the zone of
collision and the field of view are exact, without steps in space.

By the paper's law alone a bat may turn round for ever: an emergency forgets what was ahead, and on the way
back all arcs are barred again. In 3 of 100 flights by exact ranges (4,000 pings, seeds below 100) half of all
pings are such turns. With `escape` it turns round only so often in a row; after that it flies the most
desirable arc all the same, barred as it is (ours, and none where a figure of the paper is made again).
"""

from __future__ import annotations

import math

from circuits.compiled import compiled
from system.openspace.choice import add_goal, aimed_arc, best, excite, inhibit, remember
from system.openspace.law import ARCS, NO_ESCAPE, Arcs
from system.openspace.map import CELL, SIDE, Cells
from system.openspace.senses_kernel import (
    NO_CHOICE,
    Senses,
    collect,
    end_of_echoes,
    hear,
    note_difference,
    place_echo,
    select_on_chip,
)
from system.openspace.state import (
    ARC,
    AVOIDED,
    CROSSED,
    DISTANCE,
    EMERGENCIES,
    HEAD,
    HEADING,
    HIT,
    LAP,
    LAPS_X,
    LOGGED,
    NEVER,
    PINGED,
    PINGS,
    SCANNING,
    SCANS,
    SEEN,
    TIME,
    TURNED,
    TURNS,
    WINNER,
    Flight,
    X,
    Y,
)
from system.openspace.view import add_immediacies, blocked_at, in_view

GOING, COLLIDED, TRAPPED, OVER = range(4)  # how a flight stands
TRAPPED_AFTER = 2500.0  # s without a new crossing of the left border; the paper's
LONGEST = 250_000.0  # s of a run; the paper's

_HALVINGS = 50  # of the way to a touch
ROW = 10  # pings between two emergencies up to which they are of one trap; ours: 2 s, some 2 m of way

_compiled = compiled()
_inlined = compiled(forceinline=True)


@_compiled
def fly(a: Arcs, s: Senses, c: Cells, f: Flight, pings: int) -> int:
    """Fly until something happens, at most so many pings; returns `GOING` or why it ended."""
    for _ in range(pings):
        ping(a, s, c, f)
        choose(a, s, f)
        if advance(a, c, f):
            return COLLIDED
        if f.pose[TIME] - f.pose[CROSSED] >= TRAPPED_AFTER:
            return TRAPPED
        if f.pose[TIME] >= LONGEST:
            return OVER
    return GOING


@_compiled
def ping(a: Arcs, s: Senses, c: Cells, f: Flight) -> None:
    """Ping in the head's direction, and update the memory by equation (4)."""
    head = f.counts[HEAD]
    for p in range(ARCS):
        f.fresh[p] = 0.0
    _look(a, s, c, f, head)
    decay = 0.0 if f.counts[SCANNING] else a.decay
    remember(f.risk, f.fresh, a.group, head, decay, a.inhibition, a.max_risk)
    f.sensed[head], f.counts[PINGED] = f.pose[TIME], head
    f.counts[PINGS] += 1


@_compiled
def _look(a: Arcs, s: Senses, c: Cells, f: Flight, head: int) -> None:
    """Find the obstacles in the field of view: count them, and add their immediacies to `fresh`."""
    heading = f.pose[HEADING]
    turn = heading + a.direction[head]
    ahead_x, ahead_y = math.cos(turn), math.sin(turn)
    body_x, body_y = math.cos(heading), math.sin(heading)
    far_x, far_y = a.max_range * ahead_x, a.max_range * ahead_y
    wide_x = abs(a.view_half_width * ahead_y) + a.view_behind
    wide_y = abs(a.view_half_width * ahead_x) + a.view_behind
    x0, y0 = f.pose[X], f.pose[Y]
    left, right = _columns(c, x0 + min(0.0, far_x) - wide_x, x0 + max(0.0, far_x) + wide_x)
    low, high = _columns(c, y0 + min(0.0, far_y) - wide_y, y0 + max(0.0, far_y) + wide_y)
    f.counts[SEEN], echoes = 0, 0
    for row in range(low, high + 1):
        for k in range(c.begin[row, left], c.begin[row, right + 1]):
            dx, dy = c.x[k] - x0, c.y[k] - y0
            if not in_view(a, ahead_x * dx + ahead_y * dy, ahead_x * dy - ahead_y * dx):
                continue
            if not s.exact:
                side = math.atan2(ahead_x * dy - ahead_y * dx, ahead_x * dx + ahead_y * dy)
                x, y = body_x * dx + body_y * dy, body_x * dy - body_y * dx
                echoes = collect(f, echoes, x, y, side, c.number[k])
                continue
            f.counts[SEEN] += 1
            if f.met[c.number[k]] <= f.counts[LAP]:
                f.met[c.number[k]] = f.counts[LAP] + 1
                f.counts[AVOIDED] += 1
            x, y = body_x * dx + body_y * dy, body_x * dy - body_y * dx
            echoes = place_echo(f, echoes, x, y)
            add_immediacies(a, x, y, f.fresh)
    if s.exact or not echoes:
        end_of_echoes(f, echoes)
    else:
        f.counts[SEEN] = hear(a, s, f, echoes)


@_inlined
def _columns(c: Cells, low: float, high: float) -> tuple[int, int]:
    """First and last cell of a stretch (m), kept inside the list."""
    last = c.begin.shape[0] - 1
    first = int((low + c.margin) / CELL)
    return min(max(first, 0), last), min(max(int((high + c.margin) / CELL), 0), last)


@_compiled
def choose(a: Arcs, s: Senses, f: Flight) -> None:
    """Select the arc by equation (6); turn head and body, or turn round."""
    _excite(a, f)
    winner, emergency = 0, False
    if s.selecting:
        winner, emergency = select_on_chip(a, s, f)
    inhibit(f.wish, f.risk, a.spread)
    largest = best(f.wish)
    f.counts[WINNER] = largest
    if not s.selecting:
        winner, emergency = largest, f.wish[largest] < a.emergency_below
    elif winner == NO_CHOICE:
        return
    else:
        note_difference(f, winner)
    if emergency and not _trapped(a, f):
        _turn_round(a, f)
    else:
        _follow(a, f, winner)


@_compiled
def _trapped(a: Arcs, f: Flight) -> bool:
    """Note an emergency; whether it is one more than the turns that are made in a row."""
    again = f.counts[PINGS] - f.counts[TURNED] <= ROW
    f.counts[TURNS] = f.counts[TURNS] + 1 if again else 1
    f.counts[TURNED] = f.counts[PINGS]
    if a.escape == NO_ESCAPE or f.counts[TURNS] <= a.escape:
        return False
    f.counts[TURNS] = 0
    return True


@_compiled
def _follow(a: Arcs, f: Flight, winner: int) -> None:
    """Turn the head to the winner, and the body where its direction was sensed of late."""
    f.counts[WINNER] = winner
    group = a.group[winner]
    f.counts[HEAD] = group
    if f.pose[TIME] - f.sensed[group] <= a.recency:
        f.counts[ARC], f.counts[SCANNING] = winner, 0
    else:
        f.counts[SCANS] += 1
        f.counts[SCANNING] = 1


@_compiled
def _excite(a: Arcs, f: Flight) -> None:
    """Terms of the desirability without the memory; the goal lies due west."""
    excite(f.wish, a.bias, a.hold[f.counts[ARC]], a.group, f.counts[HEAD], a.ping_bias)
    add_goal(f.wish, goal_arc(a, f.pose[HEADING]), a.goal_gain, a.goal_sigma)


@_compiled
def goal_arc(a: Arcs, heading: float) -> float:
    """p_g, which need not be whole: where the goal lies, due west, from a heading (rad)."""
    return aimed_arc(math.pi - heading, a.arcs_per_rad, ARCS)


@_compiled
def _turn_round(a: Arcs, f: Flight) -> None:
    """Emergency: fly back the way that it came, and forget what was ahead (the forgetting is ours)."""
    f.pose[HEADING] -= math.pi if f.pose[HEADING] > 0.0 else -math.pi
    f.counts[ARC] = ARCS - 1 - f.counts[ARC]  # on the same circle, the other way round
    f.counts[HEAD] = a.group[f.counts[ARC]]
    f.counts[SCANNING] = 0
    f.counts[EMERGENCIES] += 1
    for p in range(ARCS):
        f.risk[p] = 0.0
    for d in range(f.sensed.size):
        f.sensed[d] = NEVER


@_compiled
def advance(a: Arcs, c: Cells, f: Flight) -> bool:
    """Fly to the next ping; whether an obstacle came into the zone of collision, where it then stays."""
    arc = f.counts[ARC]
    if f.counts[LOGGED] < f.log.shape[0]:
        row = f.log[f.counts[LOGGED]]
        row[0], row[1], row[2], row[3] = f.pose[TIME], f.pose[X], f.pose[Y], f.pose[HEADING]
        row[4], row[5], row[6], row[7] = f.counts[PINGED], arc, f.counts[WINNER], f.counts[SCANNING]
        f.counts[LOGGED] += 1
    k, way = a.curvature[arc], a.speed[arc] * a.step
    touched = _touch(a, c, f, k, way)
    _move(f, k, touched, a.step * touched / way if touched < way else a.step)
    return bool(f.counts[HIT] >= 0)


@_compiled
def _touch(a: Arcs, c: Cells, f: Flight, k: float, way: float) -> float:
    """How far (m) the bat comes along `way`; `HIT` is the obstacle that it touches first, or -1."""
    half = 0.5 * k * way
    chord = way if abs(half) < 1e-9 else way * math.sin(half) / half
    end_x, end_y = chord * math.cos(half), chord * math.sin(half)
    ahead_x, ahead_y = math.cos(f.pose[HEADING]), math.sin(f.pose[HEADING])
    x0, y0 = f.pose[X], f.pose[Y]
    to_x, to_y = ahead_x * end_x - ahead_y * end_y, ahead_y * end_x + ahead_x * end_y
    # an arc of up to half a circle is nowhere farther from its chord than |k| way^2 / 8
    room = a.zone + (0.125 * abs(k) * way * way if abs(k) * way < math.pi else way)
    left, right = _columns(c, x0 + min(0.0, to_x) - room, x0 + max(0.0, to_x) + room)
    low, high = _columns(c, y0 + min(0.0, to_y) - room, y0 + max(0.0, to_y) + room)
    first = way
    for row in range(low, high + 1):
        for i in range(c.begin[row, left], c.begin[row, right + 1]):
            dx, dy = c.x[i] - x0, c.y[i] - y0
            x, y = ahead_x * dx + ahead_y * dy, ahead_x * dy - ahead_y * dx
            s = blocked_at(k, way, end_x, end_y, x, y, a.zone)
            if s < 0.0:
                continue
            s = _first_touch(k, s, x, y, a.zone)
            if f.counts[HIT] < 0 or s < first:
                first, f.counts[HIT] = s, c.number[i]
    return first


@_compiled
def _first_touch(k: float, nearest: float, x: float, y: float, zone: float) -> float:
    """Way (m) at which (x, y) comes as near as `zone`, before the nearest spot of the arc."""
    low, high = 0.0, nearest
    for _ in range(_HALVINGS):
        s = 0.5 * (low + high)
        half = 0.5 * k * s
        chord = s if abs(half) < 1e-9 else s * math.sin(half) / half
        if (x - chord * math.cos(half)) ** 2 + (y - chord * math.sin(half)) ** 2 < zone * zone:
            high = s
        else:
            low = s
    return low


@_compiled
def _move(f: Flight, k: float, way: float, taken: float) -> None:
    """Put the bat `way` m farther, `taken` s later; a new crossing of the left border is a new lap."""
    half = 0.5 * k * way
    chord = way if abs(half) < 1e-9 else way * math.sin(half) / half
    course = f.pose[HEADING] + half
    dx, dy = chord * math.cos(course), chord * math.sin(course)
    f.pose[X] += dx
    f.pose[LAPS_X] += dx
    f.pose[Y] += dy
    f.pose[HEADING] = _wrapped(f.pose[HEADING] + k * way)
    f.pose[TIME] += taken
    f.pose[DISTANCE] += way
    f.pose[X] -= SIDE * math.floor(f.pose[X] / SIDE)
    f.pose[Y] -= SIDE * math.floor(f.pose[Y] / SIDE)
    if f.pose[LAPS_X] < -SIDE * f.counts[LAP]:
        f.counts[LAP] += 1
        f.pose[CROSSED] = f.pose[TIME]
    if f.counts[HIT] >= 0 and f.met[f.counts[HIT]] == f.counts[LAP] + 1:
        f.counts[AVOIDED] -= 1  # it was counted when it was detected


@_inlined
def _wrapped(angle: float) -> float:
    """An angle from -pi to below pi."""
    return float(angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5))
