"""Circuits: names, references, hierarchy, and errors that name the offender."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import (
    Bias,
    Circuit,
    Instance,
    InstanceArray,
    Node,
    Port,
    references,
    split_reference,
)
from circuits.devices import Capacitor, Resistor, Transistor
from circuits.errors import ParameterError, TopologyError, UnknownNameError

IN, OUT = Port("a", "analog"), Port("y", "analog", "out")
LOW_PASS = Circuit("low_pass", (IN, OUT), (Resistor("r", "a", "y", 1e3), Capacitor("c", "y", "0", 1e-9)))
TWO = Circuit(
    "two",
    (IN, OUT),
    instances=(
        Instance("first", LOW_PASS, {"a": "a", "y": "m"}),
        Instance("second", LOW_PASS, {"a": "m", "y": "y"}),
    ),
)


def one(*devices: Resistor | Transistor | Capacitor, **others: object) -> Circuit:
    return Circuit("top", (IN,), devices, **others)  # type: ignore[arg-type]


def test_look_up_by_name() -> None:
    assert TWO.port("y") is OUT
    assert TWO.device("first.r").name == "r"
    assert LOW_PASS.device("c") is LOW_PASS.devices[1]
    with pytest.raises(UnknownNameError, match="two port z: unknown; known are a, y"):
        TWO.port("z")
    with pytest.raises(UnknownNameError, match="low_pass device x: unknown; known are c, r"):
        TWO.device("first.x")
    with pytest.raises(UnknownNameError, match="two bias i: unknown"):
        TWO.bias("i")


def test_an_unknown_name_is_a_lookup_error_of_one_line() -> None:
    with pytest.raises(LookupError) as caught:
        TWO.port("z")
    assert "\n" not in str(caught.value)


def test_references_are_listed_with_their_owner() -> None:
    assert list(references(LOW_PASS)) == [("r", "a"), ("r", "y"), ("c", "y"), ("c", "0")]
    assert ("second", "m") in list(references(TWO))


@pytest.mark.parametrize(
    ("text", "parts"),
    [("v", ("v", ())), ("v_mem2[3]", ("v_mem2", (3,))), ("spike[1,20]", ("spike", (1, 20)))],
)
def test_split_reference(text: str, parts: tuple[str, tuple[int, ...]]) -> None:
    assert split_reference(text) == parts


@pytest.mark.parametrize("text", ["", "2v", "v[", "v[-1]", "v[1.5]", "v[1][2]", "v mem", "1"])
def test_malformed_references_name_the_owner(text: str) -> None:
    with pytest.raises(TopologyError, match=r"^top\.r: .*not a node name"):
        one(Resistor("r", "a", text, 1e3))


@pytest.mark.parametrize("name", ["", "2r", "r-1", "r.1", "r[0]"])
def test_malformed_names(name: str) -> None:
    with pytest.raises(TopologyError, match="not a name"):
        one(Resistor(name, "a", "0", 1e3))


def test_duplicate_names_are_refused_whatever_their_case() -> None:
    with pytest.raises(TopologyError, match=r"top\.R: duplicate device or instance name"):
        one(Resistor("r", "a", "0", 1e3), Resistor("R", "a", "0", 1e3))
    with pytest.raises(TopologyError, match=r"top\.r: duplicate device or instance name"):
        one(Resistor("r", "a", "0", 1.0), instances=(Instance("r", LOW_PASS, {"a": "a", "y": "y"}),))
    with pytest.raises(TopologyError, match=r"top\.A: duplicate node name"):
        one(Resistor("r", "a", "0", 1.0), nodes=(Node("A", (2,)),))
    with pytest.raises(TopologyError, match=r"top\.b: duplicate bias name"):
        Circuit("top", (Port("p", "bias"),), biases=(Bias("b", "p", "voltage", 1.0),) * 2)


def test_a_bad_device_is_named_by_its_path() -> None:
    with pytest.raises(ParameterError, match=r"^m1\.width: -1e-06 m, must be > 0"):
        one(Transistor("m1", "n", "a", "a", "0", "0", -1e-6, 1e-6))


def test_unconnected_and_unknown_ports() -> None:
    with pytest.raises(TopologyError, match=r"top\.x\.y: unconnected port"):
        one(instances=(Instance("x", LOW_PASS, {"a": "a"}),))
    with pytest.raises(UnknownNameError, match=r"top\.x port z: unknown; known are a, y"):
        one(instances=(Instance("x", LOW_PASS, {"a": "a", "y": "b", "z": "c"}),))


def test_indices_must_lie_inside_the_shape() -> None:
    nodes = (Node("v", (2, 3)),)
    one(Resistor("r", "v[1,2]", "0", 1e3), nodes=nodes)
    for bad in ("v[2,0]", "v[0,3]", "v[0]", "a[0]"):
        with pytest.raises(TopologyError, match=r"^top\.r: .*index outside the shape"):
            one(Resistor("r", bad, "0", 1e3), nodes=nodes)
    with pytest.raises(TopologyError, match=r"top\.r: v is an array of nodes; name one element"):
        one(Resistor("r", "v", "0", 1e3), nodes=nodes)


@pytest.mark.parametrize("shape", [(0,), (3, -1)])
def test_shapes_must_be_positive(shape: tuple[int, ...]) -> None:
    with pytest.raises(TopologyError, match=r"^top\.v: shape .* every size must be at least 1"):
        one(Resistor("r", "a", "0", 1e3), nodes=(Node("v", shape),))
    connections = {"a": "a", "y": "y"}
    with pytest.raises(TopologyError, match=r"^top\.x: shape .* every size must be at least 1"):
        one(instances=(InstanceArray("x", LOW_PASS, shape, connections),))


def test_port_elements() -> None:
    assert IN.elements() == ["a"]
    assert Port("v", "analog", "in", (2, 2)).elements() == ["v[0,0]", "v[0,1]", "v[1,0]", "v[1,1]"]


def test_circuits_are_values() -> None:
    assert replace(LOW_PASS) == LOW_PASS
    assert replace(LOW_PASS, name="other") != LOW_PASS
    with pytest.raises((AttributeError, TypeError)):
        LOW_PASS.name = "x"  # type: ignore[misc]


def test_an_array_of_instances_holds_arrays_not_objects() -> None:
    array = InstanceArray("x", LOW_PASS, (4, 5), {"a": "a", "y": "y"}, {"r.resistance": np.ones((4, 5))})
    assert array.shape == (4, 5)
    assert Instance("x", LOW_PASS, {"a": "a", "y": "y"}).shape == ()


LEAK = Resistor("r", "a", "0", 1e6)


@pytest.mark.parametrize(
    ("construct", "text"),
    [
        (lambda: Port("a", "analogue"), "port a.kind: 'analogue', must be event, analog, bias or supply"),
        (lambda: Port("a", "analog", "both"), "port a.direction: 'both', must be in or out"),
        (lambda: Port(1, "analog"), "port.name: 1, must be a name"),
        (lambda: Port("a", "analog", shape=3), "port a.shape: 3, must be a tuple of whole numbers"),
        (lambda: Port("a", "analog", shape=(1.5,)), "port a.shape: .*1.5"),
        (lambda: Node("a", [3]), "node a.shape"),
        (
            lambda: Bias("i", "b", "gates", 1e-9, "m"),
            "bias i.kind: 'gates', must be gate, ideal, generator or vol",
        ),
        (lambda: Bias("i", "b", "gate", "1n", "m"), "bias i.value: '1n', must be a number in A"),
        (lambda: Bias("i", "b", "gate", 40.0, "m"), "bias i.value: 40 A, must be 1fA to 1A"),
        (lambda: Bias("i", "b", "gate", (1e-19, 1e-18), "m"), "bias i.value: 1e-18 A, must be 1fA"),
        (lambda: Bias("v", "b", "voltage", 5e3), "bias v.value: 5000 V, must be at most 1kV"),
        (lambda: Bias("v", "b", "voltage", True), "bias v.value: True, must be a number in V"),
        (lambda: Instance("x", "cell", {}), "x.circuit: 'cell', must be a circuit"),
        (lambda: Instance("x", Circuit("c"), {"a": 1}), "x.a: 1, must be the name of a node"),
        (lambda: Instance("x", Circuit("c"), {}, {"r.resistance": "1k"}), "x.r.resistance: '1k', must be"),
        (lambda: InstanceArray("x", Circuit("c"), 3, {}), "instance x.shape: 3, must be a tuple"),
        (lambda: Circuit(3), "circuit.name: 3, must be a name"),
        (lambda: Circuit("c", ("a",)), "c: 'a', must be a port"),
        (lambda: Circuit("c", (), (Port("a", "analog"),)), "c: Port.*, must be a device"),
    ],
)
def test_constructors_refuse_what_they_do_not_know(construct: Callable[[], object], text: str) -> None:
    with pytest.raises(ParameterError, match=f"^{text}") as caught:
        construct()
    assert "\n" not in str(caught.value)


def test_a_bias_that_is_off_or_meant_is_taken() -> None:
    Bias("i", "b", "gate", 0.0, "m")
    Bias("i", "b", "gate", (1e-9, 1e-18), "m")  # the tail of a bell over an array
    large = Bias("i", "b", "gate", 40.0, "m", allow_implausible=True)
    assert large == replace(large, value=40.0)
    assert "allow" not in repr(large)


@pytest.mark.parametrize("name", ["gnd", "GND", "gnd!", "ground"])
def test_ground_has_one_name(name: str) -> None:
    says = 'ground is called "0"'
    with pytest.raises(TopologyError, match=says):
        Circuit("c", (Port("a", "analog"),), (Resistor("r", "a", name, 1e6),))
    with pytest.raises(TopologyError, match=says):
        Circuit("c", (Port(name, "analog"),), (LEAK,))
    with pytest.raises(TopologyError, match=says):
        inner = Circuit("inner", (Port("a", "analog"),), (LEAK,))
        Circuit("c", (), (), (Instance("x", inner, {"a": name}),))


def test_a_negative_supply_has_a_name_of_its_own() -> None:
    circuit = Circuit("c", (Port("vss", "supply"),), (Resistor("r", "a", "vss", 1e6),))
    assert circuit.port("vss").kind == "supply"
