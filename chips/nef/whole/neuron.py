"""A neuron's numbers under the law with second-order effects.

* The threshold is where mc1 and mc2 balance with `v_o1` so low that mc4 brings as much as the input does:
  from there on the membrane rises by itself.
* The leak is what mf1 draws, and what mk8 and mc4 leak, on average from reset to threshold. It rises by
  `rise` from the one to the other, and what a stage's mirror draws by the share `mirrored`, so that with u
  from 0 to 1

      charge du/dt = J - leak - (u - 1/2)(rise + mirrored * J_mirrored)

* I_rfr is integrated from the supply down to the threshold of mk6, without what mk4 leaks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.nef.whole.solve import balance
from circuits.arrays import F64
from circuits.lowering.on_die import DieDevices

FEED = 3.0  # currents of the leak, ours: a usual input where it is taken over by mc4
_POINTS = 17  # of integrals over a membrane's swing and a refractory period


class NeuronNumbers(NamedTuple):
    """leak, rise: A; swing: from reset to threshold, V; refractory: a period for each farad, s/F."""

    leak: F64
    rise: F64
    swing: F64
    refractory: F64


def threshold(d: DieDevices, leak: F64) -> F64:
    """Return the voltage of the membrane from which it rises by itself, V; leak: A, float64[n]."""
    fallen = d.gate_for("mc4", FEED * leak)
    held = d.current("mc2", d.below("v_buf"), fallen)
    bound = np.zeros_like(fallen)
    return balance(lambda v: d.current("mc1", v, d.v_dd - fallen) - held, bound, bound + d.v_dd)


def neuron_numbers(d: DieDevices) -> NeuronNumbers:
    """Return what neurons of devices `d` have."""
    reset = float(np.ravel(d.gate["v_reset"])[0])
    top = threshold(d, d.saturated("mf1", d.gate["v_leak"]))
    drawn = np.array(
        [_drawn(d, reset + share * (top - reset), reset) for share in np.linspace(0.0, 1.0, _POINTS)]
    )
    mean = np.trapezoid(drawn, dx=1.0 / (_POINTS - 1), axis=0)
    # of a line through what is drawn, which is less just above a reset that is low
    rise = 2.0 * (drawn[-1] - mean)
    return NeuronNumbers(mean, rise, top - reset, refractory(d))


def _drawn(d: DieDevices, v: F64, reset: float) -> F64:
    """What the membrane at v loses, A."""
    shut = d.current("mk8", 0.0, v, reset) - d.current("mc4", 0.0, d.v_dd - v)
    return np.asarray(d.current("mf1", d.gate["v_leak"], v) + shut)


def refractory(d: DieDevices) -> F64:
    """Return the time in which I_rfr takes C_ref from the supply to the threshold of mk6, s/F."""
    bottom = d.inverter_threshold("mk6")
    v = bottom + (d.v_dd - bottom) * np.linspace(0.0, 1.0, _POINTS)[:, None]
    drawn = d.current("mk5", d.gate["v_rfr"], v) - d.current("mk4", 0.0, d.v_dd - v)
    return np.asarray(np.trapezoid(1.0 / drawn, v, axis=0))
