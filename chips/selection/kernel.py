"""Compiled decision of the selection: which cell wins, and when (`chips.selection.model`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.selection.whole_kernel import NOBODY, Whole, decide_whole
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.ekv import argument_of_root, law, steepness_of_root

_ITERATIONS = 60


class Selection(NamedTuple):
    """A winner-take-all circuit on a die at a temperature, as arrays for `decide`; N cells, M mirrors each.

    Deviations are logarithms of beta, and thresholds in V times kappa / U_T.
    """

    weight: F64  # [M], of the projection, by distance from -reach to +reach
    excite_beta: F64  # [N], of the mirror mx, my
    excite_threshold: F64
    risk_beta: F64  # [N, M], of mk, mg
    risk_threshold: F64
    cell_beta: F64  # [N], of m1
    cell_threshold: F64
    share_beta: F64  # [N], of m2
    share_threshold: F64
    turn: F64  # [N], A, of m2, at which the comparator turns
    out_gain: F64  # [N], of mo, ms
    tail: float  # A
    excite_specific: float  # I_S, A
    risk_specific: float
    cell_specific: float
    share_specific: float
    slope: float  # kappa / U_T of the nFETs, 1/V
    kappa: float  # of the nFETs
    input_capacitance: F64  # [N], C, F
    line_charge: float  # C, that turns the line
    whole: Whole  # the law with second-order effects, by which it decides then


@compiled()
def inversion(level: float) -> tuple[float, float]:
    """Return `h = d ln I / d(v_p / U_T)` of the EKV law at a current of `level` I_S, and its derivative."""
    if level < 1e-18:
        return 1.0, 0.0
    root = np.sqrt(level)
    h = steepness_of_root(root)
    return h, 0.5 * h * (np.exp(-root) - h)


@compiled()
def _log_gain(beta: float, threshold: float, h: float, slope: float) -> float:
    return beta - threshold * (h - 0.5 * threshold * slope)


@compiled()
def _argument(level: float) -> float:
    """Where `F(u)` is `level`: u."""
    return argument_of_root(np.sqrt(level))


@compiled()
def _rise(s: Selection, winner: int, best: float, joined: float) -> float:
    """How far the winner's v_in rises until the comparator turns, in units of U_T / kappa.

    best, joined: current of an m1 of strength 1 in the end and in the equalised state, A.
    """
    share = _argument(s.turn[winner] / s.share_specific)
    before = _argument(s.tail / (s.excite_beta.size * s.share_specific))
    common = _argument(best / s.cell_specific) - _argument(joined / s.cell_specific)
    return share - before + common / s.kappa


@compiled()
def decide_plain(s: Selection, excite: F64, risk: F64, scratch: F64) -> tuple[int, float, float]:
    """Return what `decide` does by the closed form, whatever the law."""
    n = s.excite_beta.size
    merit, rate, behind = scratch[0], scratch[1], scratch[2]
    joined = _merits(s, excite, risk, scratch)
    winner, second = 0, -1
    for k in range(1, n):
        if merit[k] > merit[winner]:
            winner, second = k, winner
        elif second < 0 or merit[k] > merit[second]:
            second = k
    if merit[winner] <= 0.0:
        return NOBODY, np.inf, 0.0
    margin = np.log(merit[winner] / merit[second]) if merit[second] > 0.0 else np.inf
    rise = _rise(s, winner, merit[winner], max(joined, 1e-3 * merit[winner]))
    for k in range(n):  # what a cell is behind, in units of U_T / kappa, and how fast it falls, 1/s
        behind[k] = s.share_threshold[k] - s.share_threshold[winner] + rise * (1.0 - rate[k] / rate[winner])
    for k in range(n):
        rate[k] *= s.slope * (merit[winner] - merit[k]) / s.input_capacitance[k]
    turned, growth = _parting(s, winner, rate, behind)
    if not turned < np.inf:
        return winner, np.inf, margin
    return winner, turned + _charging(s, winner, growth), margin


@compiled()
def decide(s: Selection, excite: F64, risk: F64, scratch: F64) -> tuple[int, float, float]:
    """Return the winner (-1 for nobody), the time from the release (s) and the margin of a decision.

    excite, risk: currents at the cells' ports, A, float64[N]; scratch: float64[4, N], whose first row has the
    merits (A) afterwards.
    """
    if s.whole.own.shape[0] > 0:
        return decide_whole(s.whole, excite, risk, scratch)
    return decide_plain(s, excite, risk, scratch)


@compiled()
def _merits(s: Selection, excite: F64, risk: F64, scratch: F64) -> float:
    """Merits (A) and strengths of all cells into rows 0 and 1; returns the equalised current of an m1, A."""
    n, mirrors = s.excite_beta.size, s.weight.size
    reach = mirrors // 2
    merit, strength, height, bend = scratch[0], scratch[1], scratch[2], scratch[3]
    total, strengths = 0.0, 0.0
    for k in range(n):
        height[k], bend[k] = inversion(risk[k] / s.risk_specific)
    for k in range(n):
        h, slope = inversion(excite[k] / s.excite_specific)
        current = excite[k] * np.exp(_log_gain(s.excite_beta[k], s.excite_threshold[k], h, slope))
        for m in range(max(0, reach - k), min(mirrors, n + reach - k)):
            j = k + m - reach
            log_gain = _log_gain(s.risk_beta[k, m], s.risk_threshold[k, m], height[j], bend[j])
            current -= s.weight[m] * np.exp(log_gain) * risk[j]
        h, slope = inversion(max(current, 0.0) / s.cell_specific)
        # from the current to the gate: the other way round than the second device of a mirror
        strength[k] = np.exp(-_log_gain(-s.cell_beta[k], -s.cell_threshold[k], h, slope))
        merit[k] = current / strength[k] if current > 0.0 else current
        total += current
        strengths += strength[k]
    return total / strengths


@compiled()
def _parting(s: Selection, winner: int, rate: F64, behind: F64) -> tuple[float, float]:
    """When m2 of the winner carries what turns the comparator, s, and how fast it grows then, A/s.

    Newton from 0: what all others carry is convex and falls with time, so that no step goes too far.
    """
    share = s.turn[winner]
    own_specific = s.share_specific * np.exp(s.share_beta[winner])
    root = np.sqrt(share / own_specific)
    top = _argument(share / own_specific)
    left = (s.tail - share) / s.share_specific
    time = 0.0
    total, steep, fall = 0.0, 0.0, 0.0
    for _ in range(_ITERATIONS):
        total, steep, fall = 0.0, 0.0, 0.0
        for k in range(rate.size):
            if k == winner:
                continue
            u = top - behind[k] - rate[k] * time
            gain = np.exp(s.share_beta[k])
            value, slope = law(u)
            total += value * gain
            steep += slope * gain
            fall += slope * gain * rate[k]
        if total <= left * (1.0 + 1e-9):
            break
        if fall <= 0.0:
            return np.inf, 0.0
        time += (total - left) / fall
    own = steepness_of_root(root) * root * root * np.exp(s.share_beta[winner])  # dF/du of the winner
    return time, s.share_specific * own * fall / (own + steep)


@compiled()
def _charging(s: Selection, winner: int, growth: float) -> float:
    """From there to the line, s: the excess `x(t) - x` of a logistic growth charges the output."""
    x = s.turn[winner] / s.tail
    pace = growth / (s.tail * x * (1.0 - x))  # 1/s
    needed = s.line_charge * pace / (s.out_gain[winner] * s.tail)
    odds = 1.0 / x - 1.0
    low, high = 0.0, np.sqrt(2.0 * needed / (x * (1.0 - x))) + needed / (1.0 - x) + 1.0
    for _ in range(_ITERATIONS):
        y = 0.5 * (low + high)
        # int_0^y (1 / (1 + odds e^-y') - x) dy'
        got = y + np.log((1.0 + odds * np.exp(-y)) / (1.0 + odds)) - x * y
        if got < needed:
            low = y
        else:
            high = y
    needed_time: float = 0.5 * (low + high) / pace
    return needed_time
