"""The rover:its map, the plan of its way, and its drives."""

from system.rover.body import Rover
from system.rover.cost_map import CostMap, load_map, read_map
from system.rover.planner import Plan, plan_path
from system.rover.run import run
from system.rover.scenario import Scenario
from system.rover.topological_map import plan_places, scatter_places

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Maps and plans
    "CostMap",
    "load_map",
    "read_map",
    "plan_path",
    "Plan",
    "plan_places",
    "scatter_places",
    # Drives
    "Rover",
    "Scenario",
    "run",
]
