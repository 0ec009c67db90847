"""Claims: 95 % intervals cover 93 to 97 %, auto-stop at least 93 %, and 1e-4 is found with 5,000 samples.

Intervals: 1,000 synthetic experiments a distribution (normal, lognormal of sigma 0.5, exponential) and
number of samples; how many hold the true mean or quantile. Sigma and skew are measured too, without a claim.
Yield: Clopper-Pearson's coverage is an exact binomial sum, the least over 2,001 true yields. The confidence
sequence is read where a rule stopped it: half-width below 0.02, or a required yield excluded that is close
to the true one; studies that never stop are read at their last sample. Its chance of ever excluding the true
yield, looked at after every sample, is measured too.
Rare failures: a metric of 68 standard normals, a direction with squares of both signs, whose tail is known
from its characteristic function; 5,000 samples for each of 20 seeds. Plain sampling of as many dies would
see half a failure.
A row's `ours` is what was measured, `peer` what is claimed or true, `ratio` ours over peer.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy import stats
from scipy.optimize import brentq

from _report import Row, parser_of, report
from circuits.arrays import F64, Bools
from circuits.errors import SolverError
from system.study.statistics import interval as limits
from system.study.statistics.confidence_sequence import (
    StopRule,
    first_stop,
    log_martingale,
    sequence_interval,
)
from system.study.statistics.mean_shift import mean_shift
from system.study.statistics.scaled_sigma import scaled_sigma

LEVEL, LOW, HIGH = 0.95, 0.93, 0.97
ENOUGH = 1000  # experiments, with fewer of which chance alone misses a claim
FACTOR = 1.5  # within which a rare failure's probability is found
QUANTILES = (0.05, 0.5, 0.95)
YIELDS = (0.5, 0.9, 0.99, 0.999)
DISTRIBUTIONS: dict[str, Any] = {
    "normal": stats.norm(2.0, 0.5),
    "lognormal 0.5": stats.lognorm(0.5),
    "exponential": stats.expon(),
}
DIMENSIONS, RARE, SAMPLES = 68, 1e-4, 5_000
SEEDS = range(1000, 1020)  # the methods were tuned on smaller ones


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "fewer experiments, resamples and samples").parse_args()
    quick: bool = options.quick
    rows = [
        *intervals(*((200, 399, (100, 200)) if quick else (1000, 999, (100, 200, 1000)))),
        *proportions(),
        *sequences(*((300, 1000) if quick else (1000, 4000))),
        *rare(),
    ]
    return report(rows, options, lambda row: f"{row.ours:9.4g}, claimed or true {row.peer:7.4g}")


def intervals(experiments: int, resamples: int, sizes: tuple[int, ...]) -> Iterator[Row]:
    """Coverage of mean, quantiles, sigma and skew."""
    for name, law in DISTRIBUTIONS.items():
        for n in sizes:
            rng = np.random.default_rng([n, len(name)])
            draws = law.rvs((experiments, n), random_state=rng)
            tried: dict[str, tuple[float, Callable[..., limits.Interval]]] = {
                "mean": (law.mean(), partial(limits.mean_interval, rng=rng, resamples=resamples)),
                **{
                    f"quantile {p:g}": (law.ppf(p), partial(limits.quantile_interval, p=p)) for p in QUANTILES
                },
            }
            if n < 1000:
                tried["sigma"] = (law.std(), partial(limits.sigma_interval, rng=rng, resamples=resamples))
                tried["skew"] = (
                    float(law.stats(moments="s")),
                    partial(limits.skew_interval, rng=rng, resamples=resamples),
                )
            for what, (truth, interval) in tried.items():
                found = float(np.mean([truth in interval(x) for x in draws]))
                error = np.sqrt(LEVEL * (1.0 - LEVEL) / experiments)
                claimed = what not in {"sigma", "skew"} and experiments >= ENOUGH
                ends = (LOW / LEVEL, HIGH / LEVEL) if claimed else (0.0, np.inf)
                note = f"standard error {error:.3f}"
                yield Row(f"coverage of {what}, {name}, n = {n}", found, LEVEL, found / LEVEL, note, 1, *ends)


def proportions() -> Iterator[Row]:
    """Least exact coverage of Clopper-Pearson's interval over true yields."""
    for n in (20, 100, 200, 1000):
        ends = [limits.clopper_pearson(k, n) for k in range(n + 1)]
        low, high = np.array([e.low for e in ends]), np.array([e.high for e in ends])
        least = min(
            float(stats.binom.pmf(np.flatnonzero((low <= p) & (p <= high)), n, p).sum())
            for p in np.linspace(0.0, 1.0, 2001)
        )
        name = f"least coverage of a yield, n = {n}"
        yield Row(name, least, LEVEL, least / LEVEL, "exact sum", least=1.0)


