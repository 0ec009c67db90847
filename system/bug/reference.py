"""Bug 0, 1 and 2 as programs: what the neural brains are compared with (Stöckel 2017, II.A and III).

Bug 0 goes to the goal until its filtered contact sensor says that there is a wall, then follows the wall; an
oscillator of 1 Hz hides the contact for a part of each period, so that it tries the way to the goal, as in
the paper's Figure 4. Bug 2 memorises the direction to the goal at the start, and follows a wall until it
crosses the line from the start nearer to the goal than where it hit the wall. Bug 1 goes around the whole
obstacle and leaves it where it was nearest to the goal.

Ours: absolute compass and distance together are the place relative to the goal. Bug 2 is back at the place of
its hit, or Bug 1 hits the wall again where it has left it at the nearest point: then the goal cannot be
reached, and they say so. Bug 0 has no memory and never knows.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64
from circuits.errors import UnknownNameError, unknown_name
from system.bug.body import RADIUS, STEP, Senses
from system.bug.brain import (
    AGENTS,
    CONTACT_FILTER,
    FOLLOW,
    GO,
    TEST_RATE,
    TEST_SHARE,
    UNREACHABLE,
    Brain,
    along_wall,
)

_AWAY = 0.5  # s after it left a wall until contact counts again, unless it lost contact before; ours
BACK = 2.0 * RADIUS  # how near a place counts as reached again, map units; ours
_GONE = 4.0 * RADIUS  # from a place, before it can be reached again; ours
_NEARER = 0.1  # map units, by which Bug 2 must be nearer to the goal, and Bug 1 get nearer; ours


def reference_brain(agent: str, diagonal: float) -> Brain:
    """Program of an agent, one of `AGENTS`; diagonal: of the map, unit of the sensed distance.

    Raises `UnknownNameError`.
    """
    if agent not in AGENTS:
        raise _no_agent(agent)
    if agent == "bug0":
        return Bug0()
    return Bug1(diagonal) if agent == "bug1" else Bug2(diagonal)


def _no_agent(agent: str) -> UnknownNameError:
    """The error for an agent that is none."""
    return unknown_name("agent", agent, AGENTS)


class Bug0:
    """Bug 0; see the module."""

    __slots__ = ("_filtered", "_steps", "state")

    def __init__(self) -> None:
        self._filtered, self._steps, self.state = 0.0, 0, GO

    @property
    def verdict(self) -> str:
        """Nothing: it has no memory."""
        return ""

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""
        phase = (self._steps * STEP * TEST_RATE) % 1.0
        self._steps += 1
        felt = senses.contact if phase >= TEST_SHARE else 0.0
        self._filtered += (felt - self._filtered) * -math.expm1(-STEP / CONTACT_FILTER)
        self.state = FOLLOW if self._filtered > 0.5 else GO
        return along_wall(senses.ranges) if self.state == FOLLOW else senses.ahead


class Bug2:
    """Bug 2; see the module."""

    __slots__ = ("_diagonal", "_hit", "_line", "_side", "_since", "_was_away", "state", "verdict")

    def __init__(self, diagonal: float) -> None:
        self._diagonal, self.state, self.verdict = diagonal, GO, ""
        self._line: F64 | None = None
        self._hit = np.zeros(2)
        self._side, self._since, self._was_away = 0.0, math.inf, True

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""
        place = -self._diagonal * senses.distance * senses.north
        if self._line is None:
            self._line = senses.north
        if self.state == GO:
            self._since += STEP
            self._was_away = self._was_away or not senses.contact
            if senses.contact and (self._was_away or self._since > _AWAY):
                self.state, self._hit, self._was_away = FOLLOW, place, False
        elif self._may_leave(place, senses.north):
            self.state, self._since, self._was_away = GO, 0.0, False
        elif self._is_back(place):
            self.verdict = UNREACHABLE
        self._side = _cross(self._line, place)
        return along_wall(senses.ranges) if self.state == FOLLOW else senses.ahead

    def _may_leave(self, place: F64, north: F64) -> bool:
        """Whether it crosses the line from the start to the goal, nearer to the goal than at the hit."""
        line = self._line if self._line is not None else north
        crosses = self._side * _cross(line, place) <= 0.0 and float(line @ north) > 0.0
        return crosses and math.hypot(*place) < math.hypot(*self._hit) - _NEARER

    def _is_back(self, place: F64) -> bool:
        far = math.hypot(*(place - self._hit))
        self._was_away = self._was_away or far > _GONE
        return self._was_away and far < BACK


class Bug1:
    """Bug 1; see the module."""

    __slots__ = ("_around", "_best", "_diagonal", "_hit", "_left", "_since", "_was_away", "state", "verdict")

    def __init__(self, diagonal: float) -> None:
        self._diagonal, self.state, self.verdict = diagonal, GO, ""
        self._hit, self._best, self._left = np.zeros(2), np.zeros(2), math.inf
        self._around, self._since, self._was_away = False, math.inf, True

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""
        place = -self._diagonal * senses.distance * senses.north
        if self.state == GO:
            self._go(place, touches=senses.contact > 0.0)
        else:
            self._follow(place)
        return along_wall(senses.ranges) if self.state == FOLLOW else senses.ahead

    def _go(self, place: F64, *, touches: bool) -> None:
        self._since += STEP
        self._was_away = self._was_away or not touches
        if touches and (self._was_away or self._since > _AWAY):
            if math.hypot(*place) > self._left - _NEARER:
                self.verdict = UNREACHABLE
            self.state, self._hit, self._best = FOLLOW, place, place
            self._around, self._was_away = False, False

    def _follow(self, place: F64) -> None:
        if math.hypot(*place) < math.hypot(*self._best):
            self._best = place
        far = math.hypot(*(place - self._hit))
        self._was_away = self._was_away or far > _GONE
        self._around = self._around or (self._was_away and far < BACK)
        if self._around and math.hypot(*(place - self._best)) < RADIUS:
            self.state, self._since, self._was_away = GO, 0.0, False
            self._left = math.hypot(*self._best)


def _cross(a: F64, b: F64) -> float:
    return float(a[0] * b[1] - a[1] * b[0])
