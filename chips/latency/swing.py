"""Where the drains of the latency chip stand while their currents are counted, under the full law.

A current that fills a capacitor from ground to the reference depends on the capacitor's voltage by the Early
effect of its device, in a straight line, so that the charge over the time is the current where the drain is
halfway; what is left out of `T = Q / I` is a twelfth of the square of the change, below 1e-5. A detector
compares currents where its node turns the inverter, and its mirror's diode stands at its own gate.

Switches that are off take some of the current: by the channel, which with body effect is flatter in its gate
the lower it is, and by the junction. At 60 degC that is 1.3 pA of a switch, and 11 where the die's thresholds
are low by three standard deviations, of the 63 that make INH's hold. What pFETs give is left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.latency.design import REFERENCE
from circuits.arrays import F64
from circuits.blocks.latency import coincidence
from circuits.lowering.on_die import DieDevices, standing
from circuits.silicon.die import NOMINAL
from circuits.silicon.process import Polarity
from circuits.silicon.silicon import Silicon

_BISECTIONS = 40  # of a node's voltage


def halfway(polarity: Polarity, v_dd: float) -> float:
    """Return the voltage between drain and bulk halfway from ground to the reference, V, a magnitude."""
    return v_dd - 0.5 * REFERENCE if polarity == "p" else 0.5 * REFERENCE


def swing_current(d: DieDevices, device: str, gate: F64, polarity: Polarity = "p") -> F64:
    """Return the current by which a device fills a capacitor, or empties one, A.

    gate: V from its bulk, of a shape that broadcasts with the device's. Without second-order effects it is
    the saturated one.
    """
    return d.current(device, gate, halfway(polarity, d.v_dd)) if d.full else d.saturated(device, gate)


def idle_inhibition(d: DieDevices, inside: str, gate: F64) -> F64 | float:
    """Return what an inhibition that is off takes from a membrane, A; none under the ideal law.

    inside: its path, with a dot at its end; gate: of its current's device, V. The node between that device
    and its switch stands where both carry the same.
    """
    if not d.full:
        return 0.0
    source, switch = f"{inside}mk", f"{inside}ms"
    node = halfway("n", d.v_dd)
    low, high = 0.0 * d.fet[switch].current, node + 0.0 * d.fet[switch].current
    for _ in range(_BISECTIONS):
        foot = 0.5 * (low + high)
        more = d.current(source, gate, node, foot) > d.current(switch, 0.0, foot)
        low, high = np.where(more, foot, low), np.where(more, high, foot)
    return d.current(switch, 0.0, 0.5 * (low + high))


def detector_threshold(silicon: Silicon) -> float:
    """Return the voltage at which a detector's node turns its inverter on the nominal die, V."""
    nominal = replace(silicon, die=NOMINAL, place=None)
    devices = standing(coincidence.build(), nominal, wanted=["mip", "min"])
    return devices.inverter_threshold("mi").item()


def taken_at(d: DieDevices, gate: F64, node: float, inside: str = "") -> F64:
    """Return what a detector takes from its node, A.

    gate: of its inputs, V below the supply; node: voltage of its node, V; inside: path of the detector, with
    a dot at its end.
    """
    me, md, mk = (f"{inside}{name}" for name in ("me", "md", "mk"))
    at_diode = d.fet[md].gate_for(d.saturated(me, gate), diode=True)
    given = d.current(me, gate, d.v_dd - at_diode)
    return d.current(mk, d.fet[md].gate_for(given, diode=True), node)
