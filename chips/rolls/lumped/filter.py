"""Filters (differential-pair integrators) of a ROLLS chip, lumped from their transistors for its steps.

With the law of its devices in weak inversion and p = kappa (v_g - V_T0) / U_T:

    u = I_1 / I_2 = (I_S1 / I_S2) e^(p_thr - p_2),  p_2 = kappa_n (v_syn / U_T - t_2)
    tau = C U_T / (kappa_n I_tau)
    I_syn = I_S5 ln^2(1 + sqrt(E)),  E = e^(kappa_p (depth / U_T - t_5)),  depth = v_dd - v_syn

Out of weak inversion v = I_1 / I_2 is not u: above v_thr it is less, and more of a large current reaches the
capacitor. The pair's table is that of the mean of its synapses' currents, weighted with their charge.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from chips.rolls.layout import (
    COARSE,
    COARSE_POINTS,
    FINE,
    LOW,
    SINCE,
    SPLIT,
    TAKEN,
    FilterBank,
    Z,
)
from chips.rolls.lumped.grid import integral
from chips.rolls.lumped.network import pair as pair_shares
from chips.rolls.lumped.whole_filter import (
    WholeFilter,
    curves_of,
    own_of,
    slopes,
    whole_line_voltage,
    whole_of,
)
from circuits.arrays import F64
from circuits.catalogue import later
from circuits.devices.ekv import argument
from circuits.lowering.on_die import DieDevices

special = later("scipy.special")

OMEGA_POINTS = np.concatenate((np.arange(LOW, SPLIT, 1.0 / FINE), SPLIT + COARSE * np.arange(COARSE_POINTS)))
_LOGARITHMS = np.arange(-40.0, 16.0, 1.0 / 128)  # of u
_SMALL = -12.0  # ln u; below, v is in proportion to u


class Filter(NamedTuple):
    """Filters of one kind on a die, arrays of float64[n]: what does not depend on the step of time."""

    tau: F64  # s
    unit: F64  # A s: charge that moves z by one
    start: F64  # ln u at depth 0
    scale: F64  # E at u = 1
    specific: F64  # A
    power: float  # kappa_p / kappa_n
    pair: F64  # I_S of the pair's first device, A
    fold: float  # V: depth that moves ln u by one
    line_charge: F64  # C_line U_T, C
    follow: float  # kappa_n C_line / C, the mean's
    held_at: float  # V, where md1 would hold the line with I_S, on the mean of the filters
    whole: WholeFilter | None = None  # their mean, under the law with second-order effects


def filter_of(d: DieDevices, capacitance: float, line: float, *, inhibitory: bool) -> Filter:
    """Return the filters with devices `d`; capacitance, line: at v_syn and at the line, F.

    inhibitory: whether their output passes a mirror.
    """
    more_syn, more_line = d.added("c_syn"), d.added("c_line")
    syn, at_line = (np.broadcast_to(c, d.copies) for c in (capacitance + more_syn, line + more_line))
    mean = capacitance + float(np.mean(more_syn)), line + float(np.mean(more_line))
    if d.full:
        return _whole_filter_of(d, syn, at_line, mean, inhibitory=inhibitory)
    u_t = d.u_t
    md1, md2, md5 = d.fet["md1"], d.fet["md2"], d.fet["md5"]
    leak = d.saturated("md3", d.below("v_tau"))
    tau = syn * u_t / (md1.kappa * leak)
    start = np.log(md1.current / md2.current) + d.pinch("md1", d.gate["v_thr"]) - d.pinch("md2", d.v_dd)
    power = md5.kappa / md1.kappa
    specific = md5.current.copy()
    scale = np.exp(d.pinch("md5", 0.0) - power * start)
    if inhibitory:
        gain, bend = _mirror(d)
        scale *= bend * bend
        specific *= gain / (bend * bend)
    fold = u_t / md1.kappa
    unit = syn * fold
    return Filter(
        tau,
        unit,
        start,
        scale,
        specific,
        power,
        md1.current,
        fold,
        at_line * u_t,
        md1.kappa * mean[1] / mean[0],
        u_t * float(np.mean(d.pinch("md1", d.gate["v_thr"]))),
    )


def _whole_filter_of(
    d: DieDevices, syn: F64, line: F64, mean: tuple[float, float], *, inhibitory: bool
) -> Filter:
    """The same under the law with second-order effects; mean: of both capacitances, F."""
    own, (k_n, k_p) = own_of(d, inhibitory=inhibitory), slopes(d)
    fold, md1 = d.u_t / k_n, d.fet["md1"]
    unit = syn * fold
    return Filter(
        unit / own.leak, unit, own.start, own.scale, own.specific, k_p / k_n, md1.current, fold,
        line * d.u_t, k_n * mean[1] / mean[0], d.u_t * float(np.mean(d.pinch("md1", d.gate["v_thr"]))),
        whole_of(d, own, mean[1] / mean[0], inhibitory=inhibitory),
    )  # fmt: skip


def _mirror(d: DieDevices) -> tuple[F64, F64]:
    """md7's current over md6's in weak inversion, and the s with which it is as `ln^2(1 + s e) / s^2`.

    `I_7 = I_S7 ln^2(1 + g ((1 + e)^r - 1))`, e = sqrt(E) of md5, r = sqrt(I_S5 / I_S6) and g = e^(kappa (V_T6
    - V_T7) / (2 U_T)); s = 1 + r (g - 1) has the same first two terms in e.
    """
    mirror = d.mirror("md6", "md7")
    gate = np.exp(mirror.shift)
    return mirror.weak, 1.0 + np.sqrt(d.fet["md5"].current / d.fet["md6"].current) * (gate - 1.0)


def line_voltage(f: Filter, current: float, u_t: float) -> float:
    """Return where a filter's line stands while `current` (A) passes through md1, V: `U_T (p_thr - u_f)`."""
    if f.whole is not None:
        return whole_line_voltage(f.whole, current)
    return float(f.held_at - u_t * argument(current / float(f.pair.mean())))


