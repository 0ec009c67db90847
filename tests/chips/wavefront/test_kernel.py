"""Waves against scipy's Dijkstra: arrivals at every cell, pointers, ties, goals and blocked cells.

Arrivals must be equal to the bit: both sides add the same delays in the same order, and take the least.
"""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from chips.wavefront.axon_graph import AxonGraph, edge_weights, graph_of, grid_graph
from chips.wavefront.kernel import Wave, graph_wave, graph_waves, integer_wave, real_wave
from chips.wavefront.wave.integer import HIGHEST_COST, spread, work_size
from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError

FEW = settings(max_examples=60, deadline=None)
shapes = st.tuples(st.integers(1, 9), st.integers(1, 9))
seeds = st.integers(0, 2**32 - 1)


def _draw(shape: tuple[int, int], seed: int, highest: int) -> tuple[I64, tuple[int, int]]:
    """A map with about a fifth of its cells blocked, and a start that may be blocked, too."""
    draw = np.random.default_rng(seed)
    costs = draw.integers(1, highest + 1, shape) * (draw.random(shape) > 0.2)
    return costs, (int(draw.integers(shape[0])), int(draw.integers(shape[1])))


def _distances(graph: AxonGraph, delays: F64, start: int, blocked: Bools) -> F64:
    if blocked[start]:
        return np.full(graph.cells, np.inf)
    sources = graph.sources()
    open_ = ~blocked[sources] & ~blocked[graph.targets] & np.isfinite(delays)
    pairs = sources[open_], graph.targets[open_]
    matrix = csr_array((delays[open_], pairs), shape=(graph.cells, graph.cells))
    return np.asarray(dijkstra(matrix, indices=start))


def _check_pointers(graph: AxonGraph, delays: F64, wave: Wave, start: int) -> None:
    """Each pointer is the lowest input whose spike came at the arrival; ties are counted by hand."""
    arrivals, pointers = wave.arrivals.ravel(), wave.pointers.ravel()
    came: list[list[int]] = [[] for _ in range(graph.cells)]
    for j, i, k, delay in zip(graph.sources(), graph.targets, graph.inputs, delays, strict=True):
        if np.isfinite(arrivals[j]) and np.isfinite(arrivals[i]) and arrivals[j] + delay == arrivals[i]:
            came[i].append(int(k))
    expected = [min(each) if each and i != start else -1 for i, each in enumerate(came)]
    assert pointers.tolist() == expected
    assert wave.ties == sum(len(each) > 1 for each in came)


@FEW
@given(shapes, seeds, st.sampled_from([1, 3, 31, 4095]))
def test_integer_wave_is_dijkstra(shape: tuple[int, int], seed: int, highest: int) -> None:
    costs, start = _draw(shape, seed, highest)
    graph, flat, number = grid_graph(*shape), costs.ravel(), start[0] * shape[1] + start[1]
    delays = np.where(flat > 0, flat, np.inf)[graph.sources()]
    wave = integer_wave(costs, start)
    assert (wave.arrivals.ravel() == _distances(graph, delays, number, flat == 0)).all()
    _check_pointers(graph, delays, wave, number)
    for other in (
        real_wave(np.where(costs > 0, costs, np.inf), start),
        graph_wave(graph, delays, number, blocked=flat == 0),
    ):
        assert (other.arrivals.ravel() == wave.arrivals.ravel()).all()
        assert (other.pointers.ravel() == wave.pointers.ravel()).all()
        assert other.ties == wave.ties


@pytest.mark.parametrize("highest", [1, 2, 3, 4, 31, 32, 4094, HIGHEST_COST])
def test_an_integer_wave_writes_its_working_space_alone(highest: int) -> None:
    costs = np.full((5, 7), highest)
    needed = work_size(*costs.shape)
    work = np.full(needed + 2 * HIGHEST_COST, 12345, np.int32)
    spread(costs, work[:needed], np.empty(costs.shape), np.empty(costs.shape, np.int8), 0, -1)
    assert (work[needed:] == 12345).all()


