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
FORWARD = 20.0
"""U_T of forward bias beyond which a junction's law goes on along its tangent; ours."""
_NOTHING = 1e-30  # V, so that what is computed of a device without body effect is a number


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
    above: F64  # [3, n] drain, gate and source over the bulk, V, mirrored for a pFET
    pinch: F64  # [n] v_p, V
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
        np.zeros(2 * n), np.zeros(2 * n), np.zeros(2 * n), np.zeros((3, n)), np.zeros(n), np.zeros(n),
        np.zeros(n), np.zeros(n),
        np.zeros((3, n)), np.zeros((2, n)), np.zeros((2, n)), np.zeros((4, n)),
    )  # fmt: skip


@compiled(fastmath={"contract"})
def drain_currents(a: TransistorArrays, v: F64, w: TransistorWork) -> None:
    """Fill `w` with the currents of all transistors and their exact derivatives at node voltages `v`, V.

    Loops are short and without branches, so that the compiler packs them.
    """
    n = a.sign.size
    x, u, kappa, pinch = w.argument, w.above, w.kappa, w.pinch
    for end in range(3):
        terminal, bulk = a.terminal[end], a.terminal[3]
        for i in range(n):
            u[end, i] = a.sign[i] * (v[terminal[i]] - v[bulk[i]])
    for i in range(n):
        kappa[i] = a.kappa[i]
        pinch[i] = a.kappa[i] * (u[1, i] - a.v_t0[i])
    if a.body_effect:
        _bend(a, u[1], w)
    for i in range(n):
        x[i] = (pinch[i] - u[2, i]) * a.inverse_2ut[i]
        x[n + i] = (pinch[i] - u[0, i]) * a.inverse_2ut[i]
    softplus(x, w.value, w.slope)
    if a.reduces:
        _affected_channels(a, w)
    else:
        _channels(a, w)
    if a.leaks:
        _junction_currents(a, w)


@compiled(fastmath={"contract"})
def _channels(a: TransistorArrays, w: TransistorWork) -> None:
    """Currents of a constant Early voltage, and their derivatives."""
    n = a.sign.size
    u, g = w.above, w.conductance
    for i in range(n):
        ff, fr = w.value[i], w.value[n + i]
        vds = u[0, i] - u[2, i]
        early = 1.0 + a.early[i] * abs(vds)
        channel = a.specific_current[i] * (ff - fr) * (ff + fr)
        slope = 2.0 * a.specific_current[i] * a.inverse_2ut[i] * early
        forward, reverse = slope * ff * w.slope[i], slope * fr * w.slope[n + i]
        tilt = channel * (a.early[i] if vds >= 0.0 else -a.early[i])
        w.factor[i] = early
        w.current[i] = a.sign[i] * channel * early
        g[0, i] = reverse + tilt
        g[1, i] = w.kappa[i] * (forward - reverse)
        g[2, i] = -forward - tilt


@compiled(fastmath={"contract"})
def _bend(a: TransistorArrays, gate: F64, w: TransistorWork) -> None:
    """v_p and dv_p/dv_g with the body effect, where there is one."""
    for i in range(gate.size):
        gm, phi = a.gamma[i], a.surface_potential[i]
        bent = 1.0 if gm > 0.0 else 0.0
        vx = gate[i] - a.v_t0[i] + phi + gm * np.sqrt(phi)
        # below flat band the square root has no meaning; the law goes on with its tangent there
        vc = max(vx, 0.0)
        root = np.sqrt(vc + 0.25 * gm * gm + _NOTHING)
        kappa = 1.0 - 0.5 * gm / root
        vp = vc - phi - gm * (root - 0.5 * gm) + kappa * (vx - vc)
        w.kappa[i] = bent * kappa + (1.0 - bent) * w.kappa[i]
        w.pinch[i] = bent * vp + (1.0 - bent) * w.pinch[i]


@compiled(fastmath={"contract"})
def _affected_channels(a: TransistorArrays, w: TransistorWork) -> None:
    """Currents of an Early voltage that rises with inversion and a mobility that falls, and their slopes."""
    n = a.sign.size
    u, g = w.above, w.conductance
    for i in range(n):
        half, ff, fr = a.inverse_2ut[i], w.value[i], w.value[n + i]
        plain, twice = a.specific_current[i] * (ff - fr) * (ff + fr), 2.0 * a.specific_current[i] * half
        vp, across = w.pinch[i], u[0, i] - u[2, i]
        vds = abs(across)
        rise = 1.0 + a.early_rise[i] * (ff + fr)
        root = np.sqrt(vp * vp + 0.5 / (half * half))
        vm = 0.5 * (vp + root)
        moves = 1.0 + a.reduction[i] * vm
        # one division for three
        inverse = 1.0 / (rise * moves * root)
        per_rise, mobility = inverse * (moves * root), inverse * (rise * root)
        early = 1.0 + a.early[i] * vds * per_rise
        scale = early * mobility
        # derivatives of E M by q, v_p and v_d - v_s
        by_q = -mobility * a.early[i] * a.early_rise[i] * vds * per_rise * per_rise
        by_vp = -scale * mobility * a.reduction[i] * vm * (inverse * (rise * moves))
        by_vds = mobility * a.early[i] * per_rise
        by_vds = by_vds if across >= 0.0 else -by_vds
        forward, reverse = half * w.slope[i], half * w.slope[n + i]
        by_forward, by_reverse = twice * ff * w.slope[i], twice * fr * w.slope[n + i]
        g[0, i] = by_reverse * scale + plain * (by_vds - by_q * reverse)
        by_pinch = (by_forward - by_reverse) * scale + plain * (by_q * (forward + reverse) + by_vp)
        g[1, i] = w.kappa[i] * by_pinch
        g[2, i] = -by_forward * scale - plain * (by_vds + by_q * forward)
        w.factor[i] = scale
        w.current[i] = a.sign[i] * plain * scale


@compiled(fastmath={"contract"})
def _junction_currents(a: TransistorArrays, w: TransistorWork) -> None:
    for side in range(2):
        u, leakage, by_gate = w.above[2 * side], w.leakage[side], w.junction_conductance[2 + side]
        current, conductance = w.junction[side], w.junction_conductance[side]
        for i in range(u.size):
            leakage[i], by_gate[i] = a.leakage[i], 0.0
        if a.induces:
            _induce(a, u, w.above[1], leakage, by_gate)
        for i in range(u.size):
            per_volt = 2.0 * a.inverse_2ut[i]
            y = per_volt * u[i]
            # forward bias beyond 20 U_T continues along the tangent: no circuit here drives a junction so far
            e = exp_negative(max(min(y, LIMIT), -FORWARD))
            flow = 1.0 - e - e * max(-y - FORWARD, 0.0)
            current[i] = a.sign[i] * leakage[i] * flow
            conductance[i] = leakage[i] * per_volt * e + by_gate[i] * flow
            by_gate[i] = -by_gate[i] * flow


@compiled(fastmath={"contract"})
def _induce(a: TransistorArrays, end: F64, gate: F64, leakage: F64, by_gate: F64) -> None:
    """Add to a junction's leakage what the gate induces in it; its derivative by the gate's voltage."""
    for i in range(end.size):
        y = a.induced_per_volt[i] * (end[i] - gate[i] - a.induced_from[i])
        # ours: from 10 slopes above the supply on it stays, so that no iterate overflows
        induced = a.induced[i] * exp_negative(min(max(-y, -INDUCED_LIMIT), LIMIT))
        leakage[i] += induced
        by_gate[i] = induced * a.induced_per_volt[i] * (1.0 if y < INDUCED_LIMIT else 0.0)


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
