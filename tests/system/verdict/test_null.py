"""Nulls: what knows nothing is scored by the same rows, and what is not above it is said to be so."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from circuits.errors import ParameterError
from system.experiment import Report
from system.rule import Measured, above, at_least, at_most, below, equal, unjudged
from system.statement import Statement
from system.verdict.null import Null, Score, above_p, nulls_of, scores, shuffled, warning

WAYS, STOOD = [3.0] * 6, [0.0] * 6


def rows(ways: list[float]) -> tuple[Statement, ...]:
    """A row a run on whether it got on, one on whether none was too far, and one without a verdict."""
    each = [Statement(f"way_{k}_m", 2.0, way, above(1.0)) for k, way in enumerate(ways)]
    return (
        *each,
        Statement("longest_m", None, max(ways), at_most(9.0)),
        Statement("x", None, 1.0, unjudged()),
    )


def test_a_null_is_judged_by_the_rows_that_judge_ours() -> None:
    found = scores(rows(WAYS), nulls_of(rows, {"never moves": STOOD}), ())
    assert found == (
        Score("ours", 7, 7),
        Score("never moves", 1, 7, binomtest(6, 6, alternative="greater").pvalue),
        Score("paper", 6, 6),
    )
    assert found[1].beaten
    assert warning(found) == ""
    assert str(found[1]) == "never moves 1 of 7 (p 0.016)"


def test_what_is_not_above_a_null_is_said_first() -> None:
    nulls = nulls_of(rows, {"never moves": STOOD, "moves as ours": WAYS})
    report = Report(rows(WAYS), lambda _: None, ("a note",), nulls)
    first, second = report.said
    assert first == ("These rows show nothing above: moves as ours 7 of 7 (p 1); ours holds 7 of 7.")
    assert second == "a note"
    assert Report(rows(WAYS), lambda _: None, ("a note",), nulls[:1]).said == ("a note",)


def test_few_rows_can_show_nothing() -> None:
    few = Report(rows(WAYS[:3]), lambda _: None, nulls=nulls_of(rows, {"never moves": STOOD[:3]}))
    assert few.scores[1].p == 0.125
    assert few.said[0].endswith("Fewer than five rows can show nothing by this test.")


def test_a_null_has_all_rows_that_ours_has() -> None:
    with pytest.raises(ParameterError, match="never moves: no row way_0_m"):
        scores(rows(WAYS), (Null("never moves", rows(STOOD)[1:]),), ())


def test_the_papers_own_values_are_judged_where_they_are_of_a_kind_with_ours() -> None:
    own = (
        Statement("gain", 2.0, 1.0, at_least(1.5)),
        Statement("turns_to", "left", "right", equal()),
        Statement("share", "most", 0.4, at_least(0.5)),
        Statement("p", 0.01, Measured(1.0, "better", p=0.2), above(0.0)),
        Statement("none", None, 1.0, below(2.0)),
    )
    assert scores(own, (), ())[-1] == Score("paper", 2, 2)
    paper = tuple(Statement(row.name, row.paper, 1.0, above(0.0)) for row in own)
    assert scores(own, (), paper)[-1] == Score("paper", 5, 5)
    assert [score.name for score in scores(own[2:], (), ())] == ["ours"]


@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=12))
def test_only_rows_that_differ_count(pairs: list[tuple[bool, bool]]) -> None:
    differ = [pair for pair in pairs if pair[0] is not pair[1]]
    p = above_p([a for a, _ in pairs], [b for _, b in pairs])
    assert p == above_p([a for a, _ in differ], [b for _, b in differ])
    assert (p < 1.0) is any(a for a, _ in differ)


def test_shuffled_data_stand_by_the_middle_score() -> None:
    values = np.arange(10.0)

    def rising(found: np.ndarray) -> tuple[Statement, ...]:
        return tuple(
            Statement(f"step_{k}", None, float(b - a), above(0.0)) for k, (a, b) in enumerate(pairwise(found))
        )

    null = shuffled("drawn anew", rising, lambda order: values[order], values.size)
    held = sum(row.agrees is True for row in null.rows)
    assert 3 <= held <= 6  # of nine steps, one half rises
    assert null == shuffled("drawn anew", rising, lambda order: values[order], values.size)
