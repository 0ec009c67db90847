"""Graphs of NIR: read as networks node by node, written, and refused by name."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import nir
import numpy as np
import pytest
from scipy.signal import correlate2d

from chips.aer import Events
from circuits.errors import DataError, ParameterError
from system.mapping.clock import outside, with_own
from system.mapping.dynamics import asked, rates_of, run
from system.mapping.network import Connection, Network, matrix_of
from system.mapping.network_file import read_network
from system.mapping.nir.nodes import DIRECT, NODES, RATE, SHARE, SLOW, linear
from system.mapping.nir.read import Times, judged, network_of_graph, read_nir
from system.mapping.nir.write import write_nir_network

EXAMPLE = Path("examples/working-memory.toml")
RNG = np.random.default_rng(1)


def lif(n: int, **changed: Any) -> Any:
    """Neurons of 20 ms."""
    ones = np.ones(n)
    given = {"tau": 20e-3 * ones, "r": 2.0 * ones, "v_leak": 0.0 * ones, "v_threshold": 4.0 * ones}
    return nir.LIF(**{**given, **changed})


def cuba(n: int) -> Any:
    """Neurons of 20 ms with synapses of 5 ms."""
    ones = np.ones(n)
    return nir.CubaLIF(
        tau_syn=5e-3 * ones, tau_mem=20e-3 * ones, r=ones, v_leak=0.0 * ones, v_threshold=2.0 * ones, w_in=3.0
    )


def test_the_table_has_every_node_of_the_standard() -> None:
    known = {name for name in vars(nir.ir) if isinstance(getattr(nir.ir, name), type)}
    assert {node.type for node in NODES} == known - {"NIRNode", "Any", "Dict"}


def test_a_network_is_the_same_after_a_graph_where_nir_can_say_it(tmp_path: Path) -> None:
    example = read_network(EXAMPLE)
    connections = tuple(
        Connection(c.source, c.target, rule="matrix", tau=c.tau, matrix=matrix_of(example, c))  # type: ignore[arg-type]
        for c in example.connections
    )
    populations = tuple(replace(p, refractory=0.0) for p in example.populations)
    network = Network(populations, example.inputs, connections, example.probes)
    write_nir_network(tmp_path / "n.nir", network)
    assert read_nir(tmp_path / "n.nir") == network


def test_neurons_recurrence_and_graphs_in_graphs() -> None:
    weights, back = RNG.normal(size=(3, 2)), RNG.normal(size=(3, 3))
    inner = nir.NIRGraph(
        {"i": nir.Input({"input": np.array([3])}), "cells": cuba(3), "back": nir.Linear(back),
         "o": nir.Output({"output": np.array([3])})},
        [("i", "cells"), ("cells", "o"), ("cells", "back"), ("back", "cells")],
    )  # fmt: skip
    graph = nir.NIRGraph(
        {"in": nir.Input({"input": np.array([2])}), "w": nir.Linear(weights), "part": inner, "plain": lif(3),
         "out": nir.Output({"output": np.array([3])})},
        [("in", "w"), ("w", "part"), ("part", "plain"), ("plain", "out")],
    )  # fmt: skip
    found = network_of_graph(graph)
    assert {p.name: p.tau for p in found.populations} == {"part.cells": 20e-3, "plain": 20e-3}
    by_name = {c.name: c for c in found.connections}
    # R w_in / (v_threshold tau_syn), and R / (v_threshold tau) of a direct one
    assert np.array(by_name["in -> part.cells"].matrix) == pytest.approx(weights * 3.0 / (2.0 * 5e-3))
    assert np.array(by_name["part.cells -> part.cells"].matrix) == pytest.approx(back * 300.0)
    assert np.array(by_name["part.cells -> plain"].matrix) == pytest.approx(np.eye(3) * 0.5 / DIRECT)
    assert by_name["in -> part.cells"].tau == 5e-3
    assert [(p.name, p.population) for p in found.probes] == [("out", "plain")]


def test_convolutions_and_pools_are_weights() -> None:
    image, kernel = RNG.normal(size=(2, 6, 5)), RNG.normal(size=(3, 2, 3, 3))
    conv = nir.Conv2d((6, 5), kernel, 2, 1, 1, 1, np.zeros(3))
    found = linear("c", conv, image[..., None])[..., 0]
    padded = np.pad(image, ((0, 0), (1, 1), (1, 1)))
    for o in range(3):
        plain = sum(correlate2d(padded[c], kernel[o, c], "valid") for c in range(2))
        assert found[o] == pytest.approx(plain[::2, ::2])
    pool = nir.SumPool2d(np.array([2, 2]), np.array([2, 2]), np.array([0, 0]))
    assert linear("p", pool, image[..., None])[0, 0, 0, 0] == pytest.approx(image[0, :2, :2].sum())
    row = nir.Conv1d(5, kernel[:, :, 0], 1, 0, 1, 1, np.zeros(3))
    plain = sum(np.correlate(image[c, 0], kernel[0, c, 0], "valid") for c in range(2))
    assert linear("r", row, image[:, 0, :, None])[0, :, 0] == pytest.approx(plain)


def test_a_neuron_that_does_not_leak_has_a_slow_membrane() -> None:
    ones = np.ones(2)
    graph = nir.NIRGraph.from_list(nir.Linear(np.eye(2)), nir.IF(r=ones, v_threshold=ones))
    found = network_of_graph(graph)
    assert found.populations[0].tau == SLOW
    one = found.connections[0]
    assert one.tau == SHARE * SLOW > DIRECT
    assert np.array(one.matrix) == pytest.approx(np.eye(2) * SLOW / one.tau)


def rate_of(drive: float) -> float:
    """Rate of a neuron of 20 ms under a constant current in units of its threshold, Hz."""
    return 0.0 if drive <= 1.0 else 1.0 / (20e-3 * np.log(drive / (drive - 1.0)))


@pytest.mark.parametrize(("cell", "scale"), [(lif, 0.5), (cuba, 1.5)])
@pytest.mark.parametrize("times", [Times(), Times(event=1e-3)])
def test_a_bias_makes_neurons_fire_as_the_constant_current_that_it_is(
    cell: Callable[[int], Any], scale: float, times: Times
) -> None:
    """Rates of the equation under a constant current, in closed form; scale: R over the threshold, and w_in.

    Within 5 % or 3 Hz: currents stay for a step of 0.1 ms, which is 2.5 % of a synapse of 2 ms.
    """
    drives = np.array([0.5, 1.2, 1.5, 3.0, -2.0, 2.0])
    found = network_of_graph(nir.NIRGraph.from_list(nir.Affine(np.eye(6), drives / scale), cell(6)), times)
    assert [(p.name, p.size, p.rate) for p in found.inputs] == [("input", 6, 0.0), ("affine.bias", 1, RATE)]
    assert outside(found).tolist() == list(range(6))
    events = with_own(found, Events(np.empty(0), np.empty(0, np.int64)), 0.0, 4.0)
    rates = rates_of(run(asked(found), events, 4.0), 6, 1.0, 4.0)
    assert rates == pytest.approx([rate_of(drive) for drive in drives], rel=0.05, abs=3.0)


def test_a_bias_is_followed_through_what_is_linear_behind_it() -> None:
    """Through convolution, pool and weights; each node's bias counts once, however many ways lead to it."""
    kernel, bias = RNG.normal(size=(2, 1, 3, 3)), np.array([0.7, -0.4])
    weights, last = RNG.normal(size=(3, 8)), RNG.normal(size=3)
    parts = {
        "i": nir.Input({"input": np.array([1, 6, 6])}),
        "conv": nir.Conv2d((6, 6), kernel, 1, 0, 1, 1, bias),
        "pool": nir.AvgPool2d(np.array([2, 2]), np.array([2, 2]), np.array([0, 0])),
        "flat": nir.Flatten({"input": np.array([2, 2, 2])}, 0),
        "w": nir.Affine(weights, last), "lif": lif(3), "j": nir.Input({"input": np.array([1, 6, 6])}),
        "o": nir.Output({"output": np.array([3])}),
    }  # fmt: skip
    ways = [
        ("i", "conv"),
        ("conv", "pool"),
        ("pool", "flat"),
        ("flat", "w"),
        ("w", "lif"),
        ("lif", "o"),
        ("j", "conv"),
    ]
    found = network_of_graph(nir.NIRGraph(parts, ways))
    by_name = {c.name: c for c in found.connections}
    # R / (v_threshold tau_s), for events of RATE; the bias of the convolution is alike all over a plane
    for name, drive in (("conv", weights @ np.repeat(bias, 4)), ("w", last)):
        one = by_name[f"{name}.bias -> lif"]
        assert np.array(one.matrix)[:, 0] * one.tau * RATE == pytest.approx(0.5 * drive)


