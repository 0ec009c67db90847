"""Failures are split into what dies, worlds and noise cause."""

import numpy as np
import pytest
from scipy.special import ndtr

from circuits.arrays import Bools
from system.study.statistics.causes import causes_of

LIMIT = -0.8  # of a sum of normals of variance 1, below which a run fails


def failed(shares: tuple[float, float, float], shape: tuple[int, int, int], seed: int = 5) -> Bools:
    """Runs that fail where a sum of normals of die, world and noise is low; shares: of its variance."""
    rng = np.random.default_rng(seed)
    sizes = (shape[0], 1, 1), (*shape[:2], 1), shape
    parts = [np.sqrt(s) * rng.standard_normal(size) for s, size in zip(shares, sizes, strict=True)]
    return np.asarray(sum(parts) < LIMIT)


def of_failures(shares: tuple[float, float, float]) -> list[float]:
    """The same shares of the variance of failing, by integrating over what is alike."""
    z = np.random.default_rng(1).standard_normal(400_000)
    q = float(ndtr(LIMIT))
    known = np.cumsum(shares)[:2]
    spread = [float(ndtr((LIMIT - np.sqrt(k) * z) / np.sqrt(1.0 - k)).var()) / (q * (1 - q)) for k in known]
    return [spread[0], spread[1] - spread[0], 1.0 - spread[1]]


@pytest.mark.parametrize("shares", [(0.7, 0.1, 0.2), (0.2, 0.6, 0.2), (0.3, 0.3, 0.4)])
def test_causes_are_those_that_were_planted(shares: tuple[float, float, float]) -> None:
    found = causes_of(failed(shares, (3000, 3, 3)), np.random.default_rng(0))
    assert [each.name for each in found] == ["die", "world", "noise"]
    assert [each.share for each in found] == pytest.approx(of_failures(shares), abs=0.04)
    assert sum(each.share for each in found) == pytest.approx(1.0)


def test_intervals_cover_what_was_planted() -> None:
    """Of 100 studies 95 % are expected, and at least 88 with a chance of 0.998."""
    true = of_failures((0.4, 0.2, 0.4))
    held = np.zeros(3)
    for seed in range(100):
        found = causes_of(failed((0.4, 0.2, 0.4), (200, 2, 2), seed), np.random.default_rng(0))
        held += [t in each.interval for t, each in zip(true, found, strict=True)]
    assert held.min() >= 88


def test_what_the_runs_cannot_tell_apart_is_named_together() -> None:
    runs = failed((0.5, 0.2, 0.3), (400, 2, 2))
    rng = np.random.default_rng(0)
    assert [each.name for each in causes_of(runs[:, :, :1], rng)] == ["die", "world and noise"]
    assert [each.name for each in causes_of(runs[:, :1], rng)] == ["die and world", "noise"]
    for nothing in (runs[:, :1, :1], runs[:1], runs | True, runs & False):
        assert causes_of(nothing, rng) == ()


def test_few_dies_tell_a_share_without_an_interval() -> None:
    found = causes_of(failed((0.5, 0.2, 0.3), (9, 2, 2), 3), np.random.default_rng(0))
    assert {(each.interval.low, each.interval.high) for each in found} == {(0.0, 1.0)}


def test_a_cause_that_was_never_seen_is_not_excluded() -> None:
    """12 of 24 dies fail in every run: none of 24 is at most 14.25 %, a pair half of that, over 1/4."""
    runs = np.zeros((24, 1, 3), np.bool_)
    runs[:12] = True
    die, noise = causes_of(runs, np.random.default_rng(0))
    assert (die.share, noise.share) == (1.0, 0.0)
    assert noise.interval.high == pytest.approx(0.5 * 0.1425 / 0.25, abs=1e-3)
    assert die.interval.low == pytest.approx(1.0 - noise.interval.high)
    both = causes_of(runs.repeat(2, axis=1), np.random.default_rng(0))
    assert [each.interval.high > 0.2 for each in both] == [True, True, True]
