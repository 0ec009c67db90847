"""Sources of 0 V between nodes become wires."""

from circuits.circuit import Port
from netlists.read import Imported, read_netlist


def read(text: str) -> Imported:
    return read_netlist("t\n" + text)


def test_nodes_on_both_sides_of_an_ammeter_are_one() -> None:
    found = read("v1 in 0 5\nva in a\nvb a b dc 0\nr1 a c 1\nr2 b 0 1\nvc c d {x}\n.param x=0\nr3 d 0 1")
    terminals = [d.terminals() for d in found.circuit.devices]
    assert terminals == [("in", "c"), ("in", "0"), ("c", "0")]
    assert [s.name for s in found.testbench.sources] == ["v1"]
    assert "source of 0 V between two nodes, a wire in the circuit (3 times)" in str(found.notes[-1])


def test_a_port_keeps_its_name_and_two_ports_stay_two() -> None:
    found = read(".subckt s p\nv1 q p 0\nr1 q 0 1\n.ends\nx1 n s\nr1 n 0 1")
    part = found.circuit.instances[0].circuit
    assert part.ports == (Port("p", "analog"),)
    assert part.devices[0].terminals() == ("p", "0")
    two = read(".subckt s p q\nv1 p q 0\nr1 p q 1\n.ends\nx1 a b s\nr1 a b 1")
    assert [s.node for s in two.testbench.sources] == ["x1_x2e_v1_x23_value"]


def test_a_source_to_ground_or_with_a_waveform_stays_a_source() -> None:
    found = read("v1 a 0 0\nv2 a b pwl(0 0 1u 1)\nv3 a b 0 ac 1\nr1 a b 1\n.tran 1u 2u")
    assert [s.name for s in found.testbench.sources] == ["v1", "v2", "v3"]


def test_a_source_whose_current_is_taken_stays_a_source() -> None:
    found = read("v1 in 0 5\nva in a\nr1 a 0 1\nf1 0 b va 2\nr2 b 0 1")
    assert [s.name for s in found.testbench.sources] == ["v1", "va"]


def test_a_source_whose_current_or_node_is_measured_stays_a_source() -> None:
    text = "v1 in 0 5\nva in a\nx1 a s\n.subckt s p\nvb p q 0\nvc q r 0\nr1 r 0 1\n.ends\n.tran 1n 1u\n"
    assert [s.name for s in read(text).testbench.sources] == ["v1"]
    current = read(f"{text}.meas tran top max i(va)")
    assert [s.name for s in current.testbench.sources] == ["v1", "va"]
    for card in ("i(v.x1.vb)", "par('v(x1.q)*2')"):
        inside = read(f"{text}.meas tran top max {card}")
        assert [s.name for s in inside.testbench.sources] == ["v1", "x1_x2e_vb"]
