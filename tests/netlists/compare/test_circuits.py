"""Equal circuits, and the first differences of others."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.registry import load_chip
from circuits.circuit import Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Capacitor, ControlledSource, Device, Resistor, Transistor
from circuits.registry import BLOCKS, load_block
from circuits.silicon.silicon import Deviation
from netlists.compare.circuits import compare


def block(name: str) -> Circuit:
    found = load_chip(name) if name == "ranging-chip" else load_block(name)
    circuit: Circuit = found.build()
    return circuit


def changed(circuit: Circuit, path: str, change: Callable[[Any], Device | None]) -> Circuit:
    """The circuit with the device at `path` changed, or without it."""
    head, _, rest = path.partition(".")
    if rest:
        instances = tuple(
            replace(i, circuit=changed(i.circuit, rest, change)) if i.name == head else i
            for i in circuit.instances
        )
        return replace(circuit, instances=instances)
    devices = (change(d) if d.name == head else d for d in circuit.devices)
    return replace(circuit, devices=tuple(d for d in devices if d is not None))


def disguised(circuit: Circuit, seed: int) -> Circuit:
    """The same circuit with other names of devices, instances and inner nodes, in another order."""
    order = random.Random(seed)  # noqa: S311 - no secret
    ports = {p.name for p in circuit.ports} | {"0"}
    names: dict[str, str] = {}

    def node(reference: str) -> str:
        name, bracket, index = reference.partition("[")
        if name in ports:
            return reference
        return names.setdefault(name, f"q{len(names)}") + bracket + index

    devices = [_renamed(d, f"d{k}", node) for k, d in enumerate(circuit.devices)]
    order.shuffle(devices)
    instances = [
        replace(
            i,
            name=f"y{k}",
            circuit=i.circuit if i.parameters else disguised(i.circuit, seed + 1),  # they name its devices
            connections={p: node(r) for p, r in i.connections.items()},
        )
        for k, i in enumerate(circuit.instances)
    ]
    order.shuffle(instances)
    nodes = tuple(Node(node(n.name), n.shape) for n in circuit.nodes)
    return replace(circuit, devices=tuple(devices), instances=tuple(instances), nodes=nodes, biases=())


def _renamed(device: Any, name: str, node: Callable[[str], str]) -> Device:
    fields = [f for f in device.__dataclass_fields__ if f != "name" and isinstance(getattr(device, f), str)]
    moved = {f: node(getattr(device, f)) for f in fields if f != "polarity"}
    renamed: Device = replace(device, name=name, **moved)
    return renamed


@pytest.mark.parametrize("name", [*BLOCKS, "ranging-chip"])
def test_names_and_order_do_not_count(name: str) -> None:
    circuit = block(name)
    plain = replace(circuit, biases=())
    for other in (circuit, disguised(plain, 1)):
        found = compare(circuit, other)
        assert found.equal, found.differences
        assert found.devices[0] == found.devices[1] > 0


def test_drain_and_source_and_the_ends_of_passive_devices_may_be_swapped() -> None:
    a = Circuit(
        "c",
        (Port("p", "analog"), Port("q", "analog")),
        (
            Transistor("m1", "n", "p", "q", "x", "0", 1e-6, 1e-6),
            Capacitor("c1", "x", "q", 1e-12),
            Resistor("r1", "x", "0", 1.0),
            ControlledSource("g1", "p", "x", "q", "0", 1.0),
        ),
    )
    turned = (
        Transistor("m1", "n", "x", "q", "p", "0", 1e-6, 1e-6),
        Capacitor("c1", "q", "x", 1e-12),
        Resistor("r1", "0", "x", 1.0),
        ControlledSource("g1", "x", "p", "0", "q", 1.0),
    )
    for k, device in enumerate(turned):
        devices = tuple(device if j == k else d for j, d in enumerate(a.devices))
        assert compare(a, replace(a, devices=devices)).equal
    half_turned = ControlledSource("g1", "x", "p", "q", "0", 1.0)
    assert not compare(a, replace(a, devices=(*a.devices[:3], half_turned))).equal
    gate_moved = Transistor("m1", "n", "q", "p", "x", "0", 1e-6, 1e-6)
    assert not compare(a, replace(a, devices=(gate_moved, *a.devices[1:]))).equal


@pytest.mark.parametrize(
    ("change", "texts"),
    [
        (
            lambda d: replace(d, width=7e-6),
            ["size inhibition.mi5: width 6e-06 in the first, 7e-06 in the second"],
        ),
        (
            lambda d: replace(d, drain="b"),
            ["device inhibition.mi5: drain at inhibition.v_inh in the first, inhibition.b in the second"],
        ),
        (
            lambda d: replace(d, polarity="p"),
            ["device inhibition.mi5: n transistor in the first, p transistor in the second"],
        ),
        (
            lambda _: None,
            [
                "device n transistor: 15 in the first, 14 in the second",
                "device inhibition.mi5: n transistor of ",
            ],
        ),
    ],
)
def test_the_first_differences_name_device_node_and_size(
    change: Callable[[Any], Device | None], texts: list[str]
) -> None:
    a = replace(block("rebound-neuron"), biases=())  # one of them names mi5
    found = compare(a, changed(a, "inhibition.mi5", change))
    told = [str(d) for d in found.differences]
    for text in texts:
        assert any(text in line for line in told), told
    assert len(told) <= 10


def test_ports_are_matched_by_name() -> None:
    a = Circuit("c", (Port("p", "analog"), Port("q", "analog")), (Resistor("r", "p", "q", 1.0),))
    b = Circuit("c", (Port("p", "analog"), Port("s", "analog")), (Resistor("r", "p", "s", 1.0),))
    assert [str(d) for d in compare(a, b).differences] == [
        "port q: only in the first",
        "port s: only in the second",
    ]
    upper = Circuit("c", (Port("P", "supply"), Port("Q", "bias")), (Resistor("r", "P", "Q", 1.0),))
    assert compare(a, upper).equal


def test_an_element_of_an_array_port_is_the_plain_port_of_another_netlist() -> None:
    a = Circuit("c", (Port("s", "analog", shape=(2,)),), (Resistor("r", "s[0]", "s[1]", 1.0),))
    ports = (Port("s_x23_0", "analog"), Port("s_x23_1", "analog"))
    assert compare(a, Circuit("c", ports, (Resistor("r", "s_x23_1", "s_x23_0", 1.0),))).equal


def test_hierarchy_and_arrays_are_flattened() -> None:
    cell = Circuit(
        "cell", (Port("p", "analog"),), (Resistor("r1", "p", "x", 1.0), Resistor("r2", "x", "0", 2.0))
    )
    array = Circuit("c", (Port("p", "analog"),), (), (InstanceArray("a", cell, (3,), {"p": "p"}),))
    instances = tuple(Instance(f"i{k}", cell, {"p": "p"}) for k in range(3))
    flat = tuple(
        Resistor(f"r{k}_{j}", *ends, value)
        for k in range(3)
        for j, (ends, value) in enumerate(((("p", f"x{k}"), 1.0), ((f"x{k}", "0"), 2.0)))
    )
    assert compare(array, Circuit("c", (Port("p", "analog"),), (), instances)).equal
    assert compare(array, Circuit("c", (Port("p", "analog"),), flat)).equal
    assert not compare(array, Circuit("c", (Port("p", "analog"),), flat[:-1])).equal


def test_sizes_have_a_tolerance() -> None:
    a = Circuit("c", (Port("p", "analog"),), (Resistor("r", "p", "0", 1e3),))
    assert compare(a, replace(a, devices=(Resistor("r", "p", "0", 1e3 * (1.0 + 9e-10)),))).equal
    assert not compare(a, replace(a, devices=(Resistor("r", "p", "0", 1e3 * (1.0 + 2e-9)),))).equal


def test_deviations_are_sizes() -> None:
    a = block("rebound-neuron")
    one = {"inhibition.mi5": Deviation(1e-3, 0.0)}
    assert compare(a, a, deviations=(one, one)).equal
    assert compare(a, a, deviations=({}, {"inhibition.mi5": Deviation(0.0, 0.0)})).equal
    found = compare(a, a, deviations=(one, {}))
    assert [str(d) for d in found.differences] == [
        "size inhibition.mi5: deviation of V_T0 0.001 in the first, 0.0 in the second"
    ]


def ring(*sizes: int) -> Circuit:
    """Rings of equal resistors, which colours alone cannot tell apart."""
    devices = tuple(
        Resistor(f"r{j}_{k}", f"n{j}_{k}", f"n{j}_{(k + 1) % size}", 1.0)
        for j, size in enumerate(sizes)
        for k in range(size)
    )
    return Circuit("c", (), devices)


def test_what_colours_cannot_tell_apart_is_matched() -> None:
    assert compare(ring(6), ring(6)).equal
    assert compare(ring(3, 3), ring(3, 3)).equal
    found = compare(ring(6), ring(3, 3))
    assert [d.kind for d in found.differences] == ["device", "device"]


def test_sizes_that_stand_side_by_side_count() -> None:
    def pairs(*values: tuple[float, float]) -> Circuit:
        devices = (
            Resistor(f"r{k}{j}", node, f"x{k}", value)
            for k, two in enumerate(values)
            for j, (node, value) in enumerate(zip(("p", "0"), two, strict=True))
        )
        return Circuit("c", (Port("p", "analog"),), tuple(devices))

    found = compare(pairs((1.0, 1.0), (2.0, 2.0)), pairs((1.0, 2.0), (2.0, 1.0)))
    assert {d.kind for d in found.differences} == {"size"}


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_random_networks_equal_their_disguise_and_no_other(seed: int) -> None:
    made = random.Random(seed)  # noqa: S311 - no secret
    nodes = ["p", "q", "0", *(f"n{k}" for k in range(made.randint(1, 6)))]
    devices: list[Device] = []
    for k in range(made.randint(2, 14)):
        if made.random() < 0.5:
            d, g, s, b = (made.choice(nodes) for _ in range(4))
            devices.append(Transistor(f"m{k}", "n", d, g, s, b, made.choice((1e-6, 2e-6)), 1e-6))
        else:
            devices.append(Resistor(f"r{k}", made.choice(nodes), made.choice(nodes), 1.0))
    a = Circuit("c", (Port("p", "analog"), Port("q", "analog")), tuple(devices))
    assert compare(a, disguised(a, seed)).equal
    k = made.randrange(len(devices))
    without = replace(a, devices=tuple(d for j, d in enumerate(devices) if j != k))
    assert not compare(a, disguised(without, seed)).equal


def test_a_bit_of_a_bus_is_the_same_port_however_it_is_written() -> None:
    array = Circuit("c", (Port("a", "analog", shape=(2,)),), (Resistor("r", "a[0]", "a[1]", 1e3),))
    for zero, one in (("a_x5b_0_x5d_", "a_x5b_1_x5d_"), ("a_x3c_0_x3e_", "a_x3c_1_x3e_")):
        ports = (Port(zero, "analog"), Port(one, "analog"))
        assert compare(array, Circuit("c", ports, (Resistor("r", zero, one, 1e3),))).equal
