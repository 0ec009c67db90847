"""The worst samples come first, with the command that measures each again."""

from __future__ import annotations

import math

import numpy as np

from system.cli.option_names import replay_of
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.report.worst import replay_options, worst
from system.study.specification import Classes, Limits
from system.study.table import FAILED, Condition, Table
from system.study.target import Subject

VALUES = (1.0, math.nan, 1.1, 9.0, 1.2, 0.9, math.nan, 3.0)
OUTCOMES = ("works", "works", "never", "works", "works", "works", FAILED, "works")
N = len(VALUES)
TABLE = Table(
    ("width",), np.arange(1000, 1000 + N), ("random",) * N, np.full(N, 27.0), np.zeros(N, np.int64),
    OUTCOMES, tuple("no step" if o == FAILED else "" for o in OUTCOMES), np.array(VALUES)[:, None],
)  # fmt: skip
SPECIFICATIONS = (Classes(("works",)), Limits("width", 0.5, 2.0, "s"))


def test_failed_then_undefined_then_class_then_distance() -> None:
    found = worst(TABLE, SPECIFICATIONS, 2)
    assert [each.row for each in found] == [6, 1, 2, 3, 7]
    assert [each.why for each in found] == [
        "failed: no step", "width not defined", "class never", "width above 2s", "width above 2s",
    ]  # fmt: skip


def test_without_limits_the_median_counts() -> None:
    found = worst(TABLE, (), 3)
    assert [each.row for each in found] == [6, 1, 3, 7, 5]  # the median is 1.15
    assert found[2].why.startswith("width 2.")
    assert found[2].why.endswith("sigma from the median")


def test_a_passing_sample_says_how_near_the_limit_it_is() -> None:
    (one,) = worst(TABLE, (Limits("width", -10.0, 20.0, "s"),), 1)[2:]
    assert one.row == 5  # 10.9 s above the lower limit; the one at 9 s has 11 s
    assert one.why.endswith("sigma inside the limits")


def test_no_samples() -> None:
    none = Table(
        ("width",), np.zeros(0, np.int64), (), np.zeros(0), np.zeros(0, np.int64), (), (), np.zeros((0, 1))
    )
    assert worst(none, SPECIFICATIONS, 3) == ()


def test_the_command_names_what_the_study_has_several_of() -> None:
    plan = Plan("random", 0, 1000, N)
    one = Study(Subject("a", ("width",)), plan, (Condition("random", 27.0, 0),), 4)
    found = replay_options(one, TABLE, 3)
    assert found == [("die", "1003")]
    assert replay_of("a b", found) == "noctule replay 'a b' --die 1003"
    several = Study(
        Subject("a", ("width",)), plan, (Condition("random", 27.0, 0), Condition("ss", -10.0, 1)), 4
    )
    found = replay_of("s", replay_options(several, TABLE, 3))
    assert found == "noctule replay s --die 1003 --corner random --temperature 27.0 --trial 0"
