"""Shares of runs."""

from __future__ import annotations

import pytest
from scipy import stats

from circuits.errors import ParameterError
from system.study.statistics.interval import Interval
from system.study.statistics.share import Share, percent, share_where


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


@pytest.mark.parametrize(
    ("ends", "words"),
    [
        ((0.0, 0.1684), "0 to 17 %"),
        ((0.0, 0.0037), "0.0 to 0.4 %"),
        ((0.9963, 1.0), "99.6 to 100.0 %"),
        ((0.0, 1.0), "0 to 100 %"),
        ((0.5, 0.5), "50 to 50 %"),
    ],
)
def test_an_interval_never_looks_like_a_point_unless_it_is_one(ends: tuple[float, float], words: str) -> None:
    assert percent(Interval(*ends)) == words
