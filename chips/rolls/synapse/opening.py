"""When an event has emptied the node of a synapse's pulse, and until when its transistor carries a current.

The event rises from ground to the supply at the gate of mp1. What that carries saturated is summed over the
event, and both are sought in a grid of it, of which no more is evaluated than what is before them.
"""

from __future__ import annotations

import math

import numpy as np

from chips.rolls.lumped.grid import interpolated
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, pinched, terms_of
from circuits.devices.packable import even_interpolation
from circuits.lowering.on_die import DieDevices

POINTS = 721  # of the event
_TOGETHER = 48  # points of the event that are evaluated side by side; ours


def opened(d: DieDevices, device: str, needed: F64, current: F64, duration: float) -> tuple[F64, F64]:
    """Return the event (V) at which `device` has moved a charge, and at which it carries a current.

    needed: C, float64[n]; current: A, float64[n]; duration: of the whole event from ground to the supply, s.
    """
    fet, event = d.fet[device], np.linspace(0.0, d.v_dd, POINTS)
    own = np.stack([np.broadcast_to(x, d.copies) for x in (fet.current, fet.threshold, needed, current)])
    found, scratch = np.empty((2, d.copies)), np.empty((2, event.size))
    times = d.u_t, math.sqrt(2.0) * fet.law.u_t, event[1] / d.v_dd * duration
    _fill_opened(terms_of(fet.law, 1.0, 1.0, 0.0, 0.0), times, own, event, scratch, found)
    return found[0], found[1]


@compiled()
def _fill_opened(
    shared: Terms, times: tuple[float, float, float], own: F64, event: F64, scratch: F64, out: F64
) -> None:
    """Fill `out` with both events of each device, V, float64[2, n].

    times: U_T, sqrt(2) U_T of the law, V, and how long a step of the event takes, s. own: specific current,
    threshold, charge and current of each, float64[4, n]. scratch: float64[2, points].
    """
    carried, passed = scratch[0], scratch[1]
    for k in range(out.shape[1]):
        done, total = 0, 0.0
        while done < event.size:
            end = min(done + _TOGETHER, event.size)
            _carry(shared, times, own[0, k], own[1, k], event[done:end], carried[done:end], passed[done:end])
            for j in range(done, end):
                total += carried[j]
                passed[j] = total * times[2]
            done = end
            if passed[done - 1] > own[2, k] and carried[done - 1] > own[3, k]:
                break
        interpolated(own[2, k : k + 1], passed[:done], event[:done], out[0, k : k + 1])
        interpolated(own[3, k : k + 1], carried[:done], event[:done], out[1, k : k + 1])


@compiled()
def _carry(
    shared: Terms, times: tuple[float, float, float], current: float, threshold: float, gate: F64, out: F64,
    field: F64,
) -> None:  # fmt: skip
    """Fill `out` with what `DieDevices.saturated` gives at each gate voltage, A; field: working space."""
    t = Terms(
        current, threshold, shared.half, shared.kappa, shared.gamma, shared.surface, shared.early,
        shared.early_rise, shared.reduction, shared.leakage, shared.induced, shared.induced_from,
        shared.induced_slope,
    )  # fmt: skip
    for j in range(gate.size):
        pinch = pinched(t, gate[j])[0] / times[0]
        out[j], field[j] = current * even_interpolation(pinch), pinch * times[0]
    if t.reduction != 0.0:
        for j in range(gate.size):
            v_m = 0.5 * (field[j] + math.hypot(field[j], times[1]))
            out[j] *= 1.0 / (1.0 + t.reduction * v_m)