@FEW
@given(shapes, seeds, st.sampled_from([0.05, 0.5, 3.0, 8.0]))
def test_real_wave_is_dijkstra(shape: tuple[int, int], seed: int, sigma: float) -> None:
    costs, start = _draw(shape, seed, 31)
    spread = np.exp(sigma * np.random.default_rng(seed).standard_normal(shape))
    senders = np.where(costs > 0, 1e-4 * costs * spread, np.inf)  # 8.0 is too wide for buckets: a heap
    graph, flat, number = grid_graph(*shape), costs.ravel(), start[0] * shape[1] + start[1]
    delays = senders.ravel()[graph.sources()]
    wave = real_wave(senders, start)
    assert (wave.arrivals.ravel() == _distances(graph, delays, number, flat == 0)).all()
    _check_pointers(graph, delays, wave, number)


@FEW
@given(st.integers(1, 30), seeds, st.sampled_from([0.05, 0.5, 3.0, 8.0]), st.booleans())
def test_graph_wave_is_dijkstra(cells: int, seed: int, sigma: float, whole: bool) -> None:
    draw = np.random.default_rng(seed)
    graph = graph_of(nx.gnp_random_graph(cells, 0.2, seed=seed, directed=True))
    delays = np.exp(sigma * draw.standard_normal(graph.edges))
    delays = np.ceil(delays) if whole else delays
    delays[draw.random(graph.edges) < 0.05] = np.inf
    blocked, start = draw.random(cells) < 0.1, int(draw.integers(cells))
    wave = graph_wave(graph, delays, start, blocked=blocked)
    assert (wave.arrivals == _distances(graph, delays, start, blocked)).all()
    _check_pointers(graph, delays, wave, start)


@FEW
@given(shapes, seeds, st.sampled_from(["integer", "real", "edges", "heap"]))
def test_goal_stops_the_wave_at_its_spike(shape: tuple[int, int], seed: int, form: str) -> None:
    costs, start = _draw(shape, seed, 5)
    draw = np.random.default_rng(seed + 1)
    goal = int(draw.integers(shape[0])), int(draw.integers(shape[1]))
    graph, columns = grid_graph(*shape), shape[1]
    first, last = start[0] * columns + start[1], goal[0] * columns + goal[1]
    senders = np.where(costs > 0, costs, np.inf) * (
        1e-9 ** draw.integers(0, 2, shape) if form == "heap" else 1
    )
    if form == "integer":
        whole, part = integer_wave(costs, start), integer_wave(costs, start, goal)
    elif form == "edges":
        delays = senders.ravel()[graph.sources()] + draw.random(graph.edges)
        whole, part = (graph_wave(graph, delays, first, g, costs.ravel() == 0) for g in (None, last))
    else:
        whole, part = real_wave(senders, start), real_wave(senders, start, goal)
    arrivals, pointers = whole.arrivals.ravel(), whole.pointers.ravel()
    there = np.isfinite(arrivals) & (arrivals <= arrivals[last])
    assert (part.arrivals.ravel() == np.where(there, arrivals, np.inf)).all()
    assert (part.pointers.ravel() == np.where(there, pointers, -1)).all()


def test_large_grid_is_dijkstra() -> None:
    draw = np.random.default_rng(5)
    costs = draw.integers(0, 11, (120, 150))
    costs[60, 75] = 1
    graph, start = grid_graph(120, 150), 60 * 150 + 75
    delays = np.where(costs > 0, costs, np.inf).ravel()[graph.sources()]
    blocked = costs.ravel() == 0
    expected = _distances(graph, delays, start, blocked)
    assert (integer_wave(costs, (60, 75)).arrivals.ravel() == expected).all()
    delays *= np.exp(0.1 * draw.standard_normal(graph.edges))
    assert (
        graph_wave(graph, delays, start, blocked=blocked).arrivals
        == _distances(graph, delays, start, blocked)
    ).all()


def test_dies_are_planned_alike_by_any_number_of_threads() -> None:
    draw = np.random.default_rng(6)
    graph = grid_graph(8, 9)
    delays = draw.uniform(1.0, 9.0, (7, graph.edges))
    delays[3] **= 9.0  # too wide for buckets
    alone, shared = (graph_waves(graph, delays, 0, 71, threads=k) for k in (1, 3))
    for a, b in zip(alone, shared, strict=True):
        assert (a == b).all()
    for die in range(7):
        wave = graph_wave(graph, delays[die], 0, 71)
        assert (wave.arrivals == alone.arrivals[die]).all()
        assert (wave.pointers == alone.pointers[die]).all()


