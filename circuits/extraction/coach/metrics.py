"""Numbers by which a measurement and its prediction are compared, each by one definition.

They are those that the conditions name under what is to be predicted and within what. A position on a swept
axis is what lies between two points: it has the value in the middle and both points as its ends. Where a
curve has no such number it is NaN. All of them take the files' own columns, so that measured and predicted
tables are read alike.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import DataError
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.table import Table

U_T = 25.85e-3
"""V, of all metrics: the laboratory's temperature is not known, so one value is agreed on (27 degC)."""
NEAR = 0.15  # V, within which kappa of a pair is read unless its condition says less
FOLLOWING = (0.44, 0.76)  # V of v1 within which an n amplifier's output follows
LEVEL_AT = 0.6  # V of v1 where its level is read
P_LEVEL = 0.15  # V of v1 above the jump where a p amplifier's level is read
TOP = 1.70  # V of output up to which a p amplifier follows
TAIL = 20.0  # counts above which a tail is read
SETTLED = 5  # samples at an end that are its level
FALLEN = 0.1  # V below rest from which a synapse's node is said to be down
FALL = 0.2  # V within a sample, of a membrane that is reset
RESET = 0.05  # V below which a membrane is said to be held at its reset


class Metric(NamedTuple):
    """A number of a curve.

    Attributes
    ----------
    value : float
        The number; NaN for none.
    low, high : float
        Ends of the interval that the points leave it; both the number itself where they leave none.
    unit : str
        Its unit.
    """

    value: float
    low: float
    high: float
    unit: str


Metrics = dict[str, Metric]
_Read = Callable[[Condition, Table], Metrics]


def metrics_of(condition: Condition, table: Table) -> Metrics:
    """Numbers of a measurement or its prediction, by name.

    condition: what was set. table: what was set and read, or predicted.

    Raises `DataError` where the table's measured columns are empty.
    """
    if all(np.isnan(column).all() for name, column in table.items() if name not in _SET):
        raise DataError(f"{condition.file}: no measured values, must have some; fill it in first")
    return _READ[condition.circuit](condition, table) if condition.circuit in _READ else {}


def _number(value: float | None, unit: str) -> Metric:
    found = math.nan if value is None else float(value)
    return Metric(found, found, found, unit)


def _between(first: float, second: float, unit: str) -> Metric:
    return Metric(0.5 * (first + second), min(first, second), max(first, second), unit)


def _line(x: F64, y: F64, chosen: Bools) -> tuple[float, float]:
    """Slope and value at the mean of x of the best straight line; NaN below three points."""
    chosen = chosen & np.isfinite(y)
    if int(chosen.sum()) < 3:
        return math.nan, math.nan
    centre = float(x[chosen].mean())
    slope, value = np.polyfit(x[chosen] - centre, y[chosen], 1)
    return float(slope), float(value - slope * centre)


def _crossing(x: F64, y: F64, level: float) -> float | None:
    """X at which y first passes a level, along straight lines between points."""
    above = y > level
    for k in np.flatnonzero(above[1:] != above[:-1]):
        return float(x[k] + (level - y[k]) / (y[k + 1] - y[k]) * (x[k + 1] - x[k]))
    return None


