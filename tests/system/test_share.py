"""Shares of runs."""

from __future__ import annotations

import pytest
from scipy import stats

from circuits.errors import ParameterError
from system.share import Share, share_where


@pytest.mark.parametrize("counts", [(19, 20), (0, 7), (7, 7), (1, 4)])
def test_a_share_has_the_exact_interval(counts: tuple[int, int]) -> None:
    share, theirs = Share(*counts), stats.binomtest(*counts).proportion_ci(method="exact")
    assert share.value == counts[0] / counts[1]
    # scipy finds the ends by root search, to 1e-12 relative or so
    assert (share.interval.low, share.interval.high) == pytest.approx(theirs, abs=1e-9)


def test_it_is_told_in_words() -> None:
    assert str(Share(19, 20)) == "19 of 20 (75 to 100 %)"


def test_none_of_none_says_nothing() -> None:
    share = share_where([])
    assert (share.passed, share.of, share.value) == (0, 0, 0.0)
    assert (share.interval.low, share.interval.high) == (0.0, 1.0)


def test_what_is_true_counts() -> None:
    assert share_where(x > 1 for x in (1, 2, 3)) == Share(2, 3)


def test_more_than_all_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"^passed: 5, must be from 0 to samples 4"):
        _ = Share(5, 4).interval
