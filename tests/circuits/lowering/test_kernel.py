"""The lowered arrays: charge and current are conserved, the Jacobian is exact, columns find their names."""

from dataclasses import replace

import numpy as np
import pytest

from circuits import devices
from circuits.arrays import F64
from circuits.circuit import Circuit, InstanceArray, Port
from circuits.devices.source import Constant, Sampled
from circuits.lowering.flatten import flatten
from circuits.lowering.kernel import Machine, add_device, to_kernel
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.newton import allocate, evaluate, fill_jacobian, set_base
from circuits.solver.operating_point import write_dense
from circuits.solver.power import _conduction
from circuits.testbench import Testbench

UM = 1e-6
FULL: Process = replace(
    AMI_1500_IDEAL,
    n=replace(AMI_1500_IDEAL.n, law="ekv-gamma", early_field=10e6, junction_leakage=1e-6),
    p=replace(AMI_1500_IDEAL.p, early_field=5e6, junction_leakage=1e-6),
)
NODES = ("d", "g", "s", "b", "o", "w")
DEVICES: tuple[devices.Device, ...] = (
    devices.Transistor("mn", "n", "d", "g", "s", "b", 6 * UM, 3 * UM),
    devices.Transistor("mp", "p", "o", "d", "vdd", "w", 6 * UM, 3 * UM, 2.0),
    devices.Transistor("diode", "n", "g", "g", "0", "0", 6 * UM, 3 * UM),
    devices.OperationalAmplifier("amp", "g", "s", "o", "vdd", "0", 40.0, 1e3, 1e-3),
    devices.ControlledSource("gm", "w", "b", "d", "g", 1e-5),
    devices.Capacitor("c", "d", "vdd", 1e-13),
    *(devices.Resistor(f"r_{n}", n, "vdd" if n in "dow" else "0", 1e5) for n in NODES),
)


def everything(process: Process = FULL) -> Machine:
    """One of each device on nodes that are all unknown, the supply apart."""
    circuit = Circuit("all", (Port("vdd", "supply"),), DEVICES)
    return to_kernel(
        Testbench("all", circuit, (devices.Source("vdd", "vdd", Constant(5.0)),), 1.0), Silicon(process)
    )


def dense_charge(machine: Machine) -> F64:
    """Capacitance matrix over all columns, ground's row left out."""
    k = machine.kernel
    matrix = np.zeros((k.columns, k.columns))
    rows = np.repeat(np.arange(k.unknowns), np.diff(k.charge.start))
    matrix[rows, k.charge.column] = k.charge.value
    rows, columns, values = machine.source_charge
    matrix[rows, columns] = values
    return matrix


def test_charge_is_conserved() -> None:
    machine = everything()
    matrix = dense_charge(machine)
    scale = np.abs(matrix).max()
    # a sum of a dozen terms: each row, ground's among them, adds to nothing
    assert np.abs(matrix.sum(axis=1)).max() <= 1e-14 * scale
    assert np.abs(matrix - matrix.T)[:-1, :-1].max() == 0.0
    off = matrix - np.diag(matrix.diagonal())
    assert (off <= 0.0).all()
    assert (matrix.diagonal()[:-1] > 0.0).all()
    assert machine.kernel.dynamic.all()


def test_capacitance_between_two_nodes_is_that_of_the_devices() -> None:
    machine = everything()
    matrix = dense_charge(machine)
    d, g = machine.column_of("d"), machine.column_of("g")
    overlap, gate_bulk, junction = 0.2e-9 * 6 * UM, 0.5 * 1.1e-3 * 18e-12, 1.5e-9 * 6 * UM
    assert matrix[d, g] == pytest.approx(-overlap, rel=1e-12)
    gate_of_mn = gate_bulk + 2 * overlap
    diode = gate_bulk + overlap + junction  # its gate and drain are one node
    assert matrix[g, g] == pytest.approx(gate_of_mn + diode, rel=1e-12)


