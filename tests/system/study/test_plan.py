"""Sampling plans: spread over the whole, the same for every part."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

from circuits.errors import ParameterError
from system.study.plan import Method, Plan, sampling

LABELS = tuple(f"block.m{k}.v_t0" for k in range(5))


def test_random_leaves_every_die_its_own_draws() -> None:
    assert sampling(Plan("random", 0, 1000, 8), LABELS, 1000, 1008) is None


@pytest.mark.parametrize("method", ["lhs", "sobol"])
def test_a_part_of_a_plan_is_that_part_of_the_whole(method: Method) -> None:
    plan = Plan(method, 3, 1000, 16)
    whole, part = (sampling(plan, LABELS, *ends) for ends in ((1000, 1016), (1004, 1009)))
    assert whole is not None
    assert part is not None
    np.testing.assert_array_equal(part.rows, whole.rows[4:9])
    assert part.first == 1004
    other = sampling(Plan(method, 4, 1000, 16), LABELS, 1000, 1016)
    assert other is not None
    assert not np.array_equal(other.rows, whole.rows)


@pytest.mark.parametrize("method", ["lhs", "sobol"])
def test_every_draw_has_one_sample_in_each_of_as_many_strata(method: Method) -> None:
    found = sampling(Plan(method, 0, 1000, 16), LABELS, 1000, 1016)
    assert found is not None
    strata = np.sort(np.floor(16.0 * ndtr(found.rows)), axis=0)
    np.testing.assert_array_equal(strata, np.repeat(np.arange(16.0)[:, None], 5, axis=1))


def test_only_own_draws_can_be_extended() -> None:
    assert Plan("random", 0, 0, 1).extensible
    assert not Plan("sobol", 0, 0, 1).extensible


def test_a_plan_over_nothing_is_refused() -> None:
    with pytest.raises(ParameterError, match="plan: lhs, nothing varies"):
        sampling(Plan("lhs", 0, 0, 4), (), 0, 4)
