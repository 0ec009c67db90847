"""Figure 1 of Hwu et al. 2018: the spike wave without and with a road, and the paths found.

The paper's discrete model runs on map 1 from the top middle to the bottom middle, with a road and without
one, and how far the wave is and which path follows are compared between the two. Shown are the spikes of
time steps 3 and 18 and the path after the second pass, as in the figure; which neurons had fired by then is
drawn paler. The figure prints no numbers; its statements are:

- the wave "propagates faster when there is a low cost road present": at both steps more neurons have fired;
- the goal fires earlier with the road; - without the road "the best path is the most direct route": no path
has fewer cells; - with it "it is advantageous to take a longer route along a smooth road": at least 80 % of
its cells (ours) are
  road, and it is longer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from chips.wavefront.paper_walk import TwoPasses, plan_in_two_passes
from circuits.arrays import Bools
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import INK
from system.rover.cost_map import CostMap, load_map
from system.rover.drive import polyline
from system.rover.picture import draw_map, draw_ways
from system.rover.planner import path_cost, plan_path, planner_named
from system.rule import above, at_least, below, exactly
from system.statement import Statement

START, GOAL = (2, 10), (19, 10)
STEPS = (3, 18)  # the paper's
ON_ROAD = 0.8  # share of the path; ours
PLAIN, ROAD = "map1-without-road", "map1-road"
_WAVE = ListedColormap(["#FFFFFF00", "#F0E44266", "#FFEE00"])  # at rest, has fired, fires: the paper's yellow


@dataclass(frozen=True, slots=True)
class Wave:
    """One variant of the map and its two passes."""

    cost_map: CostMap
    passes: TwoPasses

    def firing(self, step: int) -> Bools:
        """Neurons that spike in a step, bool[rows, columns]."""
        table = self.passes.first_table
        found = np.zeros(self.cost_map.costs.size, dtype=np.bool_)
        found[table.neurons[table.steps == step]] = True
        return found.reshape(self.cost_map.shape)

    def fired(self, step: int) -> Bools:
        """Neurons that have spiked by a step, bool[rows, columns]."""
        return self.passes.first_table.first_spikes() <= step

    @property
    def arrival(self) -> int:
        """Step in which the goal first fires."""
        return int(self.passes.first_table.first_spikes()[GOAL])

    @property
    def on_road(self) -> float:
        """Share of the path's cells that are road."""
        path = self.passes.second_path
        return float((self.cost_map.costs[path[:, 0], path[:, 1]] == 1).mean())


def reproduce(progress: Progress) -> Report:
    """Plan on both variants of the map."""
    waves: list[Wave] = []
    for name in with_progress((PLAIN, ROAD), progress):
        cost_map = load_map(name)
        waves.append(Wave(cost_map, plan_in_two_passes(cost_map.costs, START, GOAL)))
    plain, road = waves
    return Report(rows(plain, road), lambda figure: _draw(waves, figure), _notes(plain, road))


def rows(plain: Wave, road: Wave) -> tuple[Statement, ...]:
    """Make the statements about the wave without and with the road."""
    direct = plan_path(plain.cost_map, START, GOAL, planner_named("wave")).length
    length, longer = len(plain.passes.second_path), len(road.passes.second_path)
    return (
        *(_faster(step, int(plain.fired(step).sum()), int(road.fired(step).sum())) for step in STEPS),
        Statement(
            "goal_fires_at_step_with_road",
            "earlier",
            float(road.arrival),
            below(float(plain.arrival), "below {limit:g} without"),
        ),
        Statement(
            "path_length_without_road",
            "most direct",
            float(length),
            exactly(float(direct), "the fewest cells, {limit:g}"),
        ),
        Statement(
            "path_length_with_road", "longer", float(longer), above(float(length), "above {limit:g} without")
        ),
        Statement("path_share_on_road", "along a smooth road", road.on_road, at_least(ON_ROAD)),
    )


def _faster(step: int, plain: int, road: int) -> Statement:
    name = f"neurons_fired_by_step_{step}_with_road"
    return Statement(name, "more", float(road), above(float(plain), "above {limit:g} without"))


def _notes(plain: Wave, road: Wave) -> tuple[str, ...]:
    notes = ["A hop takes one step more than its cost in equations (1) to (4), and neurons fire again."]
    for wave in (plain, road):
        table = wave.passes.first_table
        ideal = plan_path(wave.cost_map, START, GOAL, planner_named("wave"))
        again = int((table.counts() > 1).sum())
        found = wave.passes.second_path
        notes.append(
            f"{wave.cost_map.name}: {table.neurons.size} spikes until the goal's, {again} neurons fired more"
            f" than once; path of {len(found)} cells and cost {path_cost(wave.cost_map.costs, found)}, ideal"
            f" cells {ideal.length} and {ideal.cost}."
        )
    return tuple(notes)


def _draw(waves: list[Wave], figure: Figure) -> None:
    """A column a variant; activity at both steps, then the path."""
    figure.set_size_inches(5.6, 8.0)
    axes = figure.subplots(3, 2)
    for column, (wave, title) in enumerate(zip(waves, ("without road", "with road"), strict=True)):
        axes[0, column].set_title(title, fontsize=9)
        for row, step in enumerate(STEPS):
            _draw_activity(wave, step, axes[row, column])
        draw_map(wave.cost_map, None, axes[2, column])
        draw_ways(polyline(wave.cost_map, wave.passes.second_path), [], axes[2, column])
    for ax in axes.flat:
        ax.set(xticks=(), yticks=())
    for ax, label in zip(axes[:, 0], (*(f"time step {step}" for step in STEPS), "path"), strict=True):
        ax.set_ylabel(label)
    ways, names = axes[2, 0].get_legend_handles_labels()
    marks = [Patch(color=_WAVE(k), ec=INK) for k in (2, 1)]
    words = ["fires in this step", "has fired; below it costs, dark is cheap"]
    figure.legend([*marks, *ways], [*words, *names], loc="outside lower center", ncols=3, fontsize=8)


def _draw_activity(wave: Wave, step: int, ax: Axes) -> None:
    """Costs in blues, dark is cheap, and the spikes over them."""
    ax.imshow(wave.cost_map.costs, cmap="Blues_r", vmin=-2, vmax=14)
    ax.imshow(wave.fired(step).astype(np.int64) + wave.firing(step), cmap=_WAVE, vmin=0, vmax=2)


EXPERIMENT = Experiment(
    "hwu2018-fig1", "spike wave at time steps 3 and 18 and paths, without and with a road", reproduce
)