def test_a_network_with_a_clock_is_no_graph(tmp_path: Path) -> None:
    found = network_of_graph(nir.NIRGraph.from_list(nir.Affine(np.eye(2), np.ones(2)), lif(2)))
    with pytest.raises(ParameterError, match=r"affine.bias.rate: 500 Hz, must be 0 in a graph of NIR"):
        write_nir_network(tmp_path / "n.nir", found)


@pytest.mark.parametrize(
    ("nodes", "told"),
    [
        ((nir.Threshold(np.ones(2)),), "threshold: Threshold, is refused on rolls.*LIF"),
        ((nir.Linear(np.array([[1.0, np.inf], [0.0, 1.0]])), lif(2)), "linear.weight: inf, must be a finite"),
        ((nir.Affine(np.eye(2), np.array([np.nan, 0.0])), lif(2)), "affine.bias: nan, must be a finite"),
        ((nir.Delay(np.full(2, 1e-3)), lif(2)), "delay: Delay, is refused on rolls"),
        (
            (lif(3), nir.Linear(np.ones((2, 3)))),
            "linear: weights from lif to the output output, must be none",
        ),
        ((nir.Affine(np.eye(2), np.ones(3)), lif(2)), "affine.bias: 3 numbers, must be of 2"),
        ((lif(2, tau=np.array([1e-3, 2e-3])),), "lif.tau: 0.001 to 0.002 s, must be one"),
        ((lif(2, v_leak=-np.ones(2)),), "lif.v_reset: 1 from v_leak, must be v_leak"),
        ((lif(2, tau=np.array([1e-3, 0.0])),), "lif.tau: 0 s, must be above 0 and finite"),
        ((lif(2, tau=np.full(2, np.inf)),), "lif.tau: inf s, must be above 0 and finite"),
    ],
)
def test_what_a_network_cannot_be_is_refused_by_its_node(nodes: tuple[Any, ...], told: str) -> None:
    with pytest.raises(ParameterError, match=told):
        network_of_graph(nir.NIRGraph.from_list(*nodes))


