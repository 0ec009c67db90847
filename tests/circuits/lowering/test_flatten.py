"""Flattening: node numbers and names, connections of arrays, parameters from outside, and a large array."""

import math
from types import MappingProxyType

import numpy as np
import pytest

from circuits.circuit import Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Capacitor, Resistor, Transistor
from circuits.errors import ParameterError, TopologyError, UnknownNameError
from circuits.lowering.flatten import DeviceGroup, FlatCircuit, flatten

LOW_PASS = Circuit(
    "low_pass",
    (Port("a", "analog"), Port("y", "analog", "out")),
    (Resistor("r", "a", "m", 1e3), Resistor("s", "m", "y", 2e3), Capacitor("c", "y", "0", 1e-9)),
)
PAIR = Circuit(
    "pair",
    (Port("a", "analog"), Port("y", "analog", "out", (2,))),
    instances=(
        InstanceArray("low", LOW_PASS, (2,), {"a": "a", "y": "y"}, {"r.resistance": (10.0, 20.0)}),
        Instance("last", LOW_PASS, {"a": "y[1]", "y": "0"}, {"c.capacitance": 5e-9}),
    ),
)
MANY = 131_072


def array(shape: tuple[int, ...], parameters: object = MappingProxyType({}), **connections: str) -> Circuit:
    nodes = {"y": "y", "a": "a", **connections}
    return Circuit(
        "top",
        (Port("a", "analog"), Port("y", "analog", "out", (3, 2))),
        instances=(InstanceArray("x", PAIR, shape, nodes, parameters),),  # type: ignore[arg-type]
    )


def group(flat: FlatCircuit, path: str, device: str) -> DeviceGroup:
    found = [g for g in flat.groups if ".".join(n for n, _ in g.path) == path and g.device.name == device]
    assert len(found) == 1
    return found[0]


def test_every_name_leads_back_to_its_number() -> None:
    flat = flatten(array((3,)))
    names = flat.node_names()
    assert names[0] == "0"
    assert len(set(names)) == flat.count == len(names)
    assert [flat.node(name) for name in names] == list(range(flat.count))
    assert [flat.node_name(k) for k in range(flat.count)] == names


def test_paths_of_nodes_and_devices() -> None:
    flat = flatten(array((3,)))
    assert {"a", "y[2,1]", "x[0].low[1].m", "x[2].last.m"} <= set(flat.node_names())
    low = group(flat, "x.low", "r")
    assert [low.label(k) for k in (0, 3, 5)] == ["x[0].low[0].r", "x[1].low[1].r", "x[2].low[1].r"]
    assert group(flat, "x.last", "c").label(1) == "x[1].last.c"


def test_connections_reach_the_right_places() -> None:
    flat = flatten(array((3,)))
    low, last = group(flat, "x.low", "s"), group(flat, "x.last", "r")
    for i in range(3):
        for j in range(2):
            k = 2 * i + j
            assert [flat.node_name(int(n)) for n in low.nodes[:, k]] == [f"x[{i}].low[{j}].m", f"y[{i},{j}]"]
        assert flat.node_name(int(last.nodes[0, i])) == f"y[{i},1]"
    assert (group(flat, "x.last", "c").nodes == 0).all()
    assert (group(flat, "x.low", "r").nodes[0] == flat.node("a")).all()


def test_parameters_broadcast_from_outside_and_the_outermost_wins() -> None:
    inner = flatten(array((3,)))
    assert group(inner, "x.low", "r").parameters["resistance"].tolist() == [10.0, 20.0] * 3
    assert group(inner, "x.low", "s").parameters["resistance"].tolist() == [2e3] * 6
    assert group(inner, "x.last", "c").parameters["capacitance"].tolist() == [5e-9] * 3
    outer = flatten(array((3,), {"low.r.resistance": (1.0, 2.0, 3.0), "last.c.capacitance": 7e-9}))
    assert group(outer, "x.low", "r").parameters["resistance"].tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    assert group(outer, "x.last", "c").parameters["capacitance"].tolist() == [7e-9] * 3


def test_an_unknown_parameter_is_named() -> None:
    for bad in ("low.r.resistivity", "low.q.resistance", "high.r.resistance", "resistance"):
        with pytest.raises(UnknownNameError, match=r"parameter .* unknown; .*known are"):
            flatten(array((3,), {bad: 1.0}))


