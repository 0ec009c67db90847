"""The chip: codes, refusals, plans of ideal cells and of a die against Dijkstra, events after the bus."""

from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from chips.aer import Bus
from chips.wavefront.axon_graph import edge_weights, graph_of
from chips.wavefront.chip import ChipCells, WavefrontChip
from chips.wavefront.model import edge_delays
from chips.wavefront.readout import UnreachableError
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

MAP = np.random.default_rng(11).integers(1, 11, (20, 20))
MISMATCHED = Silicon(AMI_1500_IDEAL, die=Die(number=1000, process=False))


def test_ideal_plan_is_dijkstra_in_units() -> None:
    chip = WavefrontChip(20, 20)
    program = chip.program(MAP)
    assert program.rounded == 0
    plan = chip.plan(program, (2, 10), (19, 10))
    graph = chip.axons
    matrix = csr_array((MAP.ravel()[graph.sources()] * 1.0, graph.targets, graph.offsets), shape=(400, 400))
    expected = dijkstra(matrix, indices=50)
    there = expected <= expected[390]
    assert (plan.arrivals.ravel() == np.where(there, expected, np.inf) * chip.unit).all()
    path = plan.path()
    assert MAP[path[:-1, 0], path[:-1, 1]].sum() == expected[390]


def test_a_die_is_dijkstra_on_its_own_delays_and_temperature_counts() -> None:
    chip = WavefrontChip(20, 20, cells=ChipCells(MISMATCHED))
    program = chip.program(MAP)
    plan = chip.plan(program, (0, 0))
    graph = chip.axons
    delays = edge_delays(graph, MAP.ravel(), MISMATCHED, bias_kind="generator")
    expected = dijkstra(csr_array((delays, graph.targets, graph.offsets), shape=(400, 400)), indices=0)
    assert (plan.arrivals.ravel() == expected).all()
    warm = chip.plan(program, (0, 0), temperature=40.0)
    own = WavefrontChip(20, 20, cells=ChipCells(replace(MISMATCHED, temperature_c=40.0))).plan(
        program, (0, 0)
    )
    assert (warm.arrivals == own.arrivals).all()
    assert not (warm.arrivals == plan.arrivals).all()
    course = np.array([0.0, 10.0]), np.array([27.0, 53.0])
    assert (chip.plan(program, (0, 0), temperature=course, time=5.0).arrivals == warm.arrivals).all()


def test_given_delays_replace_the_cells_own() -> None:
    chip = WavefrontChip(1, 3, cells=ChipCells(MISMATCHED))
    plan = chip.plan(chip.program(np.ones((1, 3))), (0, 0), delays=np.array([1.0, 2.0, 4.0, 8.0]))
    assert plan.arrivals.tolist() == [[0.0, 1.0, 3.0]]


def test_plans_know_nothing_of_each_other() -> None:
    chip = WavefrontChip(20, 20)
    program = chip.program(MAP)
    first = chip.plan(program, (0, 0), (5, 5))
    chip.plan(program, (19, 19))
    again = chip.plan(program, (0, 0), (5, 5))
    assert (again.arrivals == first.arrivals).all()
    assert (again.pointers == first.pointers).all()


def test_any_graph_is_a_chip() -> None:
    places = nx.DiGraph()
    places.add_weighted_edges_from([(0, 1, 5.0), (1, 2, 5.0), (0, 2, 12.0)])
    graph = graph_of(places)
    chip = WavefrontChip(graph=graph)
    plan = chip.plan(chip.program(np.array([4, 3, 2])), 0, 2)
    assert plan.path().tolist() == [0, 2]
    assert plan.arrivals.tolist() == [0.0, 4.0 * chip.unit, 4.0 * chip.unit]
    weighted = chip.plan(chip.program(np.ones(3)), 0, 2, delays=edge_weights(places))
    assert weighted.path().tolist() == [0, 1, 2]


def test_smaller_map_stands_in_the_first_corner() -> None:
    chip = WavefrontChip(3, 4)
    program = chip.program(np.array([[1, 2], [3, 4]]))
    assert program.codes.tolist() == [[1, 2, 0, 0], [3, 4, 0, 0], [0, 0, 0, 0]]


def test_learned_delays_are_rounded_and_counted() -> None:
    chip = WavefrontChip(1, 5)
    program = chip.write(np.array([[0.0, 0.2, 5.0, 2.5, 31.4]]))
    assert program.codes.tolist() == [[0, 1, 5, 3, 31]]
    assert program.rounded == 3


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (32, r"map\[1, 0\]: 32, must be 0 \(blocked\) to 31; scale"),
        (-1, r"map\[1, 0\]: -1, must be 0"),
        (2.5, r"map\[1, 0\]: 2.5, must be a whole number; round it"),
        (np.nan, r"map\[1, 0\]: nan, must be a whole number"),
    ],
)
def test_wrong_costs_are_refused(value: float, text: str) -> None:
    costs = np.ones((2, 2), dtype=type(value))
    costs[1, 0] = value
    with pytest.raises(ParameterError, match=text):
        WavefrontChip(2, 2).program(costs)


def test_what_does_not_fit_is_refused() -> None:
    chip = WavefrontChip(2, 3)
    with pytest.raises(ParameterError, match=r"map: 3 x 3, must fit 2 x 3 cells; cut the map"):
        chip.program(np.ones((3, 3)))
    with pytest.raises(ParameterError, match=r"map: 0 x 3, must fit"):
        chip.write(np.ones((0, 3)))
    with pytest.raises(ParameterError, match=r"map\[0, 1\]: 31.5, must be 0 \(blocked\) to 31 when rounded"):
        chip.write(np.array([[1.0, 31.5]]))
    program = chip.program(np.array([[1, 0, 1]]))
    with pytest.raises(ParameterError, match=r"plan.start: \(2, 0\), must be a cell"):
        chip.plan(program, (2, 0))
    with pytest.raises(ParameterError, match=r"plan.start: 1, must be a cell"):
        chip.plan(program, 1)
    with pytest.raises(ParameterError, match=r"plan.goal: \(0, 1\) is blocked"):
        chip.plan(program, (0, 0), (0, 1))
    with pytest.raises(ParameterError, match=r"wavefront_chip.unit: 0 s"):
        WavefrontChip(2, 2, unit=0.0)
    with pytest.raises(ParameterError, match=r"wavefront_chip.shape: 0 x 2"):
        WavefrontChip(0, 2)
    with pytest.raises(ParameterError, match=r"plan.goal: none"):
        chip.plan(program, (0, 0)).path()
    with pytest.raises(UnreachableError, match=r"\(0, 2\) has no spike from \(0, 0\)"):
        chip.plan(program, (0, 0), (0, 2)).path()


def test_events_leave_by_the_bus() -> None:
    chip = WavefrontChip(3, 3, bus=Bus(0.0, 1))
    plan = chip.plan(chip.program(np.full((3, 3), 2)), (1, 1), (0, 0))
    events = plan.events()
    assert events.addresses.tolist() == [4, 0, 1, 2, 3, 5, 6, 7, 8]
    assert events.times == pytest.approx([0.0, *[2 * chip.unit] * 8], rel=1e-12)
    slow = replace(plan, bus=Bus(1e-6, 3)).events()
    assert slow.dropped == 5
    assert slow.times == pytest.approx([1e-6, 201e-6, 202e-6, 203e-6], rel=1e-12)
