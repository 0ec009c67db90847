"""MOS transistor by the EKV law, which is continuous from weak to strong inversion.

    I = I_S [F(u_f) - F(u_r)] E M,     F(u) = ln^2(1 + e^(u/2))
    u_f = (v_p - v_s) / U_T,    u_r = (v_p - v_d) / U_T,    I_S = 2 mu Cox U_T^2 / kappa * m W / L

All voltages are to the bulk, and mirrored for a pFET. The pinch-off voltage is `v_p = kappa (v_g - V_T0)`, or
with body effect (the law `ekv-gamma`)

    v_p = v_x - phi - gamma (sqrt(v_x + gamma^2/4) - gamma/2),   v_x = v_g - V_T0 + phi + gamma sqrt(phi)

In weak inversion this is equation (1) of Cheely & Horiuchi (2003) with `I_0 = I_S e^(-kappa V_T0 / U_T)`.
What is left at v_g = v_s is the off current of the channel.

E is the Early effect, its voltage in proportion to the length and rising with inversion; M is the mobility's
reduction by the field across the oxide. Both are 1 where their figures are 0.

    E = 1 + |v_d - v_s| / (V_E L (1 + r q)),   q = sqrt(F(u_f)) + sqrt(F(u_r))
    M = 1 / (1 + theta v_m),                   v_m = (v_p + sqrt(v_p^2 + 2 U_T^2)) / 2

Each junction leaks from drain or source to bulk, and more where the gate is far from it:

    I_J = W [J + G e^((v_jg - v_G0) / v_G)] (1 - e^(-v_jb / U_T)),   v_jg, v_jb: junction over gate, over bulk

Charges are those of constant capacitances between gate and bulk, gate and drain, gate and source, drain and
bulk, and source and bulk, so that charge is conserved whatever the voltages do.

Sources: Enz, Krummenacher, Vittoz, "An analytical MOS transistor model" (1995), equations of I_S, v_p, F;
Bucher et al., "The EPFL-EKV MOSFET model equations for simulation" (1997), mobility by the pinch-off voltage.
That the Early voltage rises with q, and a gate's leakage as a factor of a junction's: ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from circuits.arrays import F64, I32, Bools
from circuits.checks import require_choice
from circuits.compiled import compiled
from circuits.devices.device import Device, require_positive
from circuits.devices.softplus import LIMIT, exp_negative, softplus
from circuits.silicon.process import POLARITIES, Polarity, TransistorAtTemperature, TransistorModel

INDUCED_LIMIT = 10.0
"""Slopes above its reference beyond which a gate-induced leakage rises no more; ours."""


@dataclass(frozen=True, slots=True)
class Transistor(Device):
    """A MOS transistor.

    Attributes
    ----------
    polarity : str
        `n` or `p`.
    drain, gate, source, bulk : str
        Names of its nodes.
    width, length : float
        Size of one device, m.
    multiplicity : float
        Number of equal devices in parallel.

    Raises
    ------
    ParameterError
        The polarity is another, or a size is not above zero or not plausible.
    """

    name: str
    polarity: Polarity
    drain: str
    gate: str
    source: str
    bulk: str
    width: float
    length: float
    multiplicity: float = 1.0

    def terminals(self) -> tuple[str, ...]:
        """The nodes drain, gate, source and bulk."""
        return self.drain, self.gate, self.source, self.bulk

    @property
    def gate_area(self) -> float:
        """Area of all its gates, `m W L`, m^2."""
        return self.width * self.length * self.multiplicity

    @property
    def square(self) -> float:
        """Width of all its devices over their length, `m W / L`, a ratio."""
        return self.width * self.multiplicity / self.length

    def parameters(self) -> Mapping[str, float]:
        """The width (m), length (m) and multiplicity."""
        return {"width": self.width, "length": self.length, "multiplicity": self.multiplicity}

    def check(self) -> None:
        """Raise `ParameterError` unless the polarity is known and the sizes are above zero."""
        require_choice(f"{self.name}.polarity", self.polarity, POLARITIES)
        require_positive(self, "width", "m")
        require_positive(self, "length", "m")
        require_positive(self, "multiplicity", "devices")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """Direct current flows between drain and source; the junctions tie neither of them to the bulk."""
        return ((0, 2),)


class TransistorArrays(NamedTuple):
    """Coefficients of n transistors in the form that the law's kernel takes, float64[n] each unless said."""

    terminal: I32  # int32[4, n]: positions of drain, gate, source, bulk in the voltage vector
    sign: F64  # +1 nFET, -1 pFET
    specific_current: F64  # I_S, A
    inverse_2ut: F64  # 1 / (2 U_T), 1/V
    v_t0: F64  # V, deviations included
    kappa: F64
    gamma: F64  # V^0.5; used when body_effect
    surface_potential: F64  # V
    early: F64  # 1/V, in weak inversion
    early_rise: F64
    reduction: F64  # 1/V, of the mobility
    leakage: F64  # A, each of both junctions
    induced: F64  # A, what the gate adds to it at `induced_from`
    induced_from: F64  # V
    induced_per_volt: F64  # 1/V
    body_effect: bool
    reduces: bool  # whether the Early voltage rises or the mobility falls
    leaks: bool
    induces: bool


