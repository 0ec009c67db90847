"""The graph has every device, every node and every terminal of a circuit, whatever it is nested in."""

from collections import Counter

import networkx as nx
import pytest

from circuits.blocks.wavefront import grid
from circuits.circuit import Circuit, Instance, InstanceArray, Port
from circuits.devices import DEVICE_TYPES, Capacitor, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.source import Constant
from circuits.lowering.graph import describe_device, to_graph, to_instance_graph
from circuits.registry import block_names, load_block

PORTS = (Port("top", "analog"), Port("out", "event", "out"))
CELL = Circuit(
    "cell",
    PORTS,
    (
        Transistor("m", "n", "inner", "inner", "out", "0", 3e-6, 1.5e-6),
        Capacitor("c", "inner", "0", 1e-12),
        Resistor("r", "top", "out", 1e3),
    ),
)
ARRAY = Circuit(
    "array",
    (Port("top", "analog"), Port("out", "event", "out", (3,))),
    (Capacitor("c", "top", "0", 2e-12),),
    (
        InstanceArray(
            "cell", CELL, (3,), {"top": "top", "out": "out"}, {"c.capacitance": (1e-12, 2e-12, 3e-12)}
        ),
    ),
)


@pytest.mark.parametrize("device_type", DEVICE_TYPES, ids=lambda t: t.__name__)
def test_every_device_type_is_described(device_type: type[Device]) -> None:
    implementation = describe_device.dispatch(device_type)
    assert implementation is not describe_device.dispatch(object), (
        f"{device_type.__name__} has no graph lowering"
    )


def test_terminals_are_as_many_as_the_device_has() -> None:
    for device in (*CELL.devices, Source("s", "top", Constant(1.0))):
        assert len(describe_device(device).terminals) == len(device.terminals())


def test_a_diode_has_two_edges_to_its_node() -> None:
    edges = to_graph(CELL).get_edge_data(("device", "m"), ("node", "inner"))
    assert sorted(e["terminal"] for e in edges.values()) == ["drain", "gate"]


def test_attributes() -> None:
    graph = to_graph(Circuit("outer", PORTS, (), (Instance("part", CELL, {"top": "top", "out": "out"}),)))
    transistor = graph.nodes["device", "part.m"]
    assert (transistor["type"], transistor["polarity"], transistor["width"]) == ("transistor", "n", 3e-6)
    assert (transistor["instance"], transistor["label"]) == ("part", "m")
    ports = {path: data["port"] for (kind, path), data in graph.nodes(data=True) if kind == "node"}
    assert ports == {"0": "ground", "top": "analog", "out": "event", "part.inner": ""}


def test_arrays_are_expanded_with_their_own_parameters() -> None:
    graph = to_graph(ARRAY)
    values = [graph.nodes["device", f"cell[{k}].c"]["capacitance"] for k in range(3)]
    assert values == [1e-12, 2e-12, 3e-12]
    assert graph.nodes["node", "out[1]"]["port"] == "event"
    assert graph.has_edge(("device", "cell[2].m"), ("node", "out[2]"))


def test_the_instance_graph_stays_on_top() -> None:
    graph = to_instance_graph(ARRAY)
    assert {path for kind, path in graph if kind == "instance"} == {"cell"}
    assert graph.nodes["instance", "cell"]["shape"] == (3,)
    edges = graph.get_edge_data(("instance", "cell"), ("node", "out"))
    assert [e["terminal"] for e in edges.values()] == ["out"]


def test_devices_that_are_alike_between_arrays_are_one_vertex() -> None:
    ports = (Port("row", "analog", "in", (3,)), Port("top", "analog"))
    wires = tuple(Resistor(f"w{k}", f"row[{k}]", "top", 1e3) for k in range(3))
    others = (
        Resistor("r", "row[0]", "top", 2e3),
        Resistor("a", "top", "0", 1e3),
        Resistor("b", "top", "0", 1e3),
    )
    graph = to_instance_graph(Circuit("wires", ports, (*wires, *others)))
    shapes = {
        path: data.get("shape", ()) for (kind, path), data in graph.nodes(data=True) if kind == "device"
    }
    assert shapes == {"w0": (3,), "r": (), "a": (), "b": ()}


def test_the_picture_of_a_large_chip_has_few_vertices() -> None:
    circuit = grid.build()
    graph = to_instance_graph(circuit)
    counts = [data.get("shape", (1,))[0] for _, data in graph.nodes(data=True) if data["kind"] == "device"]
    assert sum(counts) == len(circuit.devices) > 3000
    assert len(graph) < 30


@pytest.mark.parametrize("name", block_names())
def test_every_block(name: str) -> None:
    block = load_block(name)
    circuit = block.build()
    graph = to_graph(circuit)
    assert nx.is_bipartite(nx.Graph(graph))
    assert nx.is_connected(nx.Graph(graph))
    for vertex, data in graph.nodes(data=True):
        if data["kind"] == "device":
            terminals = Counter(e["terminal"] for _, _, e in graph.edges(vertex, data=True))
            assert set(terminals.values()) == {1}, vertex
    assert {p.name for p in circuit.ports} == {
        n.partition("[")[0]
        for (k, n), d in graph.nodes(data=True)
        if k == "node" and d["port"] not in {"", "ground"}
    }
