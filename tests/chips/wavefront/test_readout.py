"""Paths read by pointers and by a causal walk cost what Dijkstra's cost; what cannot be read is an error."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.wavefront.axon_graph import graph_of
from chips.wavefront.kernel import graph_wave, integer_wave, real_wave
from chips.wavefront.readout import (
    UnreachableError,
    pointer_nodes,
    pointer_path,
)
from circuits.arrays import I64
from circuits.errors import DataError

FEW = settings(max_examples=60, deadline=None)
seeds = st.integers(0, 2**32 - 1)


def _is_walk(path: I64, start: tuple[int, int], goal: tuple[int, int]) -> bool:
    steps = np.abs(np.diff(path, axis=0)).max(axis=1, initial=0)
    return tuple(path[0]) == start and tuple(path[-1]) == goal and bool((steps == 1).all())


@FEW
@given(st.tuples(st.integers(1, 9), st.integers(1, 9)), seeds, st.sampled_from([0.0, 0.3]))
def test_grid_paths_are_optimal(shape: tuple[int, int], seed: int, sigma: float) -> None:
    draw = np.random.default_rng(seed)
    costs = draw.integers(1, 6, shape) * (draw.random(shape) > 0.2)
    start = int(draw.integers(shape[0])), int(draw.integers(shape[1]))
    goal = int(draw.integers(shape[0])), int(draw.integers(shape[1]))
    costs[start] = 1
    delays = np.where(costs > 0, costs, np.inf) * np.exp(sigma * draw.standard_normal(shape))
    wave = integer_wave(costs, start, goal) if sigma == 0.0 else real_wave(delays, start, goal)
    if np.isinf(wave.arrivals[goal]):
        with pytest.raises(UnreachableError):
            pointer_path(wave.pointers, start, goal)
        return
    path = pointer_path(wave.pointers, start, goal)
    assert _is_walk(path, start, goal)
    taken = delays[path[:-1, 0], path[:-1, 1]].sum()
    assert taken == pytest.approx(wave.arrivals[goal], rel=1e-12)  # sums of at most 81 delays, rounded


@FEW
@given(st.integers(1, 25), seeds)
def test_graph_paths_are_optimal(cells: int, seed: int) -> None:
    draw = np.random.default_rng(seed)
    graph = graph_of(nx.gnp_random_graph(cells, 0.2, seed=seed, directed=True))
    delays = draw.integers(1, 5, graph.edges) * 1.0
    start, goal = (int(k) for k in draw.integers(0, cells, 2))
    wave = graph_wave(graph, delays, start, goal)
    if np.isinf(wave.arrivals[goal]):
        with pytest.raises(UnreachableError):
            pointer_nodes(graph, wave.pointers, start, goal)
        return
    pairs = zip(graph.sources().tolist(), graph.targets.tolist(), strict=True)
    by_pair = dict(zip(pairs, delays.tolist(), strict=True))
    path = pointer_nodes(graph, wave.pointers, start, goal)
    assert (path[0], path[-1]) == (start, goal)
    taken = sum(by_pair[a, b] for a, b in zip(path[:-1].tolist(), path[1:].tolist(), strict=True))
    assert taken == wave.arrivals[goal]


def test_pointers_that_lead_round_are_refused() -> None:
    pointers = np.array([[2, 6]], dtype=np.int8)  # each names the other
    with pytest.raises(DataError):
        pointer_path(np.array([[2, 6, -1]], dtype=np.int8), (0, 2), (0, 0))
    assert pointer_path(pointers, (0, 0), (0, 1)).tolist() == [[0, 0], [0, 1]]


def test_start_as_goal_is_its_own_path() -> None:
    wave = integer_wave(np.array([[2]]), (0, 0), (0, 0))
    assert pointer_path(wave.pointers, (0, 0), (0, 0)).tolist() == [[0, 0]]