class TransistorWork(NamedTuple):
    """Scratch of the law's kernel, and the currents and conductances that it leaves."""

    argument: F64  # [2n] u/2, forward then reverse
    value: F64  # [2n] ln(1 + e^(u/2))
    slope: F64  # [2n]
    kappa: F64  # [n] dv_p/dv_g
    factor: F64  # [n] E M, the Early effect and the mobility's reduction
    current: F64  # [n] A, into the drain and out of the source
    conductance: F64  # [3, n] derivatives of `current` by drain, gate, source voltage, S
    leakage: F64  # [2, n] what drain and source junctions leak far in reverse, A
    junction: F64  # [2, n] leakage current into drain and source, out of the bulk, A
    junction_conductance: F64  # [4, n] its derivatives by the drain or source voltage, then by the gate's, S


def transistor_arrays(
    terminal: I32,
    polarity: Polarity,
    law: TransistorAtTemperature,
    width: F64,
    length: F64,
    multiplicity: F64,
    delta_v_t: F64 | float = 0.0,
    relative_beta: F64 | float = 0.0,
) -> TransistorArrays:
    """Coefficients of n transistors of one polarity.

    terminal: int32[4, n], positions of drain, gate, source and bulk in the vector of voltages. law:
    parameters of the polarity at the run's temperature. width, length: float64[n], m. delta_v_t: deviation of
    V_T0, V, of the magnitude. relative_beta: relative deviation of the current factor.
    """
    n = width.size
    full = np.ones(n)
    law = law.of_any_size(width, length)
    square = law.square_current * multiplicity * width / length
    leakage, induced = (x * width * multiplicity for x in (law.junction_leakage, law.gate_induced_leakage))
    early = 1.0 / (law.early_field * length) if np.any(law.early_field) else 0.0 * full
    return TransistorArrays(
        terminal=np.ascontiguousarray(terminal, dtype=np.int32),
        sign=full if polarity == "n" else -full,
        specific_current=square * (1.0 + relative_beta),
        inverse_2ut=full / (2.0 * law.u_t),
        v_t0=law.v_t0 + delta_v_t * full,
        kappa=law.kappa * full,
        gamma=law.gamma * full,
        surface_potential=law.surface_potential * full,
        early=early,
        early_rise=law.early_rise * full,
        reduction=law.mobility_reduction * full,
        leakage=leakage,
        induced=induced,
        induced_from=law.gate_induced_from * full,
        induced_per_volt=full / law.gate_induced_slope,
        body_effect=bool(np.any(law.gamma)),
        reduces=bool(np.any(law.early_field * law.early_rise) or np.any(law.mobility_reduction)),
        leaks=law.junction_leakage > 0.0 or law.gate_induced_leakage > 0.0,
        induces=law.gate_induced_leakage > 0.0,
    )


def merge_arrays(is_n: Bools, n: TransistorArrays, p: TransistorArrays) -> TransistorArrays:
    """Coefficients of all transistors, each from the arrays of its own polarity.

    is_n: bool[n]. A second-order effect is computed for all where any of them has it.
    """
    flags = ("body_effect", "reduces", "leaks", "induces")
    fields = [f for f in TransistorArrays._fields if f not in ("terminal", *flags)]
    columns: dict[str, Any] = {f: np.where(is_n, getattr(n, f), getattr(p, f)) for f in fields}
    some = [a for a, used in ((n, is_n.any()), (p, not is_n.all())) if used]
    either: dict[str, Any] = {flag: any(getattr(a, flag) for a in some) for flag in flags}
    return n._replace(**columns, **either)


