"""Statements: a row of a report, whose sentence, tolerance and verdict are its rule's."""

from __future__ import annotations

from system.experiment import Report
from system.rule import Measured, above, at_least, unjudged, within_share
from system.statement import Statement

GAIN = Statement("gain", 2.0, 2.1, within_share(0.1), fitted=True)
SHARE = Statement("share", "most", Measured(0.4, "4 of 10"), at_least(0.5))
BESIDE = Statement("charge_C", None, 1e-12, unjudged("shown beside"))


def test_a_row_has_what_its_rule_says() -> None:
    assert GAIN.row() == {
        "name": "gain",
        "paper": 2.0,
        "ours": 2.1,
        "rule": "within 10 %",
        "tolerance": 0.1,
        "fitted": True,
        "agrees": True,
    }


def test_a_measured_value_is_shown_in_words_and_judged_by_its_number() -> None:
    row = SHARE.row()
    assert (row["ours"], row["agrees"], row["fitted"]) == ("4 of 10", False, False)


def test_a_row_without_a_rule_has_no_verdict_and_hinders_no_report() -> None:
    row = BESIDE.row()
    assert (row["rule"], row["tolerance"], row["agrees"]) == ("shown beside", None, None)
    assert Report((GAIN, BESIDE), lambda _: None).agrees
    report = Report((GAIN, SHARE, BESIDE), lambda _: None)
    assert (report.agrees, report.disagreeing) == (False, ("share",))


def test_a_limit_of_the_papers_own_is_its_value() -> None:
    rule = above(text="above the paper's")
    assert [Statement("x", 2.0, ours, rule).agrees for ours in (2.5, 1.5)] == [True, False]
