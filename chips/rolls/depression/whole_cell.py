"""Currents of a weight's cell of depression, and under the law with all its effects.

`Currents` is all that the equations of `chips.rolls.depression.model` need of a cell. Under the full law

* the mirror of the step stands where what I_std's device draws from it lets it, and its copy ends at the
  weight's bias, from where a step moves its drain by a few U_T: a percent of the current;
* of the recovery the sources are at the weight's bias, with the body effect there; its current is taken at
  R = 1/2, where it is what it would be far from rest;
* junctions let J into the gate, so that it rests above its bias, at R_0 = I_rec / (I_rec + J): with R over
  R_0 in the place of R, and `tau = C U_T / (I_rec + J)`, all equations are those without J.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import coupling, fed_diode, points_of, rows_of
from chips.rolls.synapse.whole_weight import before, drawn_by, sources
from circuits.arrays import F64
from circuits.devices.channel import pinch_off_of
from circuits.lowering.on_die import DieDevices

_NUDGE = 1e-3  # V, of a numerical slope


class Currents(NamedTuple):
    """Of the cells of one weight, float64[n] each.

    drawn: I_std, A, as the step's diode has it; step: as its copy gives it, A; kappa: of the diode; recovery:
    r I_rec, A; leak: J, A.
    """

    drawn: F64
    step: F64
    kappa: F64 | float
    recovery: F64
    leak: F64


def currents_of(d: DieDevices, name: str) -> Currents:
    """Return the currents of the cells of the weight `name`."""
    path = f"depression_{name}"
    if d.full:
        return _whole(d, path, float(d.below(f"v_{name}")))
    drawn = d.saturated(f"{path}.ms1", d.gate["v_std"])
    step = drawn * d.mirror(f"{path}.ms2", f"{path}.ms3").weak
    recovering = d.saturated(f"{path}.mr1", d.gate["v_rec"])
    recovery = recovering * d.mirror(f"{path}.mr2", f"{path}.mr3").weak
    return Currents(drawn, step, d.fet[f"{path}.ms2"].kappa, recovery, np.zeros(d.copies))


def _whole(d: DieDevices, path: str, bias: float) -> Currents:
    """Under the full law; bias: of the weight, V below the supply."""
    gate = _diode(d, f"{path}.ms1", f"{path}.ms2", d.gate["v_std"], 0.0)
    back = _diode(d, f"{path}.mr1", f"{path}.mr2", d.gate["v_rec"], bias)
    spent = bias - d.u_t * math.log(2.0)
    # between pulses the step's copy joins the gate with its bias too
    leaks = d.current(f"{path}.mr3", back, bias, bias), d.current(f"{path}.ms3", gate, bias, bias)
    passed = d.current(f"{path}.mr3", back, bias, spent) - leaks[0]
    passed += leaks[1] - d.current(f"{path}.ms3", gate, spent, bias)
    return Currents(
        d.current(f"{path}.ms1", d.gate["v_std"], d.v_dd - gate), d.channel(f"{path}.ms3", gate, bias),
        coupling(d, f"{path}.ms2", gate), passed, leaks[0] + leaks[1],
    )  # fmt: skip


def _diode(d: DieDevices, drawing: str, diode: str, gate: F64, foot: float) -> F64:
    """Gate of a diode-connected pFET that an nFET draws from, V below the supply; foot: of its source."""
    out = np.empty((d.copies, 1))
    given, none = points_of(gate, d.copies, 1), points_of(0.0, d.copies, 1)
    fed_diode(rows_of(d.fet[drawing]), rows_of(d.fet[diode]), given, none, d.v_dd, out, foot)
    return out[:, 0].copy()


def slope_of(d: DieDevices) -> float:
    """Return kappa of a weight at the constant weight's bias, without local deviations, for all levels."""
    law = d.fet["synapse.me2"].law
    if law.gamma == 0.0:
        return law.kappa
    height = float(d.below("v_exc")) - law.v_t0
    more, less = (float(pinch_off_of(law, height + x)) for x in (_NUDGE, -_NUDGE))
    return (more - less) / (2.0 * _NUDGE)


def whole_rises(d: DieDevices, bits: tuple[bool, bool], quiet: float, capacitance: float) -> tuple[F64, F64]:
    """Return by how much the weights' source and their mirror's gate come up in a pulse, V.

    bits: the latches; quiet: time since the last pulse, s; capacitance: at the mirror's gate, F.
    """
    drawn = drawn_by(d, sources(d, bits))
    return drawn.source[1] - drawn.source[0], drawn.gate[0] - before(d, drawn, quiet, capacitance)