def _pair(condition: Condition, table: Table) -> Metrics:
    """Pair: kappa and offset by ln(I1 / I2) over v1 - v2, and the sum of both at balance."""
    dv = table["v1_V"] - table["v2_V"]
    i1, i2 = table["i1_A"], table["i2_A"]
    there = (np.abs(dv) < condition.settings.get("score_V", NEAR)) & (i1 > 0.0) & (i2 > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(i1 / i2)
    slope, at_zero = _line(dv, ratio, there)
    offset = -at_zero / slope
    total = np.interp(offset, dv, i1 + i2) if math.isfinite(offset) else math.nan
    return {
        "kappa": _number(slope * U_T, ""),
        "offset_V": _number(offset, "V"),
        "sum_at_balance_A": _number(total, "A"),
    }


def _bump(condition: Condition, table: Table) -> Metrics:
    """Bump: its centre and width at half its height, its height, its share of all current, tails."""
    del condition
    dv, out = table["v1_V"] - table["v2_V"], table["nout_counts"]
    peak = float(np.nanmax(out))
    at = int(np.nanargmax(out))
    left = _crossing(dv[at::-1], out[at::-1], 0.5 * peak)
    right = _crossing(dv[at:], out[at:], 0.5 * peak)
    centre = None if left is None or right is None else 0.5 * (left + right)
    width = None if left is None or right is None else right - left
    near = np.argsort(np.abs(dv - (centre or 0.0)))[:SETTLED]
    total = table["i1_A"] + table["i2_A"] + table["iout_A"]
    return {
        "centre_V": _number(centre, "V"),
        "width_V": _number(width, "V"),
        "height_counts": _number(peak, "counts"),
        "peak_fraction": _number(float((table["iout_A"][near] / total[near]).mean()), ""),
        "tail_1_counts": _number(float(np.nanmean(table["n1_counts"][-SETTLED:])), "counts"),
        "tail_2_counts": _number(float(np.nanmean(table["n2_counts"][:SETTLED])), "counts"),
    }


def _jump(x: F64, y: F64) -> tuple[Metric, int]:
    """The two points between which a curve steps most, and the number of the first of them."""
    k = int(np.nanargmax(np.abs(np.diff(y))))
    return _between(float(x[k]), float(x[k + 1]), "V"), k


def _n_amplifier(condition: Condition, table: Table) -> Metrics:
    """N amplifier: slope and level of the branch that follows, the jump, the high level."""
    del condition
    v1, out = table["v1_V"], table["v_out_V"]
    jump, k = _jump(v1, out)
    low, high = FOLLOWING
    slope, at_zero = _line(v1, out, (v1 > low) & (v1 < high) & (v1 <= v1[k]))
    level = float(np.interp(LEVEL_AT, v1[: k + 1], out[: k + 1])) if v1[k] >= LEVEL_AT else None
    if level is None:  # the branch ends before: where it would be half way to the jump
        level = float(np.interp(0.5 * v1[k], v1[: k + 1], out[: k + 1]))
    del at_zero
    return {
        "slope": _number(slope, ""),
        "level_V": _number(level, "V"),
        "jump_V": jump,
        "high_V": _number(float(np.nanmedian(out[k + 2 :])) if k + 2 < out.size else None, "V"),
    }


def _p_amplifier(condition: Condition, table: Table) -> Metrics:
    """P amplifier: low level, the jump, slope and level of the branch that follows above it."""
    del condition
    v1, out = table["v1_V"], table["v_out_V"]
    jump, k = _jump(v1, out)
    after = (v1 > v1[k + 1]) & (out < TOP)
    slope, at_zero = _line(v1, out, after)
    return {
        "slope": _number(slope, ""),
        "level_V": _number(at_zero + slope * (jump.value + P_LEVEL), "V"),
        "jump_V": jump,
        "low_V": _number(float(np.nanmedian(out[: max(k - 1, 1)])), "V"),
    }


def _wide_amplifier(condition: Condition, table: Table) -> Metrics:
    """Wide-range amplifier: where the output passes the middle of its levels, and both levels."""
    del condition
    v1, out = table["v1_V"], table["v_out_V"]
    low, high = float(np.nanmedian(out[:SETTLED])), float(np.nanmedian(out[-SETTLED:]))
    above = np.flatnonzero(out > 0.5 * (low + high))
    k = int(above[0]) if above.size and above[0] > 0 else -1
    at = _number(None, "V") if k < 0 else _between(float(v1[k - 1]), float(v1[k]), "V")
    return {"transition_V": at, "low_V": _number(low, "V"), "high_V": _number(high, "V")}


def _copies(condition: Condition, table: Table) -> Metrics:
    """Copies: both saturated currents, where they are equal, and logarithms of both tails."""
    del condition
    dv = table["v1_V"] - table["v2_V"]
    order = np.argsort(dv)
    dv = dv[order]
    plus, minus = table["i_plus_A"][order], table["i_minus_A"][order]
    found = {
        "saturated_plus_A": _number(float(np.nanmean(plus[-SETTLED:])), "A"),
        "saturated_minus_A": _number(float(np.nanmean(minus[:SETTLED])), "A"),
        "zero_crossing_V": _number(_crossing(dv, plus - minus, 0.0), "V"),
    }
    for name, count, sign in (
        ("plus", table["n_plus_counts"][order], -1.0), ("minus", table["n_minus_counts"][order], 1.0),
    ):  # fmt: skip
        here = (sign * dv > 0.0) & (count > TAIL)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope, at_zero = _line(dv, np.log(count), here)
        found[f"tail_{name}_slope_per_V"] = _number(slope, "1/V")
        found[f"tail_{name}_ln_counts"] = _number(at_zero, "")
    return found


def _follower(condition: Condition, table: Table) -> Metrics:
    """Follower: the slew rate between 10 and 40 % of a step and tau of its end; gain and phase of a sine."""
    if condition.settings["input"] == "sine":
        return _sine(table)
    time, out = table["t_s"], table["v_out_V"]
    first, last = float(out[0]), float(np.nanmedian(out[-out.size // 4 :]))
    share = (out - first) / (last - first)
    begin, end = (int(np.argmax(share > at)) for at in (0.1, 0.4))
    rising = (np.arange(out.size) >= begin) & (np.arange(out.size) <= max(end, begin + 2))
    slew, _ = _line(time, out, rising)
    # the end of the step: from 30 mV to 4 mV before where it settles, by least squares on the logarithm
    left = last - out
    far = left > 0.03
    begin = int(np.flatnonzero(far)[-1]) + 1 if far.any() else 0
    near = np.flatnonzero(left[begin:] < 0.004)
    end = begin + int(near[0]) if near.size else out.size
    chosen = (np.arange(out.size) >= begin) & (np.arange(out.size) < end) & (left > 0.0)
    fall, _ = _line(time, np.log(np.where(left > 0.0, left, 1.0)), chosen)
    return {
        "slew_V_per_s": _number(slew, "V/s"),
        "tau_s": _number(-1.0 / fall, "s"),
        "final_V": _number(last, "V"),
    }


def _sine(table: Table) -> Metrics:
    """Gain and phase of the output over the input, by least squares of a sine each."""
    phase = table["phase_rad"]
    basis = np.column_stack([np.ones(phase.size), np.sin(phase), np.cos(phase)])
    found = [np.linalg.lstsq(basis, table[name], rcond=None)[0] for name in ("v_in_V", "v_out_V")]
    given, out = (complex(float(each[1]), float(each[2])) for each in found)
    ratio = out / given
    return {
        "gain": _number(abs(ratio), ""),
        "phase_rad": _number(math.atan2(ratio.imag, ratio.real), "rad"),
    }


def _ring(condition: Condition, table: Table) -> Metrics:
    """Ring: where cell 0 takes and loses the win as its input falls and rises, and levels of both."""
    del condition
    v, out0, out1 = table["v_in0_V"], table["v_out0_V"], table["v_out1_V"]
    half = v.size // 2
    wins = out0 > out1
    found: Metrics = {}
    for name, part in (("down", slice(0, half)), ("up", slice(half, v.size))):
        x, won = v[part], wins[part]
        moved = np.flatnonzero(won[1:] != won[:-1])
        at = _number(None, "V")
        if moved.size:
            k = int(moved[0])
            at = _between(float(x[k]), float(x[k + 1]), "V")
        found[f"switch_{name}_V"] = at
    down, up = found["switch_down_V"], found["switch_up_V"]
    found["width_V"] = Metric(up.value - down.value, up.low - down.high, up.high - down.low, "V")
    for name, one, other in (("0", out0, wins), ("1", out1, ~wins)):
        found[f"winner_{name}_V"] = _number(float(np.nanmedian(one[other])) if other.any() else None, "V")
        found[f"loser_{name}_V"] = _number(float(np.nanmedian(one[~other])) if (~other).any() else None, "V")
    return found


def _synapse(condition: Condition, table: Table) -> Metrics:
    """Synapse: the lowest reading, its ramp a sample, how long it is down, the largest count."""
    del condition
    v, count = table["v_syn_V"], table["n_isyn_counts"]
    rest, low = float(np.nanmedian(v)), float(np.nanmin(v))
    steps = np.diff(v)
    inside = (v[:-1] > low - 0.01) & (v[1:] < rest - 0.03) & (steps > 0.01)
    down = float((v < rest - FALLEN).sum()) / 2.0
    return {
        "minimum_V": _number(low, "V"),
        "rest_V": _number(rest, "V"),
        "ramp_V_per_sample": _number(float(np.median(steps[inside])) if inside.any() else None, "V"),
        "down_samples": _number(down, "samples"),
        "peak_counts": _number(float(np.nanmax(count)), "counts"),
    }


def _axon_hillock(condition: Condition, table: Table) -> Metrics:
    """Axon-hillock: jumps, the voltages just before them, and the slopes between, over nominal time."""
    del condition
    time, v = table["t_nominal_s"], table["v_mem_V"]
    step = np.diff(v)
    big = max(0.15, 0.4 * float(np.nanmax(np.abs(step))))
    ups, downs = np.flatnonzero(step > big), np.flatnonzero(step < -big)
    rate = np.diff(v) / np.diff(time)
    rising, falling = (rate > 0.0) & (step < big), (rate < 0.0) & (step > -big)
    return {
        "jump_up_V": _number(float(step[ups].mean()) if ups.size else None, "V"),
        "jump_down_V": _number(float(step[downs].mean()) if downs.size else None, "V"),
        "threshold_up_V": _number(float(v[ups].mean()) if ups.size else None, "V"),
        "threshold_down_V": _number(float(v[downs].mean()) if downs.size else None, "V"),
        "rise_V_per_s": _number(float(np.median(rate[rising])) if rising.any() else None, "V/s"),
        "fall_V_per_s": _number(float(np.median(rate[falling])) if falling.any() else None, "V/s"),
    }


def _neuron(condition: Condition, table: Table) -> Metrics:
    """Neuron: interval between resets and time at reset in samples, and the inflection of the membrane."""
    del condition
    v = table["v_mem_V"]
    low = v < RESET
    begins = np.flatnonzero(np.diff(v) < -FALL) + 1
    begins = begins[np.diff(begins, prepend=-9) > 1]  # a fall over two samples is one
    isi = float(begins[-1] - begins[0]) / (begins.size - 1) if begins.size > 1 else None
    held = float(low[begins[0] : begins[-1]].sum()) / (begins.size - 1) if begins.size > 1 else None
    inflections = []
    for a, b in itertools.pairwise(begins):
        smooth = np.convolve(v[a:b], np.ones(3) / 3.0, "valid")
        slope = np.diff(smooth)
        inside = slice(2 + int(held or 0), max(slope.size - 2, 3 + int(held or 0)))
        if slope[inside].size:
            inflections.append(float(smooth[inside][int(np.argmin(slope[inside]))]))
    return {
        "isi_samples": _number(isi, "samples"),
        "held_samples": _number(held, "samples"),
        "inflection_V": _number(float(np.mean(inflections)) if inflections else None, "V"),
    }


_SET = {"v1_V", "v2_V", "t_s", "t_nominal_s", "phase_rad", "v_in_V", "v_in0_V", "fine_code", "v_g_V", "v_d_V"}
_READ: Mapping[str, _Read] = {
    "differential-pair": _pair, "bump-antibump": _bump, "transamp-n": _n_amplifier,
    "transamp-p": _p_amplifier, "wide-range-transamp": _wide_amplifier, "transamp-n-copies": _copies,
    "follower-integrator": _follower, "winner-take-all-ring": _ring, "dpi-synapse": _synapse,
    "axon-hillock": _axon_hillock, "adaptive-neuron": _neuron,
}  # fmt: skip

RELATIVE: tuple[tuple[str, str, str, str], ...] = (
    ("ndp_run3", "sum_at_balance_A", "ndp_run1", "ratio"),
    *((f"nta_vout_{k}", "level_V", "nta_vout_2", "shift") for k in (1, 3)),
    ("pta_vout_1", "level_V", "pta_vout_2", "shift"),
    *((f"dpi_{k}", "ramp_V_per_sample", "dpi_base", "ratio") for k in
      ("w50", "w150", "tau10", "tau40", "thr10", "thr80", "pex6", "pex14")),
    *((f"acn_{k}", "isi_samples", "acn_dc10", "ratio") for k in
      ("dc10_rep", "dc32", "dc32_refr3.8nA_1", "dc32_refr460pA_20")),
    *((f"acn_{k}", "held_samples", "acn_dc32", "ratio") for k in ("dc32_refr3.8nA_1", "dc32_refr460pA_20")),
)  # fmt: skip
"""Numbers that are judged against those of another file: file, metric, the other file, ratio or shift."""
