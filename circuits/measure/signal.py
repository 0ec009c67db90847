"""A waveform between the points of a run, as the solver itself sees it there.

Between two points it is the parabola through them and the point before, by which the solver locates spikes
(`circuits.solver.integrate`), and a straight line where a stimulus bends: with s from a point on, and h to
the next,

    y(s) = y_0 + s (slope + (s - h) bend),    slope = (y_1 - y_0) / h

So crossings, extremes and integrals are exact in one and the same waveform. The curves of a sweep, whose
points no tolerance has placed, are straight lines everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from circuits.arrays import F64, I64, Bools

Direction = Literal["rise", "fall", "either"]

NODES = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)])
"""Of Gauss and Legendre, exact to degree 5 over a step of length 1."""
WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0
"""Weights of these nodes."""


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """A waveform: points that rise along an axis, and whether it bends at each.

    Attributes
    ----------
    axis : float64[T], time (s) or what else the run goes along.
    value : float64[T], complex128[T] for a transfer.
    kink : bool[T], where the waveform has no parabola behind the point.
    """

    axis: F64
    value: F64
    kink: Bools

    def with_value(self, value: F64) -> Signal:
        """The same points with other values."""
        return replace(self, value=value)

    @property
    def ends(self) -> tuple[float, float]:
        """First and last point of the axis."""
        return float(self.axis[0]), float(self.axis[-1])


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """The parabolas of a signal between its points: y = start + s (slope + (s - step) bend)."""

    step: F64
    start: F64
    slope: F64
    bend: F64

    def at(self, k: I64 | int, s: F64 | float) -> F64:
        """Values at the distances s from the points k."""
        inner = self.slope[k] + (s - self.step[k]) * self.bend[k]
        return np.asarray(self.start[k] + s * inner)


def value_at(signal: Signal, place: float) -> float:
    """Value at a place of the axis, which must lie within it."""
    return _value(signal, _pieces(signal), place)


def slope_at(signal: Signal, place: float) -> float:
    """Derivative along the axis at a place within it; of a single point 0."""
    k, p = _piece_of(signal, place), _pieces(signal)
    return 0.0 if k < 0 else float(p.slope[k] + (2.0 * (place - signal.axis[k]) - p.step[k]) * p.bend[k])


def crossings(signal: Signal, level: float, direction: Direction, low: float, high: float) -> F64:
    """Places in [low, high] at which a signal passes a level, float64[n], in their order.

    A rise comes from below the level and reaches it; a fall comes from above and reaches it.
    """
    before, after = signal.value[:-1] - level, signal.value[1:] - level
    rises, falls = (before < 0.0) & (after >= 0.0), (before > 0.0) & (after <= 0.0)
    chosen = {"rise": rises, "fall": falls, "either": rises | falls}[direction]
    k = np.flatnonzero(chosen)
    p = _pieces(signal)
    places = signal.axis[k] + _root(before[k], p.slope[k] - p.step[k] * p.bend[k], p.bend[k], p.step[k])
    return np.asarray(places[(places >= low) & (places <= high)])


def extreme(signal: Signal, low: float, high: float, sign: float) -> tuple[float, float]:
    """Place and value of the largest (`sign` 1) or smallest (-1) value in [low, high]; the first of several.

    The vertices of the parabolas count, not the points alone.
    """
    p = _pieces(signal)
    with np.errstate(divide="ignore", invalid="ignore"):
        within = 0.5 * (p.step - p.slope / p.bend)
    k = np.flatnonzero((p.bend != 0.0) & (within > 0.0) & (within < p.step))
    places = np.concatenate([signal.axis, signal.axis[k] + within[k]])
    values = np.concatenate([signal.value, p.at(k, within[k])])
    inside = (places >= low) & (places <= high)
    places = np.concatenate([places[inside], [low, high]])
    values = np.concatenate([values[inside], [_value(signal, p, low), _value(signal, p, high)]])
    best = int(np.argmax(sign * values))
    alike = places[values == values[best]]
    return float(alike.min(initial=places[best])), float(values[best])


def integral(signal: Signal, low: float, high: float, power: int = 1) -> float:
    """Integral of a signal, or of its square (`power` 2), over [low, high], which lies within its axis."""
    inside = signal.axis[(signal.axis > low) & (signal.axis < high)]
    edges = np.concatenate([[low], inside, [high]])
    step = np.diff(edges)
    if signal.axis.size < 2:
        return 0.0
    k = np.clip(np.searchsorted(signal.axis, edges[:-1], side="right") - 1, 0, signal.axis.size - 2)
    p, first = _pieces(signal), edges[:-1] - signal.axis[k]
    total = np.zeros(step.size)
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        total += weight * p.at(k, first + node * step) ** power
    return float((total * step).sum())


def _pieces(signal: Signal) -> _Pieces:
    step = np.diff(signal.axis)
    safe = np.where(step > 0.0, step, 1.0)
    slope = np.where(step > 0.0, np.diff(signal.value) / safe, 0.0)
    bend = np.zeros_like(slope)
    bend[1:] = np.where(signal.kink[1:-1], 0.0, np.diff(slope) / (safe[1:] + safe[:-1]))
    return _Pieces(step, signal.value[:-1], slope, bend)


def _value(signal: Signal, pieces: _Pieces, place: float) -> float:
    k = _piece_of(signal, place)
    return float(signal.value[0]) if k < 0 else float(pieces.at(k, place - signal.axis[k]))


def _piece_of(signal: Signal, place: float) -> int:
    """Number of the piece at a place; -1 for a signal of a single point."""
    k = int(np.searchsorted(signal.axis, place, side="right")) - 1
    return min(max(k, 0), signal.axis.size - 2) if signal.axis.size > 1 else -1


def _root(c: F64, b: F64, a: F64, step: F64) -> F64:
    """The root of `a s^2 + b s + c` in [0, step], where its sign changes."""
    with np.errstate(divide="ignore", invalid="ignore"):
        q = -0.5 * (b + np.copysign(np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0)), b))
        pair = np.stack([q / a, c / q])
    middle = 0.5 * step
    distance = np.where(np.isfinite(pair), np.abs(pair - middle), np.inf)
    chosen = np.take_along_axis(pair, distance.argmin(axis=0)[None], axis=0)[0]
    return np.asarray(np.clip(chosen, 0.0, step))