def transistor_work(n: int) -> TransistorWork:
    """Scratch for n transistors."""
    return TransistorWork(
        np.zeros(2 * n), np.zeros(2 * n), np.zeros(2 * n), np.zeros(n), np.zeros(n), np.zeros(n),
        np.zeros((3, n)), np.zeros((2, n)), np.zeros((2, n)), np.zeros((4, n)),
    )  # fmt: skip


@compiled(fastmath={"contract"})
def drain_currents(a: TransistorArrays, v: F64, w: TransistorWork) -> None:
    """Fill `w` with the currents of all transistors and their exact derivatives at node voltages `v`, V."""
    n = a.sign.size
    drain, gate, source, bulk = a.terminal[0], a.terminal[1], a.terminal[2], a.terminal[3]
    x, kappa, g = w.argument, w.kappa, w.conductance
    for i in range(n):
        s = a.sign[i]
        vb = v[bulk[i]]
        vg = s * (v[gate[i]] - vb)
        k = a.kappa[i]
        vp = k * (vg - a.v_t0[i])
        kappa[i] = k
        x[i] = (vp - s * (v[source[i]] - vb)) * a.inverse_2ut[i]
        x[n + i] = (vp - s * (v[drain[i]] - vb)) * a.inverse_2ut[i]
    if a.body_effect:
        for i in range(n):
            gm = a.gamma[i]
            if gm > 0.0:
                s = a.sign[i]
                vb = v[bulk[i]]
                phi = a.surface_potential[i]
                vx = s * (v[gate[i]] - vb) - a.v_t0[i] + phi + gm * np.sqrt(phi)
                # below flat band the square root has no meaning; the law goes on with its tangent there
                vc = max(vx, 0.0)
                root = np.sqrt(vc + 0.25 * gm * gm)
                kappa[i] = 1.0 - 0.5 * gm / root
                vp = vc - phi - gm * (root - 0.5 * gm) + kappa[i] * (vx - vc)
                x[i] = (vp - s * (v[source[i]] - vb)) * a.inverse_2ut[i]
                x[n + i] = (vp - s * (v[drain[i]] - vb)) * a.inverse_2ut[i]
    softplus(x, w.value, w.slope)
    for i in range(n):
        s = a.sign[i]
        ff, fr = w.value[i], w.value[n + i]
        scale = a.specific_current[i]
        vds = s * (v[drain[i]] - v[source[i]])
        early = 1.0 + a.early[i] * abs(vds)
        channel = scale * (ff - fr) * (ff + fr)
        slope = 2.0 * scale * a.inverse_2ut[i] * early
        forward, reverse = slope * ff * w.slope[i], slope * fr * w.slope[n + i]
        tilt = channel * (a.early[i] if vds >= 0.0 else -a.early[i])
        w.factor[i] = early
        w.current[i] = s * channel * early
        g[0, i] = reverse + tilt
        g[1, i] = kappa[i] * (forward - reverse)
        g[2, i] = -forward - tilt
    if a.reduces:
        _reduce(a, v, w)
    if a.leaks:
        _junction_currents(a, v, w)


@compiled()
def _reduce(a: TransistorArrays, v: F64, w: TransistorWork) -> None:
    """Scale currents of a constant Early voltage to one that rises with inversion, and by the mobility."""
    n = a.sign.size
    drain, source, bulk = a.terminal[0], a.terminal[2], a.terminal[3]
    x, g = w.argument, w.conductance
    for i in range(n):
        s = a.sign[i]
        half = a.inverse_2ut[i]
        ut = 0.5 / half
        vds = abs(s * (v[drain[i]] - v[source[i]]))
        vp = x[i] / half + s * (v[source[i]] - v[bulk[i]])
        rise = 1.0 + a.early_rise[i] * (w.value[i] + w.value[n + i])
        constant = 1.0 + a.early[i] * vds
        early = 1.0 + a.early[i] * vds / rise
        root = np.sqrt(vp * vp + 2.0 * ut * ut)
        # (v_p + root) / 2 without the loss of digits where v_p is far below zero
        vm = 0.5 * (vp + root) if vp >= 0.0 else ut * ut / (root - vp)
        mobility = 1.0 / (1.0 + a.reduction[i] * vm)
        scale = early / constant * mobility
        base = w.current[i] * s / constant  # without Early effect
        # derivatives of E M by q and v_p, and of E beyond that of a constant Early voltage by |v_d - v_s|
        by_q = -mobility * a.early[i] * a.early_rise[i] * vds / (rise * rise)
        by_vp = -early * mobility * mobility * a.reduction[i] * vm / root
        by_vds = mobility * a.early[i] * (1.0 / rise - early / constant)
        forward, reverse = half * w.slope[i], half * w.slope[n + i]
        sign = 1.0 if s * (v[drain[i]] - v[source[i]]) >= 0.0 else -1.0
        g[0, i] = g[0, i] * scale + base * (sign * by_vds - by_q * reverse)
        g[1, i] = g[1, i] * scale + base * w.kappa[i] * (by_q * (forward + reverse) + by_vp)
        g[2, i] = g[2, i] * scale - base * (sign * by_vds + by_q * forward)
        w.factor[i] = early * mobility
        w.current[i] *= scale