@pytest.mark.parametrize("goal", [None, (0, 0)])
def test_one_cell(goal: tuple[int, int] | None) -> None:
    for wave in (integer_wave(np.array([[3]]), (0, 0), goal), real_wave(np.array([[3.0]]), (0, 0), goal)):
        assert (wave.arrivals[0, 0], wave.pointers[0, 0], wave.ties) == (0.0, -1, 0)


def test_start_as_goal_fires_alone() -> None:
    wave = integer_wave(np.ones((3, 3), dtype=np.int64), (1, 1), (1, 1))
    assert np.isfinite(wave.arrivals).sum() == 1
    assert wave.arrivals[1, 1] == 0.0


def test_blocked_start_fires_nothing_and_blocked_goal_stops_nothing() -> None:
    costs = np.array([[0, 1, 1]])
    assert np.isinf(integer_wave(costs, (0, 0)).arrivals).all()
    assert integer_wave(costs, (0, 2), (0, 0)).arrivals.tolist() == [[np.inf, 1.0, 0.0]]
    delays = np.where(costs > 0, costs, np.inf)
    assert np.isinf(real_wave(delays, (0, 0)).arrivals).all()
    assert real_wave(delays, (0, 2), (0, 0)).arrivals.tolist() == [[np.inf, 1.0, 0.0]]


def test_corners_do_not_touch_across_the_edge_of_the_grid() -> None:
    costs = np.ones((3, 4), dtype=np.int64)
    costs[:, 1:3] = 0
    arrivals = integer_wave(costs, (1, 0)).arrivals
    assert np.isinf(arrivals[:, 1:]).all()
    assert np.isfinite(arrivals[:, 0]).all()


def test_wrong_input_is_refused() -> None:
    ones = np.ones((2, 3), dtype=np.int64)
    with pytest.raises(ParameterError, match=r"plan.start: \(2, 0\), must be on the grid of 2 x 3"):
        integer_wave(ones, (2, 0))
    with pytest.raises(ParameterError, match=r"costs: float64 with 2 dimensions, must be integers"):
        integer_wave(ones * 1.5, (0, 0))
    with pytest.raises(ParameterError, match=r"delays: float64 with 1 dimensions, must be numbers with 2"):
        real_wave(np.ones(3), (0, 0))
    with pytest.raises(ParameterError, match=r"plan.goal: \(0, -1\)"):
        real_wave(ones * 1.0, (0, 0), (0, -1))
    for wrong in (-1, 4096, 2**32 + 1):
        costs = ones.copy()
        costs[1, 2] = wrong
        with pytest.raises(ParameterError, match=rf"costs\[1, 2\]: {wrong}, must be 0 to 4095"):
            integer_wave(costs, (0, 0))
    for delay in (0.0, -1.0, np.nan):
        with pytest.raises(ParameterError, match=r"delays\[0, 1\]: .*, must be > 0"):
            real_wave(np.array([[1.0, delay]]), (0, 0))
        with pytest.raises(ParameterError, match=r"delays\[1\]: .*, must be > 0"):
            graph_wave(grid_graph(1, 2), np.array([1.0, delay]), 0)
    with pytest.raises(ParameterError, match=r"plan.delays: 3 on a die, must be 2"):
        graph_wave(grid_graph(1, 2), np.ones(3), 0)
    with pytest.raises(ParameterError, match=r"plan.goal: cell 2, must be 0 to 1"):
        graph_wave(grid_graph(1, 2), np.ones(2), 0, 2)


def test_edge_weights_of_a_networkx_graph_are_its_shortest_paths() -> None:
    places = nx.gnp_random_graph(40, 0.15, seed=2, directed=True)
    draw = np.random.default_rng(2)
    for a, b in places.edges:
        places.edges[a, b]["weight"] = float(draw.uniform(1.0, 50.0))
    wave = graph_wave(graph_of(places), edge_weights(places), 0)
    expected = nx.single_source_dijkstra_path_length(places, 0)
    assert wave.arrivals.tolist() == [expected.get(k, np.inf) for k in range(40)]
