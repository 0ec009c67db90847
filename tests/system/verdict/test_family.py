"""Families of tests: Holm's adjusted probabilities, and rows that are judged by them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from system.rule import Measured, above, equivalent, significant
from system.statement import Statement
from system.verdict.family import family, holm


def test_the_smallest_is_taken_as_often_as_there_are_tests() -> None:
    # by hand: 4 x 0.01, 3 x 0.02, 2 x 0.03 and no less than the one before, 0.2
    assert holm([0.03, 0.01, 0.2, 0.02]) == pytest.approx([0.06, 0.04, 0.2, 0.06])
    assert holm([0.9, 0.9]).tolist() == [1.0, 1.0]
    assert holm([]).size == 0


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
def test_adjusting_keeps_the_order_and_lowers_none(p: list[float]) -> None:
    found = holm(p)
    assert np.all(found >= np.array(p))
    assert np.all(found <= 1.0)
    order = np.argsort(p, kind="stable")
    assert np.all(np.diff(found[order]) >= 0.0)
    # Bonferroni's is never below it
    assert np.all(found <= np.minimum(len(p) * np.array(p), 1.0) + 1e-12)


def row(p: float) -> Statement:
    return Statement("x", None, Measured(1.0, f"p {p:g}", p=p), significant(1, 0.05, "better"))


def test_rows_with_a_p_are_judged_with_the_others_in_view() -> None:
    plain = Statement("y", None, 1.0, above(0.0))
    alike = Statement(
        "z", None, Measured(0.0, "alike", p=0.01), equivalent(0.1, 0.05, "no different by {limit:g}")
    )
    unknown = row(math.nan)
    first, second, third, *rest = family((row(0.03), row(0.02), alike, plain, unknown))
    assert [each.agrees for each in (first, second, third)] == [True, True, True]
    assert first.shown == "p 0.03, Holm 0.04"
    assert first.rule.text == "better, p < 0.05; Holm over 3 rows"
    assert rest == [plain, unknown]
    # alone significant, not among three
    assert [each.agrees for each in family((row(0.03), row(0.5), row(0.6)))] == [False, False, False]
    assert family((row(0.03), plain)) == (row(0.03), plain)
