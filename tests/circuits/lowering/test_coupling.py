"""Coupling by a layout's rule: which nodes, how much, and the same in solver and netlist."""

import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Transistor
from circuits.errors import ParameterError
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.coupling import COUPLINGS, STYLES, coupled
from circuits.registry import load_block
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from netlists.read import read_netlist
from netlists.registry import Settings, load_dialect
from tests.refusals import refusals

UM = 1e-6
BUS = STYLES["bus"]


def cell(name: str = "m") -> Circuit:
    ports = (
        Port("vdd", "supply"),
        Port("a", "event"),
        Port("y", "event", "out"),
        Port("w", "analog", shape=(2,)),
    )
    devices = (
        Transistor(f"{name}p", "p", "y", "a", "vdd", "vdd", 6 * UM, 2 * UM),
        Transistor(f"{name}n", "n", "y", "a", "0", "0", 3 * UM, 2 * UM),
        Transistor(f"{name}x", "n", "y", "inner", "0", "0", 3 * UM, 2 * UM),
        Capacitor("c", "inner", "vdd", 1e-12),
    )
    return Circuit("cell", ports, devices)


def between(circuit: Circuit, a: str, b: str) -> float:
    return sum(
        d.capacitance for d in circuit.devices
        if isinstance(d, Capacitor) and d.name.startswith("coupling") and set(d.terminals()) == {a, b}
    )  # fmt: skip


def test_neighbours_run_side_by_side_and_gates_cross_every_wire() -> None:
    found = coupled(cell(), "bus")
    side = BUS.beside * BUS.length * 3
    assert between(found, "vdd", "a") == pytest.approx(side + 2 * BUS.crossing)
    assert between(found, "a", "y") == pytest.approx(side + 2 * BUS.crossing)
    assert between(found, "vdd", "y") == 0.0  # not neighbours, and neither is a gate
    assert [between(found, "inner", port) for port in ("vdd", "a", "y")] == pytest.approx([BUS.crossing] * 3)
    assert not any("w" in d.terminals()[0] for d in found.devices if d.name.startswith("coupling"))


def test_none_is_the_circuit_itself() -> None:
    assert coupled(cell(), "none") is not coupled(cell(), "bus")
    own = cell()
    assert coupled(own, "none") is own
    assert ("none", *STYLES) == COUPLINGS


def test_a_name_that_is_taken_is_left() -> None:
    names = [d.name for d in coupled(cell("coupling"), "bus").devices]
    assert len(set(names)) == len(names)


def test_instances_are_coupled_and_what_has_no_transistors_is_not() -> None:
    plain = rebound_neuron.build()
    found = coupled(plain, "bus")
    assert found.devices == plain.devices == ()
    for before, after in zip(plain.instances, found.instances, strict=True):
        more = [d for d in after.circuit.devices if d not in before.circuit.devices]
        assert more
        assert all(isinstance(d, Capacitor) for d in more)


def test_every_node_has_as_much_more_as_its_capacitors_say() -> None:
    plain = rebound_neuron.build()
    nodes = ("v_mem", "excitation.v_ex", "echo")
    before, after = (capacitance_matrix(c, AMI_1500_IDEAL, nodes) for c in (plain, coupled(plain, "bus")))
    cells = [i.circuit for i in coupled(plain, "bus").instances]
    assert after[0, 2] - before[0, 2] == pytest.approx(-between(cells[1], "echo", "v_mem"), rel=1e-9)
    assert after[0, 0] > before[0, 0]


def test_a_netlist_has_them_and_gives_them_back() -> None:
    block = load_block("rebound-neuron")
    bench = block.bench(coupled(block.build(), "bus"))
    text = load_dialect("ngspice").write(bench, Silicon(AMI_1500_IDEAL), Settings())
    assert "ccoupling1 echo v_mem 8.36" in text
    assert read_netlist(text).testbench == bench


test_another_style_is_refused = refusals(
    ParameterError, lambda style: coupled(cell(), style), [("maze", "coupling: .*maze.*must be")]
)
