"""Yields of two designs on the same dies: pairs cancel what they share, and no die is lost unseen."""

import math

import numpy as np
import pytest
from scipy import stats

from circuits.errors import ParameterError
from system.study.statistics.comparison import (
    Pairing,
    compare_yields,
    paired_equivalence,
    paired_interval,
)
from system.study.statistics.interval import Interval

ALL, NONE = np.ones(4, dtype=np.bool_), np.zeros(0, dtype=np.bool_)


def test_dies_of_one_design_only_are_counted() -> None:
    found = compare_yields(np.array([1, 2, 3, 4]), ALL, np.array([9, 4, 3, 2]), ALL)
    assert found.pairing == Pairing(3, 1, 1)
    assert found.both_pass == 3


def test_no_common_die() -> None:
    none, one = np.array([], dtype=np.int64), np.array([1])
    yields = compare_yields(none, NONE, one, ALL[:1])
    assert yields.pairing == Pairing(0, 0, 1)
    assert math.isnan(yields.difference.value)
    assert yields.difference.interval == Interval(-1.0, 1.0)
    assert yields.p_value == 1.0


def test_a_die_that_is_there_twice_is_refused() -> None:
    with pytest.raises(ParameterError, match="dies: one is there twice"):
        compare_yields(np.array([1, 1]), ALL[:2], np.array([1]), ALL[:1])


def test_mcnemar() -> None:
    first = np.array([True] * 60 + [False] * 40)
    second = np.array([True] * 55 + [False] * 5 + [True] * 14 + [False] * 26)
    found = compare_yields(np.arange(100), first, np.arange(100), second)
    assert (found.both_pass, found.only_first_passes) == (55, 5)
    assert (found.only_second_passes, found.neither_passes) == (14, 26)
    assert found.difference.value == pytest.approx(0.09)
    # binomial(19, 1/2): twice the chance of 5 or fewer, (1 + 19 + 171 + 969 + 3876 + 11628) / 2^19
    assert found.p_value == pytest.approx(2.0 * 16664 / 2**19)
    assert 0.0 not in found.difference.interval


def test_the_interval_mirrors_and_inverts_the_score_test() -> None:
    ours, mirrored = paired_interval(14, 5, 100), paired_interval(5, 14, 100)
    assert (ours.low, ours.high) == pytest.approx((-mirrored.high, -mirrored.low))
    z = stats.norm.ppf(0.975)
    # without any disagreement n d^2 = z^2 d (1 - d), so d = z^2 / (n + z^2)
    assert paired_interval(0, 0, 50).high == pytest.approx(z * z / (50.0 + z * z))
    # if all gain (1 - d) n = z^2 (1 + d)
    assert paired_interval(50, 0, 50).low == pytest.approx((50.0 - z * z) / (50.0 + z * z))
    assert paired_interval(50, 0, 50).high == 1.0


@pytest.mark.parametrize("chances", [(0.1, 0.1), (0.2, 0.05), (0.02, 0.02), (0.5, 0.05), (0.0, 0.05)])
def test_the_difference_is_covered_by_the_exact_sum(chances: tuple[float, float]) -> None:
    n, truth = 30, chances[0] - chances[1]
    covered = 0.0
    for gained in range(n + 1):
        for lost in range(n + 1 - gained):
            counts = [gained, lost, n - gained - lost]
            chance = float(stats.multinomial.pmf(counts, n, [*chances, 1.0 - sum(chances)]))
            if chance > 1e-9 and truth in paired_interval(gained, lost, n):
                covered += chance
    assert covered >= 0.94  # a score interval covers 95 % on average over chances, not for each


@pytest.mark.parametrize(("gained", "lost"), [(3, 4), (5, 5), (10, 12), (4, 9), (12, 2)])
def test_two_yields_are_alike_where_their_90_percent_interval_is_within_the_margin(
    gained: int, lost: int
) -> None:
    ends = paired_interval(gained, lost, 100, 0.9)
    margin = max(-ends.low, ends.high)
    assert paired_equivalence(gained, lost, 100, margin) == pytest.approx(0.05, abs=1e-6)
    assert paired_equivalence(gained, lost, 100, 1.2 * margin) < 0.05
    assert paired_equivalence(gained, lost, 100, 0.8 * margin) > 0.05
    assert paired_equivalence(gained, lost, 0, margin) == 1.0
