"""Power of tests: against sums by hand, textbook tables and the tests themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import binomtest

from circuits.errors import ParameterError
from system.study.statistics.power import (
    binomial_power,
    detectable_mean,
    detectable_ratio,
    detectable_share,
    mean_power,
)


def test_the_power_of_a_sign_test_is_the_chance_of_what_it_rejects() -> None:
    # of ten pairs 0, 1, 9 and 10 are rejected at 5 %; at 0.9 that is 10 0.9^9 0.1 + 0.9^10 and a little
    by_hand = 10 * 0.9**9 * 0.1 + 0.9**10 + 0.1**10 + 10 * 0.1**9 * 0.9
    assert binomial_power(10, 0.9) == pytest.approx(by_hand, rel=1e-12)
    assert [binomtest(k, 10).pvalue <= 0.05 for k in (1, 2, 8, 9)] == [True, False, False, True]
    assert binomial_power(10, 0.5) <= 0.05
    assert binomial_power(0, 0.9) == 0.0


def test_a_share_that_is_detectable_is_found_in_four_of_five_cases() -> None:
    for count in (10, 20, 64, 400):
        assert binomial_power(count, detectable_share(count)) == pytest.approx(0.8, abs=1e-6)
    assert math.isnan(detectable_share(5))  # not even five of five is significant


def test_a_ratio_of_rates_is_told_by_its_events() -> None:
    # log of the ratio over its error, sqrt(4 / events): 1.96 + 0.84 of it for 80 %
    assert math.log(detectable_ratio(1.0, 1.0, 400)) == pytest.approx(2.8 * math.sqrt(4 / 400), rel=0.05)
    assert math.log(detectable_ratio(3.0, 1.0, 2000)) == pytest.approx(
        2.8 * math.sqrt(1 / 1500 + 1 / 500), rel=0.05
    )


def test_the_power_of_a_mean_is_that_of_tables_and_of_draws() -> None:
    # Cohen (1988), one sample, two-sided 5 %: effect 0.5, n 34 has a power of 0.81
    assert mean_power(34, 0.5) == pytest.approx(0.81, abs=0.01)
    random = np.random.default_rng(0)
    drawn = 1.5 + random.standard_normal((4000, 5))
    t = drawn.mean(axis=1) / drawn.std(axis=1, ddof=1) * math.sqrt(5)
    # 2.776: two-sided 5 % of four degrees; a share of 4000 is within 0.02 in 99 % of cases
    assert mean_power(5, 1.5) == pytest.approx(float(np.mean(np.abs(t) > 2.776)), abs=0.02)
    assert mean_power(5, detectable_mean(5)) == pytest.approx(0.8, abs=1e-6)
    assert math.isnan(detectable_mean(1))
    assert mean_power(1, 9.0) == 0.0


def test_no_events_below_none_and_no_share_beyond_one() -> None:
    with pytest.raises(ParameterError, match="count again"):
        binomial_power(-1, 0.5)
    with pytest.raises(ParameterError, match=r"shares 1\.5"):
        binomial_power(5, 1.5)
