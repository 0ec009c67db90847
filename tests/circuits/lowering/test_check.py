"""Checks: each kind of wiring error is found and its offender named; sound circuits pass."""

import pytest

from circuits import devices
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, Instance, InstanceArray, Node, Port
from circuits.devices.source import Constant
from circuits.errors import TopologyError
from circuits.lowering.check import check_circuit
from circuits.lowering.kernel import to_kernel
from circuits.testbench import Testbench
from tests.circuits.soundness import fault

SUPPLY, IN = Port("vdd", "supply"), Port("a", "analog")


def top(*parts: devices.Device, nodes: tuple[Node, ...] = (), ports: tuple[Port, ...] = (SUPPLY,)) -> Circuit:
    return Circuit("top", ports, parts, nodes=nodes)


def nfet(name: str, drain: str, gate: str, source: str) -> devices.Transistor:
    return devices.Transistor(name, "n", drain, gate, source, "0", 3e-6, 3e-6)


LOAD = devices.Resistor("load", "vdd", "0", 1e3)


def test_a_sound_circuit_passes() -> None:
    assert fault(rebound_neuron.build()) == ""
    assert fault(top(LOAD, nfet("m1", "vdd", "g", "0"), devices.Resistor("r", "g", "vdd", 1e3))) == ""


def test_a_floating_gate_is_named_by_device_and_node() -> None:
    with pytest.raises(TopologyError, match=r"^m1\.gate: floating gate, node g has no path"):
        check_circuit(top(LOAD, nfet("m1", "vdd", "g", "0")))


def test_a_gate_on_a_capacitor_floats() -> None:
    with pytest.raises(TopologyError, match=r"^m1\.gate: floating gate"):
        check_circuit(top(LOAD, nfet("m1", "vdd", "g", "0"), devices.Capacitor("c", "g", "0", 1e-12)))


def test_a_floating_gate_in_an_array_is_named_by_its_path() -> None:
    inner = Circuit("inner", (IN, SUPPLY), (nfet("m1", "vdd", "a", "0"), LOAD))
    array = InstanceArray("x", inner, (3,), {"a": "g", "vdd": "vdd"})
    drive = tuple(devices.Resistor(f"r{i}", f"g[{i}]", "vdd", 1e3) for i in (0, 2))
    with pytest.raises(TopologyError, match=r"^x\[1\]\.m1\.gate: floating gate, node g\[1\] has no path"):
        check_circuit(Circuit("top", (SUPPLY,), drive, (array,), (Node("g", (3,)),)))


def test_a_node_without_a_path_for_direct_current_is_named() -> None:
    with pytest.raises(TopologyError, match=r"^m: no path for direct current to ground or a supply"):
        check_circuit(
            top(LOAD, devices.Capacitor("c1", "vdd", "m", 1e-12), devices.Capacitor("c2", "m", "0", 1e-12))
        )


def test_two_nodes_that_only_see_each_other_have_no_path() -> None:
    with pytest.raises(TopologyError, match="no path for direct current"):
        check_circuit(
            top(LOAD, devices.Resistor("r", "m", "n", 1e3), devices.Capacitor("c", "m", "0", 1e-12))
        )


def test_a_controlled_source_gives_no_path_and_an_amplifier_does() -> None:
    with pytest.raises(TopologyError, match=r"^m: no path"):
        check_circuit(top(LOAD, devices.ControlledSource("g", "m", "0", "vdd", "0", 1e-3)))
    assert fault(top(LOAD, devices.OperationalAmplifier("x", "vdd", "m", "m", "vdd"))) == ""


def test_a_path_through_a_transistor_s_channel_counts() -> None:
    assert fault(top(LOAD, nfet("m1", "m", "vdd", "0"))) == ""


def test_an_output_port_needs_a_path_of_its_own_an_input_does_not() -> None:
    gate = nfet("m1", "vdd", "a", "0")
    assert fault(top(LOAD, gate, ports=(SUPPLY, IN))) == ""
    with pytest.raises(TopologyError, match=r"^m1\.gate: floating gate, node a"):
        check_circuit(top(LOAD, gate, ports=(SUPPLY, Port("a", "analog", "out"))))


def test_a_port_that_nothing_uses_is_named() -> None:
    with pytest.raises(TopologyError, match=r"^top\.a: unconnected port; nothing inside uses it"):
        check_circuit(top(LOAD, ports=(SUPPLY, IN)))
    wide = Port("a", "analog", shape=(2,))
    with pytest.raises(TopologyError, match=r"^top\.a\[1\]: unconnected port"):
        check_circuit(top(LOAD, devices.Resistor("r", "a[0]", "0", 1.0), ports=(SUPPLY, wide)))


def test_an_element_of_a_node_array_that_nothing_uses_is_named() -> None:
    with pytest.raises(TopologyError, match=r"^v\[1\]: unconnected node"):
        check_circuit(top(LOAD, devices.Resistor("r", "v[0]", "0", 1.0), nodes=(Node("v", (2,)),)))


def test_a_source_inside_a_circuit_is_named() -> None:
    inner = Circuit(
        "inner", (IN,), (devices.Resistor("r", "a", "0", 1.0), devices.Source("v1", "a", Constant(1.0)))
    )
    outer = Circuit("outer", (IN,), (), (Instance("x", inner, {"a": "a"}),))
    with pytest.raises(TopologyError, match=r"^x\.v1: a source stands in a circuit; put it in the testbench"):
        to_kernel(Testbench("t", outer, (), 1.0))


def test_the_lowering_checks_with_what_the_testbench_drives() -> None:
    circuit = top(LOAD, nfet("m1", "vdd", "a", "0"), ports=(SUPPLY, IN))
    supply, gate = devices.Source("vdd", "vdd", Constant(5.0)), devices.Source("a", "a", Constant(1.0))
    to_kernel(Testbench("t", circuit, (supply, gate), 1.0))
    with pytest.raises(TopologyError, match="floating gate, node a"):
        to_kernel(Testbench("t", circuit, (supply,), 1.0))
