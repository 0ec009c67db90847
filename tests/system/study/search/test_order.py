"""The worst dies first: the order of a study's chunks by the gradient, and a table that is the same."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.options.silicon import SiliconChoice
from system.study.engine import on_threads, run_study
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.search.order import worst_first
from system.study.specification import Classes, Limits
from system.study.table import Condition, Table
from system.study.target import Subject, open_target

SUBJECT = Subject("rebound-neuron", ("t_inh_s",), silicon=SiliconChoice(process_variation=False))
STUDY = Study(SUBJECT, Plan("random", 0, 1000, 6), (Condition("random", 27.0, 0),), 1)
LIMITS = Limits("t_inh_s", -np.inf, 8e-3, "s")


def test_dies_that_are_nearest_to_failing_come_first_and_the_table_is_the_same() -> None:
    order = worst_first(STUDY, open_target(SUBJECT), [LIMITS])
    seen: list[int] = []

    def look(table: Table) -> bool:
        seen.append(int(table.die[0]))
        return False

    with on_threads(1) as workers:
        found = run_study(STUDY, workers=workers, part=order, stop=look).table
    assert found.die.tolist() == list(range(1000, 1006))
    assert seen == [1000 + k for k in order]
    by_value = [int(k) for k in np.argsort(-found.column("t_inh_s"))]
    assert list(order[:2]) == by_value[:2]
    assert order[-1] == by_value[-1]


def test_an_order_needs_a_limit_of_a_metric_that_has_a_gradient() -> None:
    target = open_target(SUBJECT)
    with pytest.raises(ParameterError, match="order: worst, of which specification"):
        worst_first(STUDY, target, [Classes(("works",))])
    system = replace(SUBJECT, target="car", metrics=("collided",))
    with pytest.raises(ParameterError, match="order: worst, car is a system"):
        worst_first(replace(STUDY, subject=system), open_target(system), [LIMITS])