def test_a_delay_of_0_is_none() -> None:
    weights = nir.Linear(0.02 * np.arange(1.0, 5.0).reshape(2, 2))
    plain = network_of_graph(nir.NIRGraph.from_list(weights, lif(2)))
    graph = nir.NIRGraph.from_list(weights, nir.Delay(np.zeros(2)), lif(2))
    assert network_of_graph(graph).connections == plain.connections
    assert {each.how for each in judged(graph) if each.type == "Delay"} == {"faithful"}


def test_an_output_of_two_populations_and_a_path_of_two_nodes_are_refused() -> None:
    ends = nir.Input({"input": np.array([2])}), nir.Output({"output": np.array([2])})
    graph = nir.NIRGraph(
        {"i": ends[0], "a": lif(2), "b": lif(2), "o": ends[1]},
        [("i", "a"), ("i", "b"), ("a", "o"), ("b", "o")],
    )
    with pytest.raises(ParameterError, match="o: comes from a and b, must come once, from one population"):
        network_of_graph(graph)
    inner = nir.NIRGraph({"i": ends[0], "a": lif(2), "o": ends[1]}, [("i", "a"), ("a", "o")])
    graph = nir.NIRGraph(
        {"i": ends[0], "g": inner, "g.a": lif(2), "o": ends[1]},
        [("i", "g"), ("g", "g.a"), ("g.a", "o")],
    )
    with pytest.raises(ParameterError, match=r"g\.a: is the path of two nodes, must be of one"):
        network_of_graph(graph)


def test_a_loop_without_a_neuron_and_a_file_that_is_none_are_refused(tmp_path: Path) -> None:
    ends = nir.Input({"input": np.array([2])}), nir.Output({"output": np.array([2])})
    graph = nir.NIRGraph(
        {"i": ends[0], "a": nir.Linear(np.eye(2)), "b": nir.Linear(np.eye(2)), "o": ends[1]},
        [("i", "a"), ("a", "b"), ("b", "a"), ("b", "o")],
    )
    with pytest.raises(ParameterError, match="is in a loop without a neuron"):
        network_of_graph(graph)
    path = tmp_path / "x.nir"
    path.write_bytes(b"no graph")
    with pytest.raises(DataError, match="must be a graph of NIR"):
        read_nir(path)
