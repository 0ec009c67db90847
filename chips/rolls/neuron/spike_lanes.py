"""Neurons whose spikes are run side by side: what stands in which row of their numbers.

A number of all lanes is a row of `LANES` numbers of an array, a row after the other, float64[ROOM]: node i's
voltage is in `V + i LANES`, and so on. What the law wants of its devices stands from `OWN` on.
"""

from __future__ import annotations

LANES, NODES, OWN_ROWS = 32, 4, 120
V = 0  # voltages of v_mem, v_o1, v_ref, k1, V
RATE = V + NODES * LANES  # how fast they move, V/s
NUDGED = RATE + NODES * LANES  # the same where the node itself is NUDGE higher, V/s
NOW, SPIKED, GOING, FIRED, LET_GO = (NUDGED + (NODES + k) * LANES for k in range(5))
OWN = LET_GO + LANES
ROOM = OWN + OWN_ROWS * LANES
NUDGE = 1e-6  # V, of the numerical slopes
