"""The paper's walk: most recent adjacent spike, its tie rules, its second pass."""

import numpy as np
import pytest

from chips.wavefront.paper_walk import plan_in_two_passes, second_map, walk
from chips.wavefront.readout import UnreachableError
from chips.wavefront.spiking_wavefront import SpikeTable, run_spikes
from circuits.errors import DataError


def _table(events: list[tuple[int, int]], shape: tuple[int, int]) -> SpikeTable:
    """Events are (step, neuron)."""
    steps, neurons = np.array(events, dtype=np.int64).T
    return SpikeTable(neurons, steps, shape, int(steps.max()))


def test_most_recent_adjacent_spike_wins() -> None:
    table = _table([(0, 0), (3, 1), (4, 3), (6, 4)], (2, 3))  # 3 is below 0, 4 is the goal
    costs = np.ones((2, 3), dtype=np.int64)
    assert walk(table, costs, (0, 0), (1, 1)).tolist() == [[0, 0], [0, 1], [1, 0], [1, 1]]


def test_ties_go_to_the_lowest_cost_then_to_the_nearest_to_the_start() -> None:
    events = [(0, 0), (5, 1), (5, 3), (5, 5), (9, 4)]
    costs = np.array([[1, 2, 9], [3, 1, 2]])
    assert walk(_table(events, (2, 3)), costs, (0, 0), (1, 1)).tolist() == [[0, 0], [0, 1], [1, 1]]
    costs[1, 0] = 1
    assert walk(_table(events, (2, 3)), costs, (0, 0), (1, 1)).tolist() == [[0, 0], [1, 0], [1, 1]]


def test_walk_ends_on_any_map() -> None:
    for seed in range(20):
        draw = np.random.default_rng(seed)
        costs = draw.integers(1, 6, (9, 9))
        costs[draw.random((9, 9)) < 0.1] = 0
        costs[0, 0] = costs[8, 8] = 1
        table = run_spikes(costs, (0, 0), (8, 8))
        if not (table.neurons == 80).any():
            continue
        path = walk(table, costs, (0, 0), (8, 8))
        assert (path[0].tolist(), path[-1].tolist()) == ([0, 0], [8, 8])
        assert (np.abs(np.diff(path, axis=0)).max(axis=1) == 1).all()
        assert len(path) <= table.last + 1


def test_second_pass_keeps_to_the_first_path() -> None:
    costs = np.full((7, 7), 4)
    costs[3, :] = 1
    found = plan_in_two_passes(costs, (1, 0), (1, 6))
    assert {tuple(c) for c in found.second_path} <= {tuple(c) for c in found.first_path}
    assert len(found.second_path) <= len(found.first_path)


def test_second_map_is_1_on_the_path_and_20_elsewhere() -> None:
    again = second_map(np.array([[3, 0], [2, 9]]), np.array([[0, 0], [1, 1]]))
    assert again.tolist() == [[1, 0], [20, 1]]


def test_unreachable_goals_and_lost_events_are_told() -> None:
    costs = np.array([[1, 0, 1]])
    with pytest.raises(UnreachableError, match=r"\(0, 2\) has no spike from \(0, 0\)"):
        plan_in_two_passes(costs, (0, 0), (0, 2))
    with pytest.raises(DataError, match=r"\(0, 1\) at step 4 has no adjacent one"):
        walk(_table([(4, 1), (6, 2), (9, 0)], (1, 3)), np.ones((1, 3)), (0, 0), (0, 2))


def test_start_as_goal_is_its_own_path() -> None:
    assert plan_in_two_passes(np.ones((2, 2), dtype=np.int64), (0, 0), (0, 0)).second_path.tolist() == [
        [0, 0]
    ]
