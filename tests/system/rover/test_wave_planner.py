"""Planning by waves: ideal cells, the paper's model, and chips of transistors."""

from __future__ import annotations

import numpy as np
import pytest

from chips.wavefront.chip import ChipCells
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.rover.cost_map import load_map
from system.rover.planner import path_cost, plan_path
from system.rover.wave_planner import ChipPlanner, plan_discrete, plan_ideal

PARK = load_map("map2")
ENDS = (2, 10), (19, 10)


def chip(number: int | None, temperature_c: float = 27.0, area: float = 1.0) -> ChipPlanner:
    return ChipPlanner(
        ChipCells(Silicon(AMI_1500_IDEAL, temperature_c=temperature_c, die=Die("A", number)), area=area)
    )


def test_the_nominal_chip_plans_as_cheaply_as_ideal_cells() -> None:
    ideal = plan_path(PARK, *ENDS, plan_ideal)
    assert plan_path(PARK, *ENDS, chip(None)).cost == ideal.cost


@pytest.mark.parametrize("temperature_c", [0.0, 60.0])
def test_a_die_plans_a_way_from_start_to_goal(temperature_c: float) -> None:
    plan = plan_path(PARK, *ENDS, chip(7, temperature_c))
    assert (tuple(plan.path[0]), tuple(plan.path[-1])) == ENDS
    assert np.abs(np.diff(plan.path, axis=0)).max(axis=1).tolist() == [1] * (plan.length - 1)
    assert plan.regret >= 0


def test_dies_of_small_devices_differ_in_their_ways() -> None:
    costs = np.full((12, 12), 7)
    paths = {str(chip(k, area=0.5)(costs, (0, 0), (5, 11)).tolist()) for k in range(4)}  # type: ignore[union-attr]
    assert len(paths) == 4


def test_a_chip_refuses_what_it_has_no_code_for() -> None:
    with pytest.raises(ParameterError, match="31"):
        chip(None)(np.full((3, 3), 32), (0, 0), (2, 2))


def test_walls_leave_no_path() -> None:
    wall = np.array([[1, 0, 1]])
    for planner in (plan_ideal, plan_discrete, chip(None)):
        assert planner(wall, (0, 0), (0, 2)) is None


def test_the_discrete_model_refuses_what_would_take_hours() -> None:
    with pytest.raises(ParameterError, match=r"^planner: paper on 10201 cells, must be at most 10000"):
        plan_discrete(np.ones((101, 101), dtype=np.int64), (0, 0), (100, 100))


def test_the_discrete_model_may_cost_more() -> None:
    # neurons fire again and the walk takes the most recent spike, so that no path of least cost is promised
    found = plan_discrete(PARK.costs, *ENDS)
    assert found is not None
    assert path_cost(PARK.costs, found) >= plan_path(PARK, *ENDS, plan_ideal).cost