@compiled()
def _junction_currents(a: TransistorArrays, v: F64, w: TransistorWork) -> None:
    n = a.sign.size
    gate, bulk = a.terminal[1], a.terminal[3]
    for side in range(2):
        terminal = a.terminal[2 * side]
        for i in range(n):
            s = a.sign[i]
            u = 2.0 * a.inverse_2ut[i] * s * (v[terminal[i]] - v[bulk[i]])
            # forward bias beyond 20 U_T continues along the tangent: no circuit here drives a junction so far
            e = exp_negative(min(u, LIMIT)) if u >= 0.0 else 1.0 / exp_negative(min(-u, 20.0))
            extra = e * max(-u - 20.0, 0.0)
            leakage, by_gate = a.leakage[i], 0.0
            if a.induces:
                y = a.induced_per_volt[i] * (s * (v[terminal[i]] - v[gate[i]]) - a.induced_from[i])
                # ours: from 10 slopes above the supply on it stays, so that no iterate overflows
                induced = a.induced[i] * np.exp(min(y, INDUCED_LIMIT))
                leakage += induced
                if y < INDUCED_LIMIT:
                    by_gate = induced * a.induced_per_volt[i] * (1.0 - e - extra)
            w.leakage[side, i] = leakage
            w.junction[side, i] = s * leakage * (1.0 - e - extra)
            w.junction_conductance[side, i] = leakage * 2.0 * a.inverse_2ut[i] * e + by_gate
            w.junction_conductance[2 + side, i] = -by_gate


def capacitances(
    model: TransistorModel, width: F64, length: F64, multiplicity: F64
) -> dict[tuple[int, int], F64]:
    """Capacitances of n devices (F, float64[n]) by pair of terminal positions: drain, gate, source, bulk."""
    w = width * multiplicity
    gate_bulk = model.gate_bulk_fraction * model.oxide_capacitance * w * length
    overlap, junction = model.overlap_capacitance * w, model.junction_capacitance * w
    return {(1, 3): gate_bulk, (1, 0): overlap, (1, 2): overlap, (0, 3): junction, (2, 3): junction}


def drain_current(
    law: TransistorAtTemperature,
    polarity: Polarity,
    width: float,
    length: float,
    v_d: F64 | float,
    v_g: F64 | float,
    v_s: F64 | float,
    v_b: F64 | float = 0.0,
) -> F64:
    """Current into the drain of one device, A, in the shape to which its terminal voltages broadcast.

    Parameters
    ----------
    law
        Numbers of the polarity at one temperature (`Silicon.law`).
    polarity
        `n` or `p`.
    width, length
        Size of the device, m.
    v_d, v_g, v_s, v_b
        Voltages of drain, gate, source and bulk, V, of shapes that broadcast.
    """
    vd, vg, vs, vb = (np.atleast_1d(x) for x in np.broadcast_arrays(v_d, v_g, v_s, v_b))
    n = vd.size
    v = np.concatenate([vd.ravel(), vg.ravel(), vs.ravel(), vb.ravel()]).astype(np.float64)
    arrays = transistor_arrays(
        np.arange(4 * n, dtype=np.int32).reshape(4, n),
        polarity,
        law,
        np.full(n, width),
        np.full(n, length),
        np.ones(n),
    )
    work = transistor_work(n)
    drain_currents(arrays, v, work)
    return np.asarray((work.current + work.junction[0]).reshape(vd.shape))
