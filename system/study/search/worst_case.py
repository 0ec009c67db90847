"""Worst-case distance and point of a specification: its most probable failing die, found by gradient.

Draws z of a die are standard normals, so of all dies that fail the one nearest to the nominal die is the most
probable, and its distance beta = |z| tells the yield without a sample: a half-space at that distance has the
probability Phi(-beta). It is found by the iteration of Hasofer and Lind (1974) and of Rackwitz and Fiessler
(1978), which goes to where the linear theory about the last die has the limit,

    z <- g (g z - G) / g^2,     G = margin to the limit, g = its gradient,

with steps that are halved until the merit of Zhang and Der Kiureghian (1995), |z|^2 / 2 + c |G|, falls. A
nominal die that fails has a distance below 0, that of the nearest die that passes.

Source of the name: Antreich, Graeb and Wieser, "Circuit analysis and optimization driven by worst-case
distances" (1994).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, Bools
from circuits.catalogue import later
from circuits.errors import SolverError
from system.study.search.slope import Slope, Slopes
from system.study.specification import Limits
from system.study.statistics.mean_shift import about
from system.study.statistics.rare import RareFailure

special = later("scipy.special")

FAR = 8.0  # sigma, beyond which a limit is met by every die, or by none; ours
_STEPS, _HALVINGS = 25, 5
_NEAR = 0.01  # sigma, of the limit and of the last step's length over beta, at which the search ends; ours
_COUNTS = 1e-3  # of the likeliest limit's failures, below which no die is drawn about a worst case; ours
_BEYOND = 0.01  # of the distance, by which the failing die lies beyond the limit; ours


@dataclass(frozen=True, slots=True, eq=False)
class WorstCase:
    """The worst case of one limit of a specification.

    metric : metric that is limited.
    limit : the limit, in SI units.
    side : `below` where lower values fail, `above` where higher ones do.
    distance : worst-case distance, sigma; below 0 where the nominal die fails.
    point : draws of the die just beyond the limit, float64[labels].
    value : the metric as it was measured on that die, in SI units.
    verified : whether that die fails, and one as far on this side of the limit passes, as measured.
    """

    metric: str
    limit: float
    side: str
    distance: float
    point: F64
    value: float
    verified: bool

    @property
    def failing(self) -> float:
        """Probability that a die fails at this limit, in the linear theory about the worst point."""
        return float(special.ndtr(-self.distance))


@dataclass(frozen=True, slots=True, eq=False)
class _Margin:
    """Margin of a metric to a limit: above 0 where a die passes."""

    slopes: Slopes
    limit: float
    sign: float  # 1 where higher values fail

    def at(self, z: F64) -> Slope:
        found = self.slopes.at(z)
        return Slope(self.sign * (self.limit - found.value), -self.sign * found.by, found.note)

    def on(self, rows: F64) -> F64:
        return self.sign * (self.limit - self.slopes.values(rows))


def worst_cases(slopes: Slopes, limits: Limits) -> tuple[WorstCase, ...]:
    """Find the worst case of each limit of a specification, but of one that no die within `FAR` sigma fails.

    Parameters
    ----------
    slopes
        The metric with its gradient.
    limits
        Its limits.

    Raises
    ------
    SolverError
        The metric is not defined on the nominal die or where the search leads, every die meets all limits as
        far as `FAR` sigma, or none meets one, or the search does not settle.
    """
    found, met = [], []
    for limit, sign in _sides(limits):
        try:
            found.append(_worst_case(slopes, limits, limit, sign))
        except _AlwaysMetError as always:
            met.append(always)
    if met and not found:
        raise met[0]
    return tuple(found)


def beyond(limits: Limits, cases: Sequence[WorstCase]) -> tuple[str, ...]:
    """Sides of the limits that no die within `FAR` sigma fails: those without a worst case."""
    sides = ("above" if sign > 0.0 else "below" for _, sign in _sides(limits))
    return tuple(side for side in sides if side not in {case.side for case in cases})


class _AlwaysMetError(SolverError):
    """No die as far as `FAR` sigma fails at a limit."""


def _sides(limits: Limits) -> Iterator[tuple[float, float]]:
    for limit, sign in ((limits.low, -1.0), (limits.high, 1.0)):
        if math.isfinite(limit):
            yield limit, sign


def _worst_case(slopes: Slopes, limits: Limits, limit: float, sign: float) -> WorstCase:
    margin = _Margin(slopes, limit, sign)
    begun = margin.at(np.zeros(len(slopes.labels)))
    if not math.isfinite(begun.value):
        raise SolverError(f"spec: {limits}, {limits.metric} is not defined on the nominal die; {begun.note}")
    z = _nearest(margin, begun, limits)
    distance = math.copysign(float(np.linalg.norm(z)), begun.value)
    reach = math.copysign(_BEYOND, distance)
    point = (1.0 + reach) * z
    beyond, within = margin.on(np.array([point, (1.0 - reach) * z]))
    value = limit - sign * float(beyond)
    side = "above" if sign > 0.0 else "below"
    verified = bool(beyond < 0.0 < within)
    return WorstCase(limits.metric, limit, side, distance, point, value, verified)


def _nearest(margin: _Margin, begun: Slope, limits: Limits) -> F64:
    """The die nearest to the nominal one at which the margin is 0."""
    z, here = np.zeros(len(begun.by)), begun
    for _ in range(_STEPS):
        slope = _checked(here, limits)
        aim = here.by * ((here.by @ z - here.value) / slope**2)
        length = float(np.linalg.norm(aim))
        step = float(np.linalg.norm(aim - z))
        if abs(here.value) < _NEAR * slope and step < _NEAR * max(length, 1.0):
            return z
        if float(np.linalg.norm(z)) >= FAR - _NEAR and length >= FAR:
            _refuse_far(begun, limits)
        aim *= min(1.0, FAR / length)
        z, here = _stepped(margin, z, aim, here, slope)
    raise SolverError(
        f"spec: {limits}, the search for the worst die does not settle, at {np.linalg.norm(z):.2f} sigma;"
        " sample plainly"
    )


def _checked(here: Slope, limits: Limits) -> float:
    """Length of the gradient."""
    if not np.isfinite(here.by).all():
        raise SolverError(f"spec: {limits}, {limits.metric} has no gradient; {here.note or 'sample plainly'}")
    slope = float(np.linalg.norm(here.by))
    if slope == 0.0:
        raise SolverError(f"spec: {limits}, nothing that varies moves {limits.metric}; leave it out")
    return slope


def _refuse_far(begun: Slope, limits: Limits) -> None:
    refusal, who = (
        (_AlwaysMetError, "every die meets it") if begun.value > 0.0 else (SolverError, "no die meets it")
    )
    raise refusal(f"spec: {limits}, {who}, as far as {FAR:g} sigma; give another limit")


def _stepped(margin: _Margin, z: F64, aim: F64, here: Slope, slope: float) -> tuple[F64, Slope]:
    """A step towards `aim`, halved until the merit falls and the metric is defined."""
    c = 2.0 * max(float(np.linalg.norm(aim)), 1.0) / slope
    merit = 0.5 * float(z @ z) + c * abs(here.value)
    tried, found = aim, margin.at(aim)
    for _ in range(_HALVINGS):
        if math.isfinite(found.value) and 0.5 * float(tried @ tried) + c * abs(found.value) < merit:
            break
        tried = 0.5 * (z + tried)
        found = margin.at(tried)
    if not math.isfinite(found.value):
        raise SolverError(
            f"{margin.slopes.metric}: is not defined at {np.linalg.norm(tried):.2f} sigma, where the search"
            f" for the worst die leads; {found.note or 'sample plainly'}"
        )
    return tried, found


def failure_of(cases: Sequence[WorstCase]) -> float:
    """Probability that a die fails at any of some limits: the sum of theirs, at most 1."""
    return min(1.0, sum(case.failing for case in cases))


def checked_there(
    slopes: Slopes, limits: Limits, cases: Sequence[WorstCase], samples: int, seed: int
) -> RareFailure:
    """Estimate the same probability by dies drawn about the worst points: importance sampling.

    Parameters
    ----------
    slopes
        The metric.
    limits
        Its limits.
    cases
        Worst cases of these.
    samples
        Number of dies.
    seed
        Key of their draws.

    Raises
    ------
    SolverError
        The nominal die fails, so that failures are not rare, or too few of the dies fail.
    """
    if any(case.distance <= 0.0 for case in cases):
        raise SolverError(f"spec: {limits}, the nominal die fails, so failures are not rare; sample plainly")

    def fails(rows: F64) -> Bools:
        values = slopes.values(rows)
        return np.asarray(~((values >= limits.low) & (values <= limits.high)))

    rng, most = np.random.Generator(np.random.Philox(key=seed)), max(case.failing for case in cases)
    points = [case.point for case in cases if case.failing >= _COUNTS * most]
    return about(fails, np.array(points), samples, rng)
