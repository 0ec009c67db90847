"""Samples of a finished study by condition, and its yield."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.arrays import F64
from system.options.silicon import SiliconChoice
from system.study.engine import Outcome
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.report.result import Result, groups, of_one_lot, study_yield, summary, varied
from system.study.specification import Limits
from system.study.statistics.confidence_sequence import StopRule, sequence_interval
from system.study.statistics.interval import clopper_pearson
from system.study.table import Condition, Table
from system.study.target import Quantity, Subject, open_target

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
    assert found.causes == {"t_inh above 2.05s": 2, "t_inh not defined": 1}


def test_a_rule_widens_the_interval() -> None:
    (_, _, part), *_ = groups(result())
    fixed, stopped = study_yield(result(), part), study_yield(result(StopRule(0.1)), part)
    assert fixed is not None
    assert stopped is not None
    assert fixed.estimate.interval == clopper_pearson(2, 3)
    assert stopped.estimate.interval.low < fixed.estimate.interval.low
    assert result(StopRule(0.1)).interval_kind(part) == "confidence sequence"


def of_trials(shift: F64, trials: int, temperatures: int = 1) -> Table:
    """Dies with some trials at some temperatures, whose metric is that of the die in all."""
    each = trials * temperatures
    celsius = np.tile(np.repeat(27.0 + np.arange(temperatures), trials), shift.size)
    none, words = np.zeros(shift.size * each, np.int64), ("works",) * (shift.size * each)
    return Table(
        ("t_inh",), np.repeat(1000 + np.arange(shift.size), each), ("random",) * none.size, celsius, none,
        words, ("",) * none.size, np.repeat(shift, each)[:, None],
    )  # fmt: skip


def test_dies_are_the_sample_where_each_has_several() -> None:
    shift = np.random.default_rng(1).normal(2.0, 0.1, 40)
    one, many = of_trials(shift, 1), of_trials(shift, 10)
    apart, alike = study_yield(result(), one), study_yield(result(), many)
    assert apart is not None
    assert alike is not None
    assert alike.samples == 400
    assert alike.estimate.value == apart.estimate.value
    assert alike.estimate.interval.half_width >= apart.estimate.interval.half_width
    assert result().interval_kind(many) == "Korn-Graubard"
    quantity = Quantity("t_inh", "s")
    single, several = summary(result(), one, quantity), summary(result(), many, quantity)
    # means of dies differ from their one value by a rounding
    ends = single.mean.interval.low, single.mean.interval.high
    assert (several.mean.interval.low, several.mean.interval.high) == pytest.approx(ends, rel=1e-9)
    for estimate in (several.sigma, several.skew, several.quantiles[0].estimate):
        assert (np.isfinite(estimate.value), np.isfinite(estimate.interval.high)) == (True, False)
    yes = Quantity("t_inh", "", yes_no=True)
    share = summary(result(), of_trials(np.repeat([1.0, 0.0], 10), 20), yes).share
    assert share is not None
    assert share.estimate.interval.half_width >= clopper_pearson(10, 20).half_width


def test_a_rule_over_temperatures_takes_each_as_its_own() -> None:
    """Ten dies at five temperatures are no fifty dies."""
    table = of_trials(np.repeat([2.0, 2.1], [9, 1]), 1, 5)
    found = study_yield(result(StopRule(0.1)), table)
    assert found is not None
    assert found.estimate.value == 0.9
    wanted = sequence_interval(9, 10, 0.99)
    ends = found.estimate.interval.low, found.estimate.interval.high
    assert ends == pytest.approx((wanted.low, wanted.high), rel=1e-12)


@pytest.mark.parametrize(("corner", "text"), [("random", "mismatch and process"), ("ss", "mismatch")])
def test_what_varies(corner: str, text: str) -> None:
    study = Study(STUDY.subject, STUDY.plan, (Condition(corner, 27.0, 0),), 4)
    assert varied(study) == text
    full = replace(STUDY.subject, silicon=replace(STUDY.subject.silicon, variation="full"))
    assert varied(replace(study, subject=full)) == f"{text}, variation full"


def test_dies_that_share_draws_are_said_to() -> None:
    full = SiliconChoice(variation="full")
    said = of_one_lot(full, range(1000, 1040))
    assert said.startswith(
        "The dies are of lot A and 1 wafer of it, whose draws they share: spreads, intervals"
    )
    assert "and 3 wafers of it" in of_one_lot(full, range(1000, 1100))
    assert of_one_lot(SiliconChoice(), range(1000, 1040)) == ""
    assert of_one_lot(replace(full, process_variation=False), range(1000, 1040)) == ""
    assert of_one_lot(full, range(1000, 1040), ("ss", "ff")) == ""
