"""Neurons whose spikes are run side by side: what stands in which row of their numbers, and nodes' balances.

A number of all lanes is a row of `LANES` numbers of an array, a row after the other, float64[ROOM]: node i's
voltage is in `V + i LANES`, and a device's drain in `DRAIN` and so many rows on. The devices that move nodes
are evaluated in one loop, whatever node they are at. What the law wants of them stands from `OWN` on.
"""

from __future__ import annotations

from circuits.arrays import F64
from circuits.compiled import compiled

MC1, MC2, MC4, MK4, MK5, MK6P, MK6N, MK8, MA1, MA2 = range(10)  # devices, in this order
MOVING = MK8 + 1  # of which these move nodes

LANES, NODES, OWN_ROWS = 32, 4, 14 * MOVING
V = 0  # voltages of v_mem, v_o1, v_ref, k1, V
RATE = V + NODES * LANES  # how fast they move, V/s
NUDGED = RATE + NODES * LANES  # the same where the node itself is NUDGE higher, V/s
CAPACITANCE = NUDGED + NODES * LANES  # of the nodes, F
NOW, SPIKED, GOING, FIRED, LET_GO, DRIVE, START, STEEP = (CAPACITANCE + (NODES + k) * LANES for k in range(8))
INTO = STEEP + LANES  # what flows into v_mem from its drive, A, and where it is NUDGE higher
DRAIN = INTO + 2 * LANES  # of each moving device, V above its bulk (below, pFET)
DRAIN_NUDGED = DRAIN + MOVING * LANES  # where the node at its drain is NUDGE higher
TAKES, TAKES_NUDGED = (DRAIN_NUDGED + k * MOVING * LANES for k in (1, 2))  # current into either drain, A
OWN = TAKES_NUDGED + MOVING * LANES
ROOM = OWN + OWN_ROWS * LANES
NUDGE = 1e-6  # V, of the numerical slopes


@compiled(forceinline=True)
def _drained(w: F64, j: int, pulls: int, holds: int, node: int, v_dd: float) -> None:
    """Put the drains of the devices that pull a node down and hold it up."""
    v = w[V + node * LANES + j]
    w[DRAIN + pulls * LANES + j], w[DRAIN_NUDGED + pulls * LANES + j] = v, v + NUDGE
    w[DRAIN + holds * LANES + j], w[DRAIN_NUDGED + holds * LANES + j] = v_dd - v, v_dd - (v + NUDGE)


@compiled()
def put_drains(w: F64, v_dd: float) -> None:
    """Put the drains of all moving devices."""
    for j in range(LANES):
        _drained(w, j, MK8, MC4, 0, v_dd)
        _drained(w, j, MC1, MC2, 1, v_dd)
        _drained(w, j, MK5, MK4, 2, v_dd)
        _drained(w, j, MK6N, MK6P, 3, v_dd)


@compiled()
def put_rates(w: F64) -> None:
    """Put how fast all nodes move, of what their devices take."""
    for rate, takes, into in ((RATE, TAKES, INTO), (NUDGED, TAKES_NUDGED, INTO + LANES)):
        for j in range(LANES):
            given = w[into + j] + (w[takes + MC4 * LANES + j] - w[takes + MK8 * LANES + j])
            w[rate + j] = given / w[CAPACITANCE + j]
            given = w[takes + MC2 * LANES + j] - w[takes + MC1 * LANES + j]
            w[rate + LANES + j] = given / w[CAPACITANCE + LANES + j]
            drawn, filled = -w[takes + MK5 * LANES + j], w[takes + MK4 * LANES + j]
            filled = drawn + filled
            given = filled if w[V + LANES + j] < w[FIRED + j] else drawn
            w[rate + 2 * LANES + j] = given / w[CAPACITANCE + 2 * LANES + j]
            given = w[takes + MK6P * LANES + j] - w[takes + MK6N * LANES + j]
            w[rate + 3 * LANES + j] = given / w[CAPACITANCE + 3 * LANES + j]