def test_the_jacobian_is_exact() -> None:
    # Richardson's differences, h = 0.1 mV: error (h A / headroom)^4 / 5 of the amplifier's slope, 2e-9
    machine = everything()
    k, w = machine.kernel, allocate(machine.kernel)
    rng = np.random.default_rng(11)
    n, h = k.unknowns, 1e-4
    for _ in range(30):
        v = rng.uniform(0.0, 3.0, k.columns)
        v[n], v[-1] = 5.0, 0.0
        v[machine.column_of("s")] = v[machine.column_of("g")] + rng.uniform(-0.05, 0.05)
        set_base(k, 0.0, w)
        evaluate(k, v, w)
        fill_jacobian(k, w)
        exact = np.zeros((n, n))
        write_dense(k, w, exact)
        numeric = np.zeros((n, n))
        for j in range(n):
            for step, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
                moved = v.copy()
                moved[j] += step * h
                evaluate(k, moved, w)
                numeric[:, j] += weight * w.residual / (12 * h)
        scale = np.abs(exact).max(axis=1, keepdims=True)
        assert (np.abs(numeric - exact) <= 1e-6 * scale).all()


def test_device_currents_add_to_nothing() -> None:
    machine = everything()
    k = machine.kernel
    v = np.random.default_rng(2).uniform(0.0, 5.0, (20, k.columns))
    v[:, -1] = 0.0
    out = np.zeros_like(v)
    _conduction(k, v, allocate(k), np.empty((len(v), k.transistors.sign.size)), out)
    assert np.abs(out.sum(axis=1) / np.abs(out).max(axis=1)).max() <= 1e-14


def test_the_constant_law_is_chosen_where_nothing_asks_for_more() -> None:
    assert not everything(AMI_1500_IDEAL).kernel.transistors.body_effect
    assert not everything(AMI_1500_IDEAL).kernel.transistors.leaks
    assert everything().kernel.transistors.body_effect
    assert everything().kernel.transistors.leaks


def test_columns_lead_back_to_names() -> None:
    machine = everything()
    assert sorted(machine.column[1:].tolist()) == list(range(machine.kernel.unknowns + 1))
    assert machine.column_of("0") == machine.kernel.columns - 1
    assert machine.column_of("vdd") == machine.kernel.unknowns
    assert [machine.column_of(n) for n in machine.names] == machine.column.tolist()


def test_an_array_becomes_columns_of_one_group() -> None:
    follower = Circuit(
        "follower",
        (Port("a", "analog"), Port("y", "analog", "out")),
        (devices.Resistor("r", "a", "y", 1e3), devices.Resistor("load", "y", "0", 1e3)),
    )
    ports = (Port("a", "analog"), Port("y", "analog", "out", (3,)))
    values = {"r.resistance": (1e3, 2e3, 3e3)}
    circuit = Circuit("top", ports, (), (InstanceArray("x", follower, (3,), {"a": "a", "y": "y"}, values),))
    machine = to_kernel(Testbench("t", circuit, (devices.Source("a", "a", Constant(1.0)),), 1.0))
    rows = np.repeat(np.arange(3), np.diff(machine.kernel.conductance.start))
    own = machine.kernel.conductance.value[rows == machine.kernel.conductance.column]
    order = [machine.column_of(f"y[{i}]") for i in range(3)]
    assert own[order] == pytest.approx([1e-3 + 1e-3 / k for k in (1, 2, 3)], rel=1e-12)


def test_nothing_unknown_is_a_machine_too() -> None:
    circuit = Circuit("r", (Port("a", "analog"),), (devices.Resistor("r", "a", "0", 1e3),))
    machine = to_kernel(Testbench("t", circuit, (devices.Source("a", "a", Constant(1.0)),), 1.0))
    assert machine.kernel.unknowns == 0


def test_sampled_sources_are_followed_not_broken_at() -> None:
    circuit = Circuit("r", (Port("a", "analog"),), (devices.Resistor("r", "a", "0", 1e3),))
    source = devices.Source("a", "a", Sampled(0.0, 1e3, np.zeros(4)))
    assert to_kernel(Testbench("t", circuit, (source,), 1.0)).sampled == (True,)


def test_an_unknown_device_type_is_named() -> None:
    class Memristor(devices.Device):
        def terminals(self) -> tuple[str, ...]:
            return ("a", "0")

        def parameters(self) -> dict[str, float]:
            return {}

        def check(self) -> None:
            return None

        def conducting(self) -> tuple[tuple[int, int], ...]:
            return ((0, 1),)

    circuit = Circuit("r", (Port("a", "analog"),), (Memristor("m"),))
    group = flatten(circuit).groups[0]
    with pytest.raises(TypeError, match="Memristor: no lowering to the kernel"):
        add_device(group.device, group, None)  # type: ignore[arg-type]