def sequences(experiments: int, longest: int) -> Iterator[Row]:
    """Coverage of the confidence sequence where it stopped, and at all times."""
    for true in YIELDS:
        passed = np.random.default_rng([4, round(1e6 * true)]).random((experiments, longest)) < true
        counts, samples = passed.cumsum(axis=1), np.arange(1, longest + 1)
        never = float((log_martingale(counts, samples, true) < -np.log(1.0 - LEVEL)).all(axis=1).mean())
        note = f"guaranteed 0.95; after each of {longest} samples"
        yield Row(f"sequence holds at all times, yield {true:g}", never, LEVEL, never / LEVEL, note)
        rule = StopRule(half_width=0.02, required=true - 0.3 * (1.0 - true))
        stops = [first_stop(each, rule) for each in passed]
        held = [
            true in (sequence_interval(int(each.sum()), longest) if stop is None else stop.interval)
            for each, stop in zip(passed, stops, strict=True)
        ]
        ended = [stop.samples for stop in stops if stop is not None]
        found = float(np.mean(held))
        note = f"{len(ended)} of {experiments} stopped, half by {np.median(ended):.0f}"
        name, claim = f"coverage where a rule stopped, yield {true:g}", LOW / LEVEL
        yield Row(name, found, LEVEL, found / LEVEL, note, least=claim if experiments >= ENOUGH else 0.0)


def rare() -> Iterator[Row]:
    """Estimates of a planted rare failure by both methods."""
    linear, square = planted()
    limit = float(brentq(lambda x: tail(linear, square, x) - RARE, 0.0, 20.0, xtol=1e-9))

    def fails(z: F64) -> Bools:
        return np.asarray(z @ linear + (z * z) @ square > limit)

    for name, method in (("mean-shift", mean_shift), ("scaled-sigma", scaled_sigma)):
        found, refused = [], 0
        for seed in SEEDS:
            try:
                found.append(method(fails, DIMENSIONS, SAMPLES, np.random.default_rng(seed)))
            except SolverError:
                refused += 1
        ratio = np.array([each.probability / RARE for each in found])
        within = int(((ratio < FACTOR) & (ratio > 1.0 / FACTOR)).sum())
        held = sum(RARE in each.interval for each in found)
        note = f"{within} of {len(SEEDS)} seeds within a factor {FACTOR:g}, {refused} refused, "
        note += f"{held} intervals hold 1e-4, estimates from {ratio.min():.2f} to {ratio.max():.2f} of it"
        if name == "mean-shift":
            note += f", effective samples at least {min(each.effective_samples for each in found):.0f}"
        median = float(np.median(ratio))
        title = f"{name}, 1e-4 in 68 dimensions, median"
        yield Row(title, median * RARE, RARE, median, note, 1, 1.0 / FACTOR, FACTOR)


def planted() -> tuple[F64, F64]:
    """Coefficients of the metric's line, of norm 1, and of its squares, up to 3 % of it."""
    rng = np.random.default_rng(68)
    linear = rng.standard_normal(DIMENSIONS) * np.exp(-0.05 * np.arange(DIMENSIONS))
    return linear / np.linalg.norm(linear), rng.uniform(-0.03, 0.03, DIMENSIONS)


def tail(linear: F64, square: F64, x: float) -> float:
    """P(sum a z + q z^2 > x), by Gil-Pelaez's inversion of the characteristic function."""
    step = 0.02
    t = step * (np.arange(1_000) + 0.5)
    factor = 1.0 - 2j * np.outer(t, square)
    logarithm = (-0.5 * np.log(factor) - 0.5 * np.outer(t**2, linear**2) / factor).sum(axis=1)
    return float(0.5 + step / np.pi * (np.exp(logarithm - 1j * t * x).imag / t).sum())


if __name__ == "__main__":
    sys.exit(main())
