"""Samples of a finished study by condition, and its yield."""

import numpy as np
import pytest

from system.study.engine import Outcome
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.report.result import Result, groups, study_yield, varied
from system.study.specification import Limits
from system.study.statistics.confidence_sequence import StopRule
from system.study.statistics.interval import clopper_pearson
from system.study.table import Condition, Table
from system.study.target import Subject, open_target

CONDITIONS = (Condition("random", 27.0, 0), Condition("ss", 27.0, 0))
STUDY = Study(Subject("rebound-neuron", ("t_inh",)), Plan("random", 0, 1000, 3), CONDITIONS, 4)
TABLE = Table(
    ("t_inh",), np.repeat([1000, 1001, 1002], 2),
    ("random", "ss") * 3, np.full(6, 27.0), np.zeros(6, np.int64),
    ("works",) * 6, ("",) * 6, np.array([[1.0], [2.0], [1.1], [2.1], [np.nan], [2.2]]),
)  # fmt: skip


def result(rule: StopRule | None = None) -> Result:
    limits = Limits("t_inh", 0.0, 2.05, "s")
    return Result(STUDY, open_target(STUDY.subject), Outcome(TABLE, 0, (), stopped=False), (limits,), rule)


def test_groups_are_the_conditions_in_order() -> None:
    found = list(groups(result()))
    assert [(corner, celsius) for corner, celsius, _ in found] == [("random", 27.0), ("ss", 27.0)]
    assert found[1][2].column("t_inh").tolist() == [2.0, 2.1, 2.2]


def test_the_yield_counts_undefined_samples_as_failing() -> None:
    found = study_yield(result(), TABLE)
    assert found is not None
    assert (found.passed, found.samples) == (3, 6)
    assert found.estimate.interval == clopper_pearson(3, 6)
    assert found.causes == {"t_inh above 2.05s": 2, "t_inh not defined": 1}


def test_a_rule_widens_the_interval() -> None:
    fixed, stopped = study_yield(result(), TABLE), study_yield(result(StopRule(0.1)), TABLE)
    assert fixed is not None
    assert stopped is not None
    assert stopped.estimate.interval.low < fixed.estimate.interval.low
    assert result(StopRule(0.1)).interval_kind == "confidence sequence"


@pytest.mark.parametrize(("corner", "text"), [("random", "mismatch and process"), ("ss", "mismatch")])
def test_what_varies(corner: str, text: str) -> None:
    study = Study(STUDY.subject, STUDY.plan, (Condition(corner, 27.0, 0),), 4)
    assert varied(study) == text