def test_parameters_that_do_not_broadcast_are_named() -> None:
    with pytest.raises(
        ParameterError, match=r"x\.low\.r\.resistance: values of shape \(2,\), must broadcast"
    ):
        flatten(array((3,), {"low.r.resistance": (1.0, 2.0)}))


@pytest.mark.parametrize("bad", [-1.0, 0.0, math.nan, math.inf])
def test_a_bad_size_in_an_array_is_named_by_its_instance_path(bad: float) -> None:
    with pytest.raises(ParameterError, match=r"^x\[1\]\.low\[0\]\.r\.resistance: .* Ohm, must be > 0"):
        flatten(array((3,), {"low.r.resistance": (1.0, bad, 3.0)}))


def test_nodes_that_do_not_broadcast_are_named() -> None:
    with pytest.raises(TopologyError, match=r"^x\.y: y of shape \(3, 2\) does not broadcast to \(4, 2\)"):
        flatten(array((4,)))
    wide = Circuit("wide", (Port("a", "analog", shape=(2,)),), (Resistor("r", "a[0]", "a[1]", 1.0),))
    with pytest.raises(TopologyError, match=r"x\.a: n of shape \(\) does not broadcast|declare the node"):
        flatten(Circuit("t", nodes=(Node("n", (3,)),), instances=(Instance("x", wide, {"a": "n"}),)))


def test_one_shared_node_serves_a_whole_array() -> None:
    flat = flatten(array((3,), a="0"))
    assert (group(flat, "x.low", "r").nodes[0] == 0).all()


def test_port_nodes() -> None:
    flat = flatten(array((3,)))
    assert flat.port_nodes("y").size == 6
    assert [flat.node_name(int(n)) for n in flat.port_nodes("y[2,0]")] == ["y[2,0]"]
    with pytest.raises(UnknownNameError, match="top port q: unknown; known are a, y"):
        flat.port_nodes("q")
    with pytest.raises(TopologyError, match=r"y\[3,0\]: index outside"):
        flat.port_nodes("y[3,0]")


@pytest.mark.parametrize(
    "path", ["b", "x.low.m", "x[0].low[2].m", "x[0].low[0]", "y[0]", "a[0]", "x[3].last.m"]
)
def test_unknown_nodes_are_refused(path: str) -> None:
    with pytest.raises(UnknownNameError, match=r"top node .* unknown"):
        flatten(array((3,))).node(path)


def test_a_large_array_costs_arrays_not_objects() -> None:
    synapse = Circuit(
        "synapse",
        (Port("pre", "event"), Port("out", "analog", "out"), Port("v_w", "bias")),
        (
            Transistor("m1", "n", "x", "pre", "0", "0", 3e-6, 1.5e-6),
            Transistor("m2", "n", "out", "v_w", "x", "0", 3e-6, 1.5e-6),
            Capacitor("c", "out", "0", 1e-13),
        ),
    )
    shape = (256, 512)
    top = Circuit(
        "array",
        (Port("pre", "event", shape=(512,)), Port("out", "analog", "out", (256, 1)), Port("v_w", "bias")),
        instances=(
            InstanceArray(
                "synapse",
                synapse,
                shape,
                {"pre": "pre", "out": "out", "v_w": "v_w"},
                {"m2.width": np.full(shape, 6e-6)},
            ),
        ),
    )
    flat = flatten(top)
    assert [g.nodes.shape for g in flat.groups] == [(4, MANY), (4, MANY), (2, MANY)]
    assert len(flat.blocks) == 4  # three ports and x: nothing was made per instance
    assert flat.count == 1 + 512 + 256 + 1 + MANY
    assert flat.groups[1].parameters["width"].shape == (MANY,)
    number = flat.node("synapse[255,511].x")
    assert flat.node_name(number) == "synapse[255,511].x"
    assert number == flat.groups[0].nodes[0, -1]
    assert flat.groups[0].label(MANY - 1) == "synapse[255,511].m1"
    assert flat.node_name(int(flat.groups[0].nodes[1, 513])) == "pre[1]"
    assert flat.node_name(int(flat.groups[1].nodes[0, 513])) == "out[1,0]"
    assert flat.node_names()[number] == "synapse[255,511].x"
