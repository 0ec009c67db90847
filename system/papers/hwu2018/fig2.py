"""Figure 2 of Hwu et al. 2018: a collision of waves, and its remedy by a second pass.

"In some instances, the collision of multiple spike waves generated inefficient paths. This was remedied by
adding a second pass with a cost map containing just the paths from the first pass." The paper's discrete
model plans the 100 pairs of `hwu2018-table1` on its four maps, twice each, and the instance whose first
path the second pass improves most is drawn. Statements:

- there are such instances: pairs whose first path takes more cells than its second;
- the remedy: no second path is longer than its first, and none leaves the cells of its first;
- what is drawn is shorter after the remedy.

That second paths are efficient "in terms of length and cost" is not promised by the model: how many of them
are as cheap as Dijkstra's, before and after, is in the notes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.wavefront.paper_walk import plan_in_two_passes
from circuits.arrays import I64
from system.experiment import Experiment, Progress, Report, with_progress
from system.papers.hwu2018.table1 import PAIRS, SEED
from system.rover.cost_map import MAPS, Cell, CostMap, load_map, random_pairs
from system.rover.drive import polyline
from system.rover.picture import draw_map, draw_ways
from system.rover.planner import path_cost
from system.rover.search import dijkstra
from system.rule import at_least, none
from system.statement import Statement


@dataclass(frozen=True, slots=True)
class Instance:
    """A pair of places on a map: paths of both passes, int64[n, 2], and the lowest cost."""

    cost_map: CostMap
    first: I64
    second: I64
    lowest: int

    @property
    def saved(self) -> int:
        """Cells by which the second path is shorter."""
        return len(self.first) - len(self.second)

    @property
    def stays(self) -> bool:
        """Whether the second path keeps to the cells of the first."""
        return {tuple(c) for c in self.second.tolist()} <= {tuple(c) for c in self.first.tolist()}

    def regret(self, path: I64) -> int:
        """Cost of a path above the lowest."""
        return path_cost(self.cost_map.costs, path) - self.lowest


def reproduce(progress: Progress, pairs: int = PAIRS) -> Report:
    """Plan all pairs of places in two passes."""
    found: list[Instance] = []
    for name in with_progress(MAPS, progress):
        cost_map = load_map(name)
        for start, goal in random_pairs(cost_map, pairs, np.random.default_rng(SEED)).tolist():
            found.append(_instance(cost_map, tuple(start), tuple(goal)))
    worst = max(found, key=lambda each: each.saved)
    return Report(rows(found), lambda figure: _draw(worst, figure), _notes(found))


def _instance(cost_map: CostMap, start: Cell, goal: Cell) -> Instance:
    passes = plan_in_two_passes(cost_map.costs, start, goal)
    lowest = dijkstra.distances(cost_map.costs, start)[goal] + cost_map.costs[goal]
    return Instance(cost_map, passes.first_path, passes.second_path, int(lowest))


def rows(found: list[Instance]) -> tuple[Statement, ...]:
    """Make the statements about all pairs."""
    collided = sum(each.saved > 0 for each in found)
    longer = sum(each.saved < 0 for each in found)
    left = sum(not each.stays for each in found)
    most = max(each.saved for each in found)
    return (
        Statement(
            "inefficient_first_paths",
            "some instances",
            float(collided),
            at_least(1.0, f"at least {{limit:g}} of {len(found)}"),
        ),
        Statement("cells_saved_in_the_drawn_one", "remedied", float(most), at_least(1.0)),
        Statement("second_paths_longer", None, float(longer), none()),
        Statement("second_paths_off_the_first", None, float(left), none()),
    )


def _notes(found: list[Instance]) -> tuple[str, ...]:
    notes = []
    for name in MAPS:
        here = [each for each in found if each.cost_map.name == name]
        regrets = [each.regret(each.first) for each in here], [each.regret(each.second) for each in here]
        optimal = [sum(r == 0 for r in values) for values in regrets]
        notes.append(
            f"{name}: first paths as cheap as can be {optimal[0]} of {len(here)}, second paths {optimal[1]};"
            f" mean cost above the lowest {np.mean(regrets[0]):.3g} and {np.mean(regrets[1]):.3g}; second"
            f" paths shorter {sum(each.saved > 0 for each in here)}"
        )
    return tuple(notes)


def _draw(instance: Instance, figure: Figure) -> None:
    """First path beside the second."""
    figure.set_size_inches(8.0, 4.6)
    titles = "(a) first pass", "(b) second pass"
    for ax, path, title in zip(figure.subplots(1, 2), (instance.first, instance.second), titles, strict=True):
        draw_map(instance.cost_map, None, ax)
        draw_ways(polyline(instance.cost_map, path), [], ax)
        regret = instance.regret(path)
        ax.set_title(f"{title}: {len(path)} cells, cost {instance.lowest + regret}", fontsize=9, loc="left")
        ax.set(xlabel="east (m)", ylabel="north (m)")
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)


EXPERIMENT = Experiment("hwu2018-fig2", "a collision of waves and its remedy by a second pass", reproduce)
