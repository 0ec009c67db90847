"""A flight's state at its beginning."""

from __future__ import annotations

import math

import numpy as np

from system.openspace.law import ARCS, DIRECTIONS, MIDDLE
from system.openspace.state import (
    ARC,
    CURRENTS,
    HEAD,
    HEADING,
    HIT,
    LAPS_X,
    LOG_COLUMNS,
    TIME,
    X,
    Y,
    new_flight,
)


def test_a_flight_begins_straight_ahead_and_knows_nothing() -> None:
    found = new_flight(3.0, 4.0, -math.pi, DIRECTIONS, 7, 5)
    assert [found.pose[k] for k in (X, Y, HEADING, TIME, LAPS_X)] == [3.0, 4.0, -math.pi, 0.0, 3.0]
    assert (found.counts[HEAD], found.counts[ARC], found.counts[HIT]) == (DIRECTIONS // 2, MIDDLE, -1)
    assert found.risk.shape == found.wish.shape == (ARCS,)
    assert not found.risk.any()
    assert (found.sensed < -1e200).all()
    assert found.met.tolist() == [0] * 7
    assert found.log.shape == (5, LOG_COLUMNS)
    assert found.current.shape == (CURRENTS, ARCS)


def test_flights_share_nothing() -> None:
    one, other = (new_flight(0.0, 0.0, 0.0, DIRECTIONS, 1, 1) for _ in range(2))
    one.risk[:] = 1.0
    assert not np.array_equal(one.risk, other.risk)