class Load(NamedTuple):
    """What hangs on the filters' lines: mean current in a pulse and idle leak, A, float64[n] each."""

    drawn: F64
    idle: F64


def bank_of(f: Filter, load: Load, shape: Shape, step: float) -> FilterBank:
    """Return the filters for steps of `step` s."""
    decay, idle = step / f.tau, load.idle * step / f.unit
    line = f.line_charge / f.unit
    # of the output over a step, which falls with power / tau, and slower while the line follows v_syn
    fall = f.power * decay / (1.0 + f.follow)
    late = (np.euler_gamma + np.log(fall) + special.exp1(fall)) / -np.expm1(-fall)
    return FilterBank(
        -np.expm1(-decay),
        decay,
        shape.brought_at(_resting(f, load, shape)),
        shape.empty.astype(np.float32),
        idle.astype(np.float32),
        (line * step).astype(np.float32),
        (line * np.log1p(step * load.drawn / f.line_charge)).astype(np.float32),
        (line * late).astype(np.float32),
        f.scale.astype(np.float32),
        (1.0 + np.expm1(-fall) / fall).astype(np.float32),
        f.specific.astype(np.float32),
    )


def _resting(f: Filter, load: Load, shape: Shape) -> F64:
    """The ln u, float64[n], at which `C U_T / (kappa_n tau) (1 + v) (1 - r)` is what idle synapses bring."""
    needed = load.idle * f.tau / f.unit
    # the leak rises with u: halved until nothing is left, as `bisect` does
    low, high = np.zeros(f.tau.size, np.int64), np.full(f.tau.size, _LOGARITHMS.size)
    while (low < high).any():
        middle = np.minimum((low + high) // 2, _LOGARITHMS.size - 1)
        above = np.maximum(_LOGARITHMS[middle] - f.start, 0.0)
        enough = (1.0 + shape.ratio[middle]) * -np.expm1(-1.5 * f.power * above) >= needed
        low, high = np.where(enough, low, middle + 1), np.where(enough, middle, high)
    at = np.where(low < _LOGARITHMS.size, low, 0)
    return np.asarray(np.maximum(_LOGARITHMS[at], f.start))


def settled(f: Filter, load: Load, step: float) -> tuple[F64, F64]:
    """Return what a line has taken after a long time without a pulse, in z, and that time, s."""
    since = np.maximum(f.line_charge / np.maximum(load.idle, 1e-30), step)
    return f.line_charge / f.unit * np.log1p(since * load.drawn / f.line_charge), since


class Shape(NamedTuple):
    """Charge of a filter's pair over u, the ratio that its currents would have in weak inversion.

    omega: values and slopes over z, float64[points, 4]; brought, ratio: z and v over ln u from -40 to 16;
    empty: u^power of each filter at v_dd, float64[n].
    """

    omega: F64
    brought: F64
    ratio: F64
    empty: F64

    def log_of(self, z: F64) -> F64:
        """Return the logarithm of u at z."""
        return np.asarray(np.interp(z, self.brought, _LOGARITHMS))

    def brought_at(self, log: F64) -> F64:
        """Return z at the logarithm of u."""
        return np.asarray(np.interp(log, _LOGARITHMS, self.brought))


def shape_of(f: Filter, load: Load) -> Shape:
    """Return the table of v = I_1 / I_2 and of u^power over `z = int (1 + v + c / (1 + v)) d ln u`.

    v is that of two transistors alike, by the law, which carry the mean of what the synapses draw. c =
    kappa_n C_line / C: while v is below 1 the line follows v_syn, and its charge is drawn too.
    """
    if f.whole is not None:
        return _whole_shape_of(f, f.whole, float(load.drawn.mean()))
    inversion = np.full(_LOGARITHMS.size, float(np.mean(load.drawn / f.pair)))
    second, zero = np.empty(_LOGARITHMS.size), np.zeros(_LOGARITHMS.size)
    one = np.ones(_LOGARITHMS.size)
    pair_shares(one, _LOGARITHMS.copy(), one, zero, inversion, second)
    v = inversion / second - 1.0
    # below, where the difference cancels, both are in proportion
    k = int(np.argmax(_LOGARITHMS > _SMALL))
    v[:k] = v[k] * np.exp(_LOGARITHMS[:k] - _LOGARITHMS[k])
    density = 1.0 + v + f.follow / (1.0 + v)
    brought = integral(_LOGARITHMS[None], density[None])[0] + (1.0 + f.follow) * _LOGARITHMS[0]
    log = np.interp(OMEGA_POINTS, brought, _LOGARITHMS)
    table = np.zeros((OMEGA_POINTS.size, 4))
    table[:, 0] = np.exp(np.interp(log, _LOGARITHMS, np.log(v)))
    table[:, 2] = np.exp(f.power * log)
    table[:-1, 1], table[:-1, 3] = np.diff(table[:, 0]), np.diff(table[:, 2])
    return Shape(table, brought, v, np.exp(f.power * f.start))


def _whole_shape_of(f: Filter, whole: WholeFilter, drawn: float) -> Shape:
    """The same under the law with second-order effects: E of the mean filter in the place of u^power."""
    curves = curves_of(whole, drawn, _LOGARITHMS)
    brought = integral(_LOGARITHMS[None], curves.density[None])[0] + (1.0 + f.follow) * _LOGARITHMS[0]
    log = np.interp(OMEGA_POINTS, brought, _LOGARITHMS)
    table, output = np.zeros((OMEGA_POINTS.size, 4)), np.log(curves.output)
    table[:, 0] = np.interp(log, _LOGARITHMS, curves.ratio)
    table[:, 2] = np.exp(np.interp(log, _LOGARITHMS, output))
    table[:-1, 1], table[:-1, 3] = np.diff(table[:, 0]), np.diff(table[:, 2])
    return Shape(table, brought, curves.ratio, np.exp(np.interp(f.start, _LOGARITHMS, output)))


class Filtered(Protocol):
    """Tables of several kinds of filters, in the order of the rows of a state."""

    @property
    def filters(self) -> Sequence[Filter]:
        """Filters of each kind."""

    @property
    def loads(self) -> Sequence[Load]:
        """What hangs on the lines of each kind."""

    @property
    def shapes(self) -> Sequence[Shape]:
        """Charge of the pairs of each kind, over their ratio."""


def rest_filters(rows: F64, built: Filtered, banks: Sequence[FilterBank], step: float) -> None:
    """Fill rows of a state, float64[rows, n], with filters that have had no pulse for long.

    banks: of the same filters, for steps of `step` s.
    """
    for k, bank in enumerate(banks):
        rows[Z + k] = bank.rest
        rows[TAKEN + k], rows[SINCE + k] = settled(built.filters[k], built.loads[k], step)


def move_filters(rows: F64, old: Filtered, new: Filtered) -> None:
    """Take filters of a state, float64[rows, n], to the tables of another temperature.

    Their voltages stay.
    """
    for k, (f, g) in enumerate(zip(old.filters, new.filters, strict=True)):
        depth = f.fold * (old.shapes[k].log_of(rows[Z + k]) - f.start)
        rows[Z + k] = new.shapes[k].brought_at(g.start + depth / g.fold)
