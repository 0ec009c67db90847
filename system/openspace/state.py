"""The state of a flight through a forest, which the compiled loop reads and overwrites."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from system.openspace.law import ARCS, MIDDLE

# columns of `Flight.counts`
(
    HEAD, ARC, SCANNING, LAP, AVOIDED, PINGS, EMERGENCIES, SCANS, WINNER, SEEN, HIT, LOGGED, PINGED,
    MISSED, MASKED, OCCLUDED, GHOSTS, LATE, TIES, OTHER, HEARD, TURNED, TURNS,
) = range(23)  # fmt: skip
COUNTS = 23
X, Y, HEADING, TIME, CROSSED, DISTANCE, LAPS_X, DECIDING = range(8)  # columns of `Flight.pose`
_POSE = 8
LOG_COLUMNS = 8  # time (s), x, y (m), heading (rad), direction of the ping, arc, winner, whether scanning
ECHO_X, ECHO_Y, ECHO_RANGE, ECHO_BEARING, ECHO_NUMBER, ECHO_SIDE = range(6)  # columns of `Flight.echo`
ECHOES = 256  # of a ping, those of no obstacle included; ours: far more than a field of view of 12 m^2 holds
CURRENTS = 6  # rows of `Flight.current`: two of the selection's ports, and its scratch

NEVER = -1e300  # s, of a direction that was not sensed yet
LONG_AGO = -(1 << 40)  # ping of an emergency that has not been


class Flight(NamedTuple):
    """State of a flight, overwritten in place.

    pose: float64[8], x, y (m), heading (rad, from east to north), time (s), time of the last new crossing
    (s), way (m), x without the torus (m), time that selections took (s); counts: int64[23], see the columns;
    risk, wish: float64[ARCS], E_p and D_p; fresh: float64[ARCS], sums of immediacies of the last ping;
    sensed: float64[DIRECTIONS], s, last ping in each; met: int64[obstacles], 1 + the lap in which each was
    last counted; log: float64[rows, LOG_COLUMNS], filled while there is room; echo: float64[ECHOES, 6],
    scratch of a ping; current: float64[CURRENTS, ARCS], scratch of a selection, A.
    """

    pose: F64
    counts: I64
    risk: F64
    wish: F64
    sensed: F64
    met: I64
    fresh: F64
    log: F64
    echo: F64
    current: F64


def new_flight(x: float, y: float, heading: float, directions: int, obstacles: int, rows: int) -> Flight:
    """Return a flight that begins: straight ahead, the head in the middle, nothing remembered."""
    counts = np.zeros(COUNTS, dtype=np.int64)
    counts[HEAD], counts[ARC], counts[HIT] = directions // 2, MIDDLE, -1
    counts[TURNED] = LONG_AGO
    pose = np.zeros(_POSE)
    pose[X], pose[Y], pose[HEADING], pose[LAPS_X] = x, y, heading, x
    return Flight(
        pose,
        counts,
        np.zeros(ARCS),
        np.zeros(ARCS),
        np.full(directions, NEVER),
        np.zeros(obstacles, dtype=np.int64),
        np.zeros(ARCS),
        np.zeros((rows, LOG_COLUMNS)),
        np.zeros((ECHOES, 6)),
        np.zeros((CURRENTS, ARCS)),
    )
