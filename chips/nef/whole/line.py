"""A line under the law with second-order effects.

A cascode holds the drain of a mirror's copy; both are solved together with the node of the difference
half-way to the supply. The diode of a half sets a gate that a driver brings to the stages, a millivolt too
low since its gain is finite, and with no current that gate still lets a unit's off current through. What
counts of a line is what its two halves give a unit, less each other:

    J = unit(pos) - unit(neg)

One half is off where the other is at work, and what both let through anyway is left where a stage's mirror is
not exactly 1. `chips.nef.model.Lines` has the shape of this difference over the
sum less the reference, of a line without deviations, over its slopes at half a full scale; a line's own are
its reference and these slopes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from chips.nef.whole.solve import balance
from circuits.arrays import F64
from circuits.blocks.nef.synapse import DRIVER_GAIN
from circuits.lowering.on_die import DieDevices

HALF = 0.5  # full scales above and below the reference, where slopes are taken
LOWEST, HIGHEST, STEPS = -1.5, 2.5, 32  # of a sum less the reference, full scales, and points for each
APART = np.linspace(LOWEST, HIGHEST, round((HIGHEST - LOWEST) * STEPS) + 1)
_ROUNDS = 2  # of the reference's sum, each of which leaves a hundredth of the error
_OUTPUT = 0.4  # V below the supply, ours: where the diodes of the outputs are


class LineNumbers(NamedTuple):
    """The sum that is the reference, A, float64[n], and what a sum gives a unit, A, float64[n, k].

    rest: what a half without a current gives a unit, A, float64[n].
    """

    zero: F64
    given: F64
    rest: F64


def held(d: DieDevices, copy: str, gate: F64, cascode: F64 | float, outside: float) -> F64:
    """Return what a copy carries behind its cascode, A; gate, cascode, outside: V from their rail."""
    low = np.zeros(np.broadcast_shapes(gate.shape, d.fet[copy].current.shape))

    def excess(x: F64) -> F64:
        return d.current(copy, gate, x) - d.current(f"{copy}c", cascode, outside, x)

    inner = balance(excess, low, low + outside)
    return d.current(copy, gate, inner)


def across(d: DieDevices, diode: str, current: F64) -> F64:
    """Return the voltage across a diode that carries `current`, A."""
    low = np.zeros(np.broadcast_shapes(current.shape, d.fet[diode].current.shape))
    return balance(lambda v: d.current(diode, v, v) - current, low, low + d.v_dd)


def driven(node: F64, v_dd: float) -> F64:
    """Return what a driver makes of a voltage, V: `v = v_mid + h tanh(A (node - v) / h)`, h = v_dd / 2."""
    half = 0.5 * v_dd
    low, high = node - 0.1, np.minimum(node + 0.1, v_dd)
    return balance(lambda v: v - half - half * np.tanh(DRIVER_GAIN * (node - v) / half), low, high)


def line_numbers(d: DieDevices, unit: Callable[[F64], F64], scale: float, apart: F64) -> LineNumbers:
    """Return the numbers of lines for sums that are so far from the reference, full scales, float64[k].

    unit: what a unit of a stage without mismatch carries at gate voltages below the supply, A; scale: full
    scale, A.
    """
    over = d.columns()
    split, n_gate = float(d.gate["v_split"]), d.gate["v_cas_n"]

    def copied(diode: str, copy: str, current: F64, outside: float) -> F64:
        return held(over, copy, across(over, diode, current), n_gate, outside)

    def given(diode: str, current: F64) -> F64:
        return unit(d.v_dd - driven(d.v_dd - across(over, diode, current), d.v_dd))

    taken = held(over, "mr1", np.reshape(d.below("v_ref"), (-1, 1)), d.below("v_cas_p"), d.v_dd - split)
    zero = taken
    for _ in range(_ROUNDS):
        zero = zero * taken / copied("ml1", "ml2", zero, split)
    left = copied("ml1", "ml2", zero + scale * apart, split) - taken
    # without a current mr3 still draws its off current
    turned = copied("mr2", "mr3", np.maximum(-left, 0.0), d.v_dd - _OUTPUT)
    net = given("mu1", np.maximum(left, 0.0)) - given("mu2", turned)
    return LineNumbers(zero[:, 0], net, given("mu1", np.zeros_like(zero))[:, 0])
