"""The transistor's channel with second-order effects, in all lanes at once.

Equations are those of `circuits.devices.transistor`, and their derivatives as in `circuits.devices.channel`,
which has them for one device. Logarithms and powers are those of `circuits.devices.softplus`. Kernels that
hold runs or devices side by side (`circuits.vectors.vector`) call these with a value of all lanes in the
place of each number; voltages are to the bulk, and mirrored for a pFET.
"""

from __future__ import annotations

from typing import NamedTuple

from circuits.compiled import compiled
from circuits.devices.softplus import softplus_of_two
from circuits.vectors import vector
from circuits.vectors.vector import Lanes

every, larger, magnitude, root, select = (
    vector.every, vector.larger, vector.magnitude, vector.root, vector.select,
)  # fmt: skip


class Effects(NamedTuple):
    """Terms of the second-order effects as in `circuits.devices.channel.Terms`; spread: 2 U_T^2, V^2."""

    early: Lanes
    early_rise: Lanes
    reduction: Lanes
    spread: Lanes


@compiled(forceinline=True)
def bent(v_p: Lanes, kappa: Lanes, v_x: Lanes, gamma: Lanes, surface: Lanes) -> tuple[Lanes, Lanes]:
    """v_p (V) and dv_p/dv_g with the body effect, and as given where gamma is 0.

    v_x: gate over the threshold, plus `2 phi_F + gamma sqrt(2 phi_F)`, V; surface: 2 phi_F, V.
    """
    # below flat band the square root has no meaning; the law goes on with its tangent there
    v_c = larger(v_x, every(0.0))
    inside = root(v_c + 0.25 * gamma * gamma)
    bends = gamma > 0.0
    slope = 1.0 - 0.5 * gamma / select(bends, inside, every(1.0))
    follows = v_c - surface - gamma * (inside - 0.5 * gamma) + slope * (v_x - v_c)
    return select(bends, follows, v_p), select(bends, slope, kappa)


@compiled(forceinline=True)
def _ends(specific: Lanes, half: Lanes, v_d: Lanes, v_p: Lanes, v_s: Lanes) -> tuple[Lanes, ...]:
    """`ln(1 + e^x)` at source and drain, both slopes, and the current without effects with its slopes there.

    The current is in A, its slopes by the voltage at the source's end and at the drain's in S.
    """
    forward, reverse, forward_slope, reverse_slope = softplus_of_two((v_p - v_s) * half, (v_p - v_d) * half)
    plain = specific * (forward - reverse) * (forward + reverse)
    twice = 2.0 * specific * half
    by_forward, by_reverse = twice * forward * forward_slope, twice * reverse * reverse_slope
    return forward, reverse, forward_slope, reverse_slope, plain, by_forward, by_reverse


@compiled(forceinline=True)
def channel_plain(
    specific: Lanes, half: Lanes, v_d: Lanes, v_p: Lanes, v_s: Lanes
) -> tuple[Lanes, Lanes, Lanes, Lanes]:
    """Current from drain to source (A) without effects, and its derivatives by v_d, v_p and v_s, S."""
    _, _, _, _, plain, by_forward, by_reverse = _ends(specific, half, v_d, v_p, v_s)
    return plain, by_reverse, by_forward - by_reverse, 0.0 - by_forward


@compiled(forceinline=True)
def channel_affected(
    specific: Lanes, half: Lanes, e: Effects, v_d: Lanes, v_p: Lanes, v_s: Lanes
) -> tuple[Lanes, Lanes, Lanes, Lanes]:
    """Current from drain to source (A) with all effects, and its derivatives by v_d, v_p and v_s, S."""
    forward, reverse, forward_slope, reverse_slope, plain, by_forward, by_reverse = _ends(
        specific, half, v_d, v_p, v_s
    )
    v_ds = v_d - v_s
    sign = select(v_ds >= 0.0, every(1.0), every(-1.0))
    v_ds = magnitude(v_ds)
    rise = 1.0 + e.early_rise * (forward + reverse)
    around = root(v_p * v_p + e.spread)
    v_m = 0.5 * (v_p + around)
    moves = 1.0 + e.reduction * v_m
    # one division for three
    inverse = 1.0 / (rise * moves * around)
    per_rise, moved = inverse * (moves * around), inverse * (rise * around)
    effect = 1.0 + e.early * v_ds * per_rise
    scale = effect * moved
    by_vp = 0.0 - scale * moved * e.reduction * v_m * (inverse * (rise * moves))
    by_vds = sign * moved * e.early * per_rise
    by_q = 0.0 - moved * e.early * e.early_rise * v_ds * per_rise * per_rise
    forward_q, reverse_q = half * forward_slope, half * reverse_slope
    return (
        plain * scale,
        by_reverse * scale + plain * (by_vds - by_q * reverse_q),
        (by_forward - by_reverse) * scale + plain * (by_q * (forward_q + reverse_q) + by_vp),
        0.0 - by_forward * scale - plain * (by_vds + by_q * forward_q),
    )
