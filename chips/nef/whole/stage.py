"""An encoder stage under the law with second-order effects: its units where their drains are.

Switches whose gates are at ground hold the drains of the units, as cascodes do: the membrane moves them by
millivolts, but the code's own current by U_T an e-fold. A bit is taken where a code has it as its highest.
The mirror has no such switch, and what it draws rises with the membrane. Its diode stands at little more than
U_T of a small current, so that its copy, whose drain is far, draws some more, whatever the current.

A switch that is off lets its off current through, as far as its units carry it: in weak inversion the two in
series carry `s u / (s + u)` of what each would carry by itself.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from chips.nef.whole.solve import balance
from circuits.arrays import F64
from circuits.blocks.nef.encoder import BITS
from circuits.lowering.on_die import DieDevices

ALONE = ("md0", "md5", "msd0", "mx1", "mm1", "mm2")
_SHARE = 1.5  # of the current of its highest bit that a code has on average
_TYPICAL, _BIT = 32.0, 5  # units, and the bit that is worth them
_BEYOND, _HIGHEST, _POINTS = 0.05, 0.6, 131  # V beyond the supply and below it, and points 5 mV apart


def drains(d: DieDevices, current: F64, membrane: float) -> F64:
    """Return how far below the supply the drains of a bit's units are, V.

    d: of one stage; current: of the bit, A; membrane: V.
    """
    none, top = np.zeros_like(current), d.v_dd
    held = _steered(d, current, membrane)
    return balance(lambda y: current - d.current("msd0", top, held, y), none, held)


def _steered(d: DieDevices, current: F64, membrane: float) -> F64:
    """How far below the supply a bank's switches end, V; arguments as of `drains`."""
    none, top = np.zeros_like(current), d.v_dd
    return balance(lambda y: _SHARE * current - d.current("mx1", top, top - membrane, y), none, none + top)


def shut(d: DieDevices, letter: str, one: DieDevices, unit: float, membrane: float) -> F64:
    """Return what the switches of a bank's bits let through while they are off, A, float64[n, bits].

    one: a stage without deviations, in which the bank of `_TYPICAL` units, A, says where switches end.
    """
    end = float(_steered(one, np.array([_TYPICAL * unit]), membrane)[0])
    return np.stack([d.current(f"ms{letter}{k}", 0.0, end) for k in range(BITS)], axis=1)


def unit_current(d: DieDevices, gate: F64, membrane: float) -> F64:
    """Return the current of a unit of one stage at gates, V below the supply, A."""
    there = drains(d, _TYPICAL * d.saturated("md0", gate), membrane)
    return np.asarray(d.current(f"md{_BIT}", gate, there) / _TYPICAL)


def units(d: DieDevices, membrane: float) -> Callable[[F64], F64]:
    """Return `unit_current` of one stage as a function that is read from points."""
    gates = np.linspace(-_BEYOND, _HIGHEST, _POINTS)
    logs = np.log(unit_current(d, gates, membrane))
    return lambda gate: np.exp(np.interp(gate, gates, logs))


def bank(d: DieDevices, letter: str, gate: F64, there: F64) -> F64:
    """Return the currents of a bank's bits, A, float64[n, bits]; there: `drains`."""
    return np.stack([d.current(f"m{letter}{k}", gate, there[k]) for k in range(BITS)], axis=1)


def mirror(d: DieDevices, unit: float, membrane: float) -> F64:
    """Return what the mirror draws of a code's current with the membrane at a voltage, V, a ratio."""
    current = _TYPICAL * unit
    gate = d.fet["mm1"].gate_for(current, diode=True)
    return np.asarray(d.channel("mm2", gate, membrane) / current)


def mirror_line(d: DieDevices, unit: float, membrane: float) -> tuple[F64, F64]:
    """Return what the mirror draws as a line through that of one unit and of a code: a ratio, and A more."""
    low, high = (_turned(d, current, membrane) for current in (unit, _TYPICAL * unit))
    ratio = (high - low) / ((_TYPICAL - 1.0) * unit)
    return ratio, low - ratio * unit


def _turned(d: DieDevices, current: float, membrane: float) -> F64:
    """What the mirror draws of a current, A."""
    none = np.zeros_like(d.fet["mm1"].current)
    gate = balance(lambda v: d.current("mm1", v, v) - current, none, none + d.v_dd)
    return d.current("mm2", gate, membrane)
