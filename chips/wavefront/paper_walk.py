"""The read-out of a path from the AER table that Hwu et al. (2018) describe, and its second pass.

"From the goal, the list was searched for the most recent spike from a neuron whose location was adjacent to
the goal location. If more than one spike met this criterion, the neuron whose location corresponded to the
lowest cost and was closest to the start location was chosen. This iteratively proceeded from the goal
through other neuron locations until a spike at the start location was found." A second pass then runs on a
map that is 1 on the path of the first and 20 elsewhere.

What the paper leaves open, decided here: the walk begins at the goal's first spike. "Most recent" is the
latest step before that of the spike where the walk stands, so each step goes back in time and the walk ends;
it may visit a neuron twice, because neurons fire again. Of several spikes in that step the lowest cost comes
first, then the least Euclidean distance to the start, then the lowest neighbour number. The second pass knows
no other paths than the one found. A blocked cell is blocked in both passes; costs, and the temporary map's,
are the delays D of `chips.wavefront.spiking_wavefront`.

The most recent spike of a neighbour need not be the one that caused a spike: no path of least cost is
promised.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chips.wavefront.axon_graph import NEIGHBOURS
from chips.wavefront.readout import Cell, unreachable
from chips.wavefront.spiking_wavefront import SpikeTable, run_spikes
from circuits.arrays import I64
from circuits.errors import DataError

ON_PATH, ELSEWHERE = 1, 20  # costs of the second pass's map


@dataclass(frozen=True, slots=True)
class TwoPasses:
    """Table of the first pass's spikes, and the paths of both passes, int64[n, 2].

    The second is the answer.
    """

    first_table: SpikeTable
    first_path: I64
    second_path: I64


def plan_in_two_passes(costs: NDArray[np.integer], start: Cell, goal: Cell) -> TwoPasses:
    """Plan on a map, int[rows, columns] with 0 for blocked, as the paper does.

    Raises `UnreachableError` where the goal never fires within the limit of steps of `run_spikes`.
    """
    first = run_spikes(costs, start, goal)
    path = walk(first, costs, start, goal)
    again = second_map(costs, path)
    second = run_spikes(again, start, goal)
    return TwoPasses(first, path, walk(second, again, start, goal))


def second_map(costs: NDArray[np.integer], path: I64) -> I64:
    """Return the second pass's map: 1 on the path, 20 elsewhere, 0 where blocked, int64[rows, columns]."""
    again = np.where(np.asarray(costs) > 0, ELSEWHERE, 0)
    again[path[:, 0], path[:, 1]] = ON_PATH
    return again.astype(np.int64)


def walk(table: SpikeTable, costs: NDArray[np.integer], start: Cell, goal: Cell) -> I64:
    """Return the path from start to goal by the most recent spikes of adjacent neurons, int64[n, 2].

    Raises `UnreachableError` where the goal has no spike, and `DataError` where a spike has none before it.
    """
    spikes = _by_neuron(table)
    if spikes[goal].size == 0 or spikes[start].size == 0:
        raise unreachable(start, goal)
    path, now = [goal], int(spikes[goal][0])
    while path[-1] != start:
        found = _most_recent(spikes, costs, path[-1], now, start)
        if found is None:
            raise DataError(
                f"table: the spike of {path[-1]} at step {now} has no adjacent one before it, must have;"
                " use a table without dropped events"
            )
        path.append(found[0])
        now = found[1]
    return np.array(path[::-1], dtype=np.int64)


def _by_neuron(table: SpikeTable) -> dict[Cell, I64]:
    """Steps of each neuron's spikes, rising."""
    rows, columns = table.shape
    order = np.argsort(table.neurons, kind="stable")
    ends = np.searchsorted(table.neurons[order], np.arange(rows * columns + 1))
    steps = table.steps[order]
    return {divmod(k, columns): steps[ends[k] : ends[k + 1]] for k in range(rows * columns)}


def _most_recent(
    spikes: dict[Cell, I64], costs: NDArray[np.integer], cell: Cell, now: int, start: Cell
) -> tuple[Cell, int] | None:
    """Neighbour that spiked last before step `now`, and when."""
    best: tuple[int, float, float, int] | None = None
    found: Cell | None = None
    for k, (down, right) in enumerate(NEIGHBOURS):
        near = (cell[0] + down, cell[1] + right)
        steps = spikes.get(near)
        before = 0 if steps is None else int(np.searchsorted(steps, now))
        if steps is None or before == 0:
            continue
        away = float(np.hypot(near[0] - start[0], near[1] - start[1]))
        rank = (-int(steps[before - 1]), float(costs[near]), away, k)
        if best is None or rank < best:
            best, found = rank, near
    return None if best is None or found is None else (found, -best[0])
