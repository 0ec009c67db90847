"""Mean-shift importance sampling: the probability of a rare failure from dies near the likeliest ones.

Dies are drawn about the failing dies that are least unlikely.

First stage, a fifth of the samples: sigmas scaled up until about one die in ten fails. Failing dies are
parted into regions: two where, of the dies half as far again as the boundary in the directions of their
means, the one halfway passes (a flat boundary has none). The direction of a region is the normal of its
boundary, fitted to all stages as a ridge regression of failing on z with the slope that a flat boundary has
at a stage's scale s and frequency p of failures, `f = exp(-x^2 / 2) / (sqrt(2 pi) s)`, p the chance of a
normal above x. The shift mu_k reaches to the boundary along it. Second stage, as many: dies about each
shift, of which regions and normals are found again.
Third stage: from the mixture q = alpha_0 N(0, 1) + sum alpha_k N(mu_k, 1), in fixed parts, with

    P = mean over samples of [fails] w,   w = phi / q = 1 / (alpha_0 + sum alpha_k exp(mu_k z - |mu_k|^2 / 2))

The nominal part bounds every weight by 1 / alpha_0. The effective sample size, (sum w)^2 / sum w^2 over the
failing samples, must reach 50. A region that no stage met is seen by the nominal part only. Where two
regions meet at an angle and many normals vary, the parting may fail; the effective sample size then tells,
and judging each specification by itself helps.
Sources: Kanj, Joshi, Nassif, "Mixture importance sampling and its application to the analysis of SRAM
designs in the presence of rare failure events", DAC (2006); Veach and Guibas, "Optimally combining sampling
techniques for Monte Carlo rendering" (1995), for the fixed parts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, Bools
from circuits.catalogue import later
from circuits.errors import ParameterError, SolverError
from system.study.statistics.interval import LEVEL, Interval
from system.study.statistics.rare import Fails, RareFailure, check_budget

vq, special = later("scipy.cluster.vq"), later("scipy.special")

LEAST_EFFECTIVE = 50.0
NOMINAL_PART = 0.1
_FEWEST = 500
_LEFT = 100  # samples of the third stage at least: about a shift to the boundary half of them fail
_STAGE = 0.2  # part of the samples, of the first and of the second stage
_SCALES = (1.5, 2.0, 2.5, 3.0, 4.0)
_PILOT = 0.1  # part of the first stage at each scale that is tried
_SMALLEST_PILOT = 50
_OFTEN = 0.08  # part of a pilot that should fail
_FEWEST_FAILURES = 10  # of a region
_DEPTH = 2  # of parting: four regions at most
_BEYOND = 1.5  # times the radius of the boundary, where regions are told apart
_RADII = 24  # dies along a direction, tried at once


@dataclass(frozen=True, slots=True, eq=False)
class _Stage:
    """Rows float64[n, d] drawn about `centre` with the scale `sigma`, and which fail."""

    rows: F64
    failed: Bools
    sigma: float


def mean_shift(
    fails: Fails, dimensions: int, samples: int, rng: np.random.Generator, level: float = LEVEL
) -> RareFailure:
    """Estimate the probability of a rare failure from dies drawn near the likeliest failures.

    Parameters
    ----------
    fails : tells which rows of float64[n, dimensions] standard normals fail, bool[n].
    dimensions : number of standard normals behind a die.
    samples : number of dies in all, those of the first stages included.
    rng : generator of the standard normals.
    level : confidence level of the interval, which is a normal one of ln P.

    Raises
    ------
    ParameterError
        There are too few samples, or the nominal die fails, so that failures are not rare.
    SolverError
        No failure was found, the search left too few samples, or the effective sample size is below 50.
    """
    check_budget(dimensions, samples, _FEWEST)
    counter = _Counter(fails)
    if counter(np.zeros((1, dimensions)))[0]:
        raise ParameterError("mean-shift: the nominal die fails, so failures are not rare; sample plainly")
    first = _explore(counter, dimensions, int(_STAGE * samples), rng)
    starts = _shifts(counter, [first], _regions(counter, first.rows[first.failed], _DEPTH))
    second = []
    for start in starts:
        rows = start + rng.standard_normal((int(_STAGE * samples) // len(starts), dimensions))
        second.append(_Stage(rows, counter(rows), 1.0))
    failing = np.vstack([stage.rows[stage.failed] for stage in second])
    shifts = (
        _shifts(counter, [first, *second], _regions(counter, failing, _DEPTH)) if len(failing) else starts
    )
    left = samples - counter.count
    if left < _LEFT:
        raise SolverError(
            f"mean-shift: the search for failing dies took {counter.count} of {samples} samples, must leave"
            f" {_LEFT} for the estimate; take more samples"
        )
    return _estimate(counter, shifts, left, rng, level)


def about(
    fails: Fails, shifts: F64, samples: int, rng: np.random.Generator, level: float = LEVEL
) -> RareFailure:
    """Estimate the probability of a rare failure from dies drawn about failing dies that are known.

    Parameters
    ----------
    fails, rng, level : as `mean_shift` has them.
    shifts : the failing dies, float64[regions, dimensions], one of each region of failure.
    samples : number of dies in all.

    Raises
    ------
    ParameterError
        There are too few samples.
    SolverError
        The effective sample size is below 50.
    """
    check_budget(shifts.shape[1], samples, int(LEAST_EFFECTIVE))
    return _estimate(_Counter(fails), shifts, samples, rng, level)


class _Counter:
    """A metric that counts the dies it is called with."""

    def __init__(self, fails: Fails) -> None:
        self.fails, self.count = fails, 0

    def __call__(self, rows: F64) -> Bools:
        self.count += len(rows)
        return np.asarray(self.fails(rows), dtype=np.bool_)


def _explore(fails: _Counter, dimensions: int, samples: int, rng: np.random.Generator) -> _Stage:
    """First stage: the smallest scale at which failures are frequent enough, or the largest."""
    pilot = max(_SMALLEST_PILOT, int(_PILOT * samples))
    stage = _draw(fails, pilot, dimensions, _SCALES[0], rng)
    for sigma, larger in zip(_SCALES, (*_SCALES[1:], None), strict=True):
        if stage.failed.mean() >= _OFTEN or larger is None:
            more = _draw(fails, max(pilot, samples - fails.count), dimensions, sigma, rng)
            stage = _Stage(np.vstack([stage.rows, more.rows]), np.append(stage.failed, more.failed), sigma)
            if stage.failed.sum() >= _FEWEST_FAILURES:
                return stage
        if larger is not None:
            stage = _draw(fails, pilot, dimensions, larger, rng)
    raise SolverError(
        f"mean-shift: {stage.failed.sum()} failures of {len(stage.rows)} dies at {stage.sigma:g} sigma, "
        f"must be >= {_FEWEST_FAILURES}; take more samples"
    )


def _draw(fails: _Counter, samples: int, dimensions: int, sigma: float, rng: np.random.Generator) -> _Stage:
    rows = sigma * rng.standard_normal((samples, dimensions))
    return _Stage(rows, fails(rows), sigma)


def _regions(fails: _Counter, failing: F64, depth: int) -> list[F64]:
    """Mean of the failing rows of each region."""
    mean = failing.mean(axis=0)
    if depth == 0 or len(failing) < 2 * _FEWEST_FAILURES:
        return [mean]
    along = np.linalg.svd(failing - mean, full_matrices=False)[2][0]
    side = (failing - mean) @ along > 0.0
    if side.all() or not side.any():
        return [mean]
    start = np.array([failing[side].mean(axis=0), failing[~side].mean(axis=0)])
    centres, label = vq.kmeans2(failing, start, minit="matrix")
    parts = [failing[label == k] for k in (0, 1)]
    if min(map(len, parts)) < _FEWEST_FAILURES or not _apart(fails, centres):
        return [mean]
    return [m for part in parts for m in _regions(fails, part, depth - 1)]


def _apart(fails: _Counter, centres: F64) -> bool:
    """Whether the die between two, beyond the boundary in the directions of the centres, passes."""
    ends = []
    for centre in centres:
        norm = float(np.linalg.norm(centre))
        radius = _boundary(fails, centre / norm, 2.0 * norm)
        if math.isinf(radius):
            return False
        ends.append(_BEYOND * radius / norm * centre)
    return not fails(np.mean(ends, axis=0)[None])[0]


def _labelled(stage: _Stage, regions: list[F64], k: int) -> _Stage:
    """The stage with only region k failing: other failing rows are left out."""
    distance = np.array([((stage.rows - mean) ** 2).sum(axis=1) for mean in regions])
    mine = distance.argmin(axis=0) == k
    keep = mine | ~stage.failed
    return _Stage(stage.rows[keep], (stage.failed & mine)[keep], stage.sigma)


def _shifts(fails: _Counter, stages: list[_Stage], regions: list[F64]) -> F64:
    """Shift of each region, float64[regions, d]."""
    return np.array(
        [
            _shift(fails, [_labelled(stage, regions, k) for stage in stages], mean)
            for k, mean in enumerate(regions)
        ]
    )


def _shift(fails: _Counter, stages: list[_Stage], fallback: F64) -> F64:
    """Boundary of failure along the normal that the stages tell, else along the fallback."""
    for direction in (_normal(stages), fallback):
        length = float(np.linalg.norm(direction))
        unit = direction / length if length > 0.0 else direction
        radius = _boundary(fails, unit, 2.0 * float(np.linalg.norm(fallback)))
        if math.isfinite(radius):
            return radius * unit
    return fallback


def _normal(stages: list[_Stage]) -> F64:
    """Normal of the boundary, float64[d]: ridge regression, each stage about its own mean."""
    d = stages[0].rows.shape[1]
    gram, slope = d * np.eye(d), np.zeros(d)  # the normal has norm 1, so a component the variance 1 / d
    for stage in stages:
        rows, p = stage.rows - stage.rows.mean(axis=0), float(stage.failed.mean())
        if 0.0 < p < 1.0:
            f = math.exp(-0.5 * float(special.ndtri(p)) ** 2) / (math.sqrt(2.0 * math.pi) * stage.sigma)
            gram += f * f / (p * (1.0 - p)) * (rows.T @ rows)
            slope += f / (p * (1.0 - p)) * (rows.T @ (stage.failed - p))
    return np.asarray(np.linalg.solve(gram, slope))


def _boundary(fails: _Counter, unit: F64, reach: float) -> float:
    """Smallest radius up to `reach` at which the direction fails, to a part in 500; infinite if none does."""
    low, high = 0.0, reach
    for _ in range(2):
        radii = np.linspace(low, high, _RADII + 1)[1:]
        failing = np.flatnonzero(fails(radii[:, None] * unit))
        if not failing.size:
            return math.inf
        step, high = radii[1] - radii[0], float(radii[failing[0]])
        low = high - float(step)
    return high


def _estimate(
    fails: _Counter, shifts: F64, samples: int, rng: np.random.Generator, level: float
) -> RareFailure:
    """Third stage."""
    counts = np.full(len(shifts) + 1, int((1.0 - NOMINAL_PART) * samples) // len(shifts))
    counts[0] = samples - counts[1:].sum()
    centres = np.vstack([np.zeros(shifts.shape[1]), shifts])
    rows = np.repeat(centres, counts, axis=0) + rng.standard_normal((samples, shifts.shape[1]))
    exponent = rows @ centres.T - 0.5 * (centres * centres).sum(axis=1)
    failed = fails(rows)
    weight = np.where(failed, np.exp(-special.logsumexp(exponent, axis=1, b=counts / samples)), 0.0)
    total, square = float(weight.sum()), float((weight * weight).sum())
    effective = total * total / square if square > 0.0 else 0.0
    norms = ", ".join(f"{each:.2f}" for each in np.linalg.norm(shifts, axis=1))
    if effective < LEAST_EFFECTIVE:
        raise SolverError(
            f"mean-shift: effective sample size {effective:.0f} of {failed.sum()} failures about shifts of "
            f"{norms} sigma, must be >= {LEAST_EFFECTIVE:g}; take more samples, or scaled-sigma"
        )
    value = total / samples
    error = float(weight.std(ddof=1)) / math.sqrt(samples) / value
    factor = math.exp(-float(special.ndtri(0.5 * (1.0 - level))) * error)
    detail = f"{len(shifts)} region{'s' * (len(shifts) > 1)}, shifted by {norms} sigma"
    interval = Interval(value / factor, min(1.0, value * factor))
    return RareFailure("mean-shift", value, interval, fails.count, effective, detail)
