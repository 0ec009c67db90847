"""The transistor's law with second-order effects, one device at a time, for chips' kernels and models.

The law is that of `circuits.devices.transistor`, where its equations stand; the solver evaluates many devices
at once there. Here are the same equations of one device as compiled functions, which kernels of behavioural
models call with the numbers of each of their devices (`Terms`), and as functions of arrays, which models call
while they are built:

| in kernels | of arrays | what |
|---|---|---|
| `pinched(t, v_g)` | `pinch_off_of(law, height)` | v_p, with body effect |
| | `height_of(law, v_p)` | v_g - V_T0, the inverse |
| `channel(t, v_d, v_g, v_s)` | `circuits.devices.transistor.drain_current` | `I_S [F(u_f) - F(u_r)] E M` |
| `leaked(t, v_j, v_g)` | | what a junction takes to the bulk |
| | `mobility(law, v_p)`, `early(law, length, v_ds, root)` | M, and E |

All voltages are to the bulk, and mirrored for a pFET.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.transistor import INDUCED_LIMIT
from circuits.silicon.process import TransistorAtTemperature


class Terms(NamedTuple):
    """Numbers of one transistor at one temperature: its polarity's, its size's and its own deviations'.

    specific: I_S, A. threshold: V_T0, V. half: `1 / (2 U_T)`, 1/V. kappa; gamma, V^0.5, 0 for constant kappa;
    surface: 2 phi_F, V. early: `1 / (V_E L)`, 1/V, and its rise; reduction: of the mobility, 1/V. leakage: of
    a junction, A; induced: what a gate adds to it at `induced_from` V, A; induced_slope: 1/V.
    """

    specific: float
    threshold: float
    half: float
    kappa: float
    gamma: float
    surface: float
    early: float
    early_rise: float
    reduction: float
    leakage: float
    induced: float
    induced_from: float
    induced_slope: float


def terms_of(
    law: TransistorAtTemperature, width: float, length: float, specific: float, threshold: float
) -> Terms:
    """Numbers of a transistor whose own deviations are in `specific` and `threshold`.

    Parameters
    ----------
    law
        What its polarity shares at its temperature.
    width, length
        Its size, m; the width of all its devices.
    specific
        Its specific current I_S, A.
    threshold
        Its threshold voltage V_T0, V.
    """
    return Terms(
        specific, threshold, 0.5 / law.u_t, law.kappa, law.gamma, law.surface_potential,
        1.0 / (law.early_field * length) if law.early_field > 0.0 else 0.0, law.early_rise,
        law.mobility_reduction, law.junction_leakage * width, law.gate_induced_leakage * width,
        law.gate_induced_from, 1.0 / law.gate_induced_slope,
    )  # fmt: skip


@compiled(forceinline=True)
def pinched(t: Terms, v_g: float) -> tuple[float, float]:
    """v_p (V) at a gate voltage (V), and dv_p/dv_g."""
    if t.gamma == 0.0:
        return t.kappa * (v_g - t.threshold), t.kappa
    # below flat band the square root has no meaning; the law goes on with its tangent there
    v_x = v_g - t.threshold + t.surface + t.gamma * math.sqrt(t.surface)
    v_c = max(v_x, 0.0)
    root = math.sqrt(v_c + 0.25 * t.gamma * t.gamma)
    kappa = 1.0 - 0.5 * t.gamma / root
    return v_c - t.surface - t.gamma * (root - 0.5 * t.gamma) + kappa * (v_x - v_c), kappa


@compiled(forceinline=True)
def _root(x: float) -> tuple[float, float]:
    """ln(1 + e^x), and its derivative by x."""
    e = math.exp(-abs(x))
    s = 1.0 / (1.0 + e)
    return max(x, 0.0) + math.log1p(e), s if x >= 0.0 else e * s


@compiled(forceinline=True)
def channel(t: Terms, v_d: float, v_g: float, v_s: float) -> tuple[float, float, float, float]:
    """Current from drain to source, A, and its derivatives by v_d, v_g and v_s (V), S; no junctions in it."""
    v_p, kappa = pinched(t, v_g)
    forward, reverse = _root((v_p - v_s) * t.half), _root((v_p - v_d) * t.half)
    return channel_between(t, (v_d, v_s), (v_p, kappa), forward, reverse)


@compiled(forceinline=True)
def channel_between(
    t: Terms, ends: tuple[float, float], pinch: tuple[float, float], at_source: tuple[float, float],
    at_drain: tuple[float, float],
) -> tuple[float, float, float, float]:  # fmt: skip
    """What `channel` gives, of what holds at its ends.

    ends: v_d and v_s, V. pinch: as of `pinched`. at_source, at_drain: `ln(1 + e^x)`, x being
    `(v_p - v) / (2 U_T)`, and its derivative by x.
    """
    return channel_in(t, ends, pinch, field_at(t, pinch[0]), at_source, at_drain)


@compiled(forceinline=True)
def field_at(t: Terms, v_p: float) -> tuple[float, float, float]:
    """M at v_p (V), and of what it is made: v_m and the root in it, V."""
    # (v_p + root) / 2 without the loss of digits where v_p is far below zero
    two = 2.0 * (0.5 / t.half) ** 2  # 2 U_T^2
    root = math.sqrt(v_p * v_p + two)
    v_m = 0.5 * (v_p + root) if v_p >= 0.0 else 0.5 * two / (root - v_p)
    return 1.0 / (1.0 + t.reduction * v_m), v_m, root


@compiled(forceinline=True)
def channel_in(
    t: Terms, ends: tuple[float, float], pinch: tuple[float, float], field: tuple[float, float, float],
    at_source: tuple[float, float], at_drain: tuple[float, float],
) -> tuple[float, float, float, float]:  # fmt: skip
    """What `channel_between` gives; field: as of `field_at`, which stays where the gate does."""
    (v_d, v_s), (_, kappa), (moved, v_m, root) = ends, pinch, field
    (forward, forward_slope), (reverse, reverse_slope) = at_source, at_drain
    plain = t.specific * (forward - reverse) * (forward + reverse)
    by_forward = 2.0 * t.specific * t.half * forward * forward_slope
    by_reverse = 2.0 * t.specific * t.half * reverse * reverse_slope
    if t.early == 0.0 and t.reduction == 0.0:
        return plain, by_reverse, kappa * (by_forward - by_reverse), -by_forward
    sign = 1.0 if v_d >= v_s else -1.0
    v_ds = sign * (v_d - v_s)
    rise = 1.0 + t.early_rise * (forward + reverse)
    effect = 1.0 + t.early * v_ds / rise
    effect_by_q = -t.early * t.early_rise * v_ds / (rise * rise)
    scale = effect * moved
    forward_q, reverse_q = t.half * forward_slope, t.half * reverse_slope
    by_vp = -effect * moved * moved * t.reduction * v_m / root
    by_vds = sign * moved * t.early / rise
    by_q = moved * effect_by_q
    return (
        plain * scale,
        by_reverse * scale + plain * (by_vds - by_q * reverse_q),
        kappa * ((by_forward - by_reverse) * scale + plain * (by_q * (forward_q + reverse_q) + by_vp)),
        -by_forward * scale - plain * (by_vds + by_q * forward_q),
    )


@compiled(forceinline=True)
def leaked(t: Terms, v_j: float, v_g: float) -> tuple[float, float, float]:
    """Current of the junction at v_j (V) into the bulk, A, and its derivatives by v_j and v_g (V), S."""
    u, y = junction_at(t, v_j, v_g)
    e = math.exp(-min(u, 700.0)) if u >= -20.0 else math.exp(20.0)
    return leaked_at(t, (u, y), e, math.exp(min(y, INDUCED_LIMIT)))


@compiled(forceinline=True)
def junction_at(t: Terms, v_j: float, v_g: float) -> tuple[float, float]:
    """The junction's voltage in U_T, and the argument of what its gate induces."""
    return 2.0 * t.half * v_j, t.induced_slope * (v_j - v_g - t.induced_from)


