"""How far below its threshold a level unit's input must rest to be heard, by the law of its devices.

At rest the copy mc6 of what the input's side of the pair carries must exceed mc7, else no refractory ends and
the unit is deaf (`chips.lso.law.rest_depth`). Under the full law currents have the Early effect of where the
comparator turns: the pair's sources are where the pair shares the tail's current, and the output is a
threshold above ground. What the circuit needs over that is the record's (`chips.lso.measure`).
"""

from __future__ import annotations

import numpy as np

from chips.lso.law import rest_depth
from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.devices.channel import early, pinched, terms_of
from circuits.devices.ekv import argument
from circuits.lowering.on_die import DieDevices, transistor_of
from circuits.silicon.silicon import Silicon

PART = "generator.comparator"  # of a level unit
DEVICES = ("mc1", "mc3", "mc4", "mc6", "mc7")
THRESHOLD = 0.6  # V, of the level unit that is measured: its offset and charge do not depend on it
LINE = "v_bcmp"  # at which mc3 and mc7 have their gates


def pair_kappa(silicon: Silicon) -> float:
    """Return kappa of a level unit's pair where its gates are, by how steeply v_p follows them there."""
    law = silicon.law("p")
    return float(pinched(terms_of(law, 1.0, 1.0, 1.0, law.v_t0), silicon.process.v_dd - THRESHOLD)[1])


def law_depth(units: DieDevices, level: Circuit, silicon: Silicon) -> F64:
    """Return how far below the pair's own threshold inputs must rest, V, inf where none is enough.

    units: `DEVICES` of level units on a silicon, whose line has a voltage; level: their circuit.
    """
    law = silicon.law("p")
    tail, least = (units.saturated(f"{PART}.{m}", units.below(LINE)) for m in ("mc3", "mc7"))
    pair = law.square_current * transistor_of(level, f"{PART}.mc1").square
    if units.full:
        tail, least = _at_drains(units, silicon, tail, pair)
    mirror = units.mirror(f"{PART}.mc4", f"{PART}.mc6")
    return rest_depth(tail, least, mirror, pair, pair_kappa(silicon), law.u_t)


def _at_drains(d: DieDevices, silicon: Silicon, tail: F64, pair: float) -> tuple[F64, F64]:
    """Current of the tail, and what must be exceeded over the copy's Early effect, A.

    tail: saturated, A; pair: specific current of the pair's devices, A.
    """
    v_dd, gate = silicon.process.v_dd, d.below(LINE)
    output = silicon.law("n").v_t0
    source = d.pinch(f"{PART}.mc1", v_dd - THRESHOLD) - argument(0.5 * tail / pair)
    whole = d.channel(f"{PART}.mc3", gate, d.u_t * source)
    least = d.channel(f"{PART}.mc7", gate, v_dd - output)
    copy = d.fet[f"{PART}.mc6"]
    return whole, np.asarray(least / early(copy.law, copy.length, output, np.sqrt(least / copy.current)))
