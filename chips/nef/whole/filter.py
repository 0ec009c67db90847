"""A filter under the law with second-order effects, as curves over `ln s`.

For each voltage of v_syn there is an input that keeps it: md2 carries what md3 brings, which sets the pair's
common source, and so what md1 carries. The converter's middle stands at that source. With h their sum, and
I_mid the middle there,

    s = h / I_mid,    ds/dt = (z - s) / tau,    tau = C (dv / d ln s) / I_tau

with I_tau and `v`, how far v_syn is below the supply, as they are at s. The output is md5's with its drain at
the line's diode. Under the ideal law these are `tau (1 + 1 / S)` and `gain s^power` of `chips.nef.model`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.nef.whole.solve import balance
from circuits.arrays import F64, I64
from circuits.lowering.on_die import DieDevices, Fet

LOWEST, HIGHEST, STEPS = -6.5, 2.5, 16  # of ln s, and points for each of its units
LOG_S = np.linspace(LOWEST, HIGHEST, round((HIGHEST - LOWEST) * STEPS) + 1)
# points over v_syn, from so many e-folds below v_thr to so many above the middle
_DEPTHS, _BELOW, _ABOVE = 73, 2.0, 2.8
_FOLD = 1.45  # U_T for each e-fold, at least; ours
_NODE, _ROUNDS = 0.3, 2  # V of the line's diode at first, and rounds of it and what flows into it


class Curves(NamedTuple):
    """Filters over `LOG_S`, float64[n, points]: log of the output, A; tau, s; volts of v_syn, V."""

    output: F64
    tau: F64
    volts: F64

    def taken(self, index: I64) -> Curves:
        """The filters numbered `index`."""
        return Curves(*(a[index] for a in self))

    def at(self, curve: F64, s: F64) -> F64:
        """Return what a curve of these is at each filter's s, float64[n]."""
        log = np.log(np.maximum(s, 1e-12))
        return np.array([np.interp(x, LOG_S, row) for x, row in zip(log, curve, strict=True)])

    def inverse(self, curve: F64, value: F64) -> F64:
        """Return the s of each filter at which a curve of these is a value, float64[n]."""
        logs = [np.interp(x, row, LOG_S) for x, row in zip(value, curve, strict=True)]
        return np.asarray(np.exp(np.array(logs)))


def curves_of(d: DieDevices, capacitance: F64, diode: Fet) -> Curves:
    """Return the curves of filters `d`; capacitance: at v_syn, F, float64[n]; diode: of the line, alone."""
    over = d.columns()
    leak = d.saturated("filter.md3", d.below("v_tau"))
    span = np.log(np.median(d.saturated("mv1", d.gate["v_mid"]) / leak)) + _ABOVE
    depth = d.below("v_thr") + _FOLD * d.u_t * np.linspace(-_BELOW, float(span), _DEPTHS)
    depth = np.maximum(depth, np.linspace(1e-3, 2e-3, _DEPTHS))
    inside = d.v_dd - depth
    shape = np.zeros((d.copies, _DEPTHS))
    charged = over.current("filter.md3", over.below("v_tau"), depth) + shape
    source = balance(lambda y: charged - over.current("filter.md2", inside, inside, y), shape, shape + inside)
    drawn = charged + over.current("filter.md1", over.gate["v_thr"], d.v_dd, source)
    log = np.log(drawn / over.current("mv1", over.gate["v_mid"], source))
    output = _output(over, depth, diode)
    tau = capacitance[:, None] * (np.gradient(depth) / np.gradient(log, axis=1)) / charged
    found = (np.log(output), tau, np.broadcast_to(depth, shape.shape))
    return Curves(*(np.array([np.interp(LOG_S, x, y) for x, y in zip(log, c, strict=True)]) for c in found))


def _output(over: DieDevices, depth: F64, diode: Fet) -> F64:
    """Current of md5 into the line's diode, A."""
    found = over.current("filter.md5", depth, over.v_dd - _NODE)
    for _ in range(_ROUNDS):
        found = over.current("filter.md5", depth, over.v_dd - diode.gate_for(found, diode=True))
    return found