@compiled(forceinline=True)
def leaked_at(t: Terms, at: tuple[float, float], e: float, grown: float) -> tuple[float, float, float]:
    """What `leaked` gives; at: as of `junction_at`, e, grown: both exponentials, limited."""
    u, y = at
    extra = e * max(-u - 20.0, 0.0)  # forward bias goes on along the tangent, as in the solver
    taken = 1.0 - e - extra
    induced = t.induced * grown
    by_gate = induced * t.induced_slope * taken if y < INDUCED_LIMIT else 0.0
    total = t.leakage + induced
    return total * taken, total * 2.0 * t.half * e + by_gate, -by_gate


def pinch_off_of(law: TransistorAtTemperature, height: F64 | float) -> F64:
    """v_p (V) where the gate is `height` V above the threshold V_T0, in the shape of `height`."""
    above = np.asarray(height, dtype=np.float64)
    if law.gamma == 0.0:
        return np.asarray(law.kappa * above)
    v_x = above + law.surface_potential + law.gamma * math.sqrt(law.surface_potential)
    v_c = np.maximum(v_x, 0.0)
    root = np.sqrt(v_c + 0.25 * law.gamma**2)
    kappa = 1.0 - 0.5 * law.gamma / root
    found = v_c - law.surface_potential - law.gamma * (root - 0.5 * law.gamma) + kappa * (v_x - v_c)
    return np.asarray(found)


def height_of(law: TransistorAtTemperature, v_p: F64 | float) -> F64:
    """Gate voltage less V_T0 (V) at a pinch-off voltage (V) above flat band, in the shape of `v_p`.

    Below flat band, where `v_p` is under `-2 phi_F`, it is that at flat band.
    """
    if law.gamma == 0.0:
        return np.asarray(np.asarray(v_p, dtype=np.float64) / law.kappa)
    # the pinch-off law inverted: with r = sqrt(v_x + gamma^2/4), v_p + phi = r^2 - gamma r + gamma^2/4
    half = 0.5 * law.gamma
    above = np.maximum(np.asarray(v_p, dtype=np.float64) + law.surface_potential, 0.0)
    v_x = (half + np.sqrt(above)) ** 2 - half**2
    return np.asarray(v_x - law.surface_potential - law.gamma * math.sqrt(law.surface_potential))


def mobility(law: TransistorAtTemperature, v_p: F64 | float) -> F64:
    """M, what the field across the oxide leaves of the mobility at a pinch-off voltage (V), a ratio."""
    v = np.asarray(v_p, dtype=np.float64)
    if law.mobility_reduction == 0.0:
        return np.ones_like(v)
    v_m = 0.5 * (v + np.hypot(v, math.sqrt(2.0) * law.u_t))
    return np.asarray(1.0 / (1.0 + law.mobility_reduction * v_m))


def early(law: TransistorAtTemperature, length: F64 | float, v_ds: F64 | float, root: F64 | float) -> F64:
    """E, the Early effect, a ratio.

    Parameters
    ----------
    law
        What the device's polarity shares at its temperature.
    length
        Length of the device, m.
    v_ds
        Magnitude of the voltage between its drain and its source, V.
    root
        `sqrt(F(u_f)) + sqrt(F(u_r))`, the inversion at both ends of the channel.
    """
    voltage = np.asarray(v_ds, dtype=np.float64)
    if law.early_field == 0.0:
        return np.ones_like(voltage)
    return np.asarray(1.0 + voltage / (law.early_field * length * (1.0 + law.early_rise * np.asarray(root))))
