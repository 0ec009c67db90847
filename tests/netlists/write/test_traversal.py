"""Designs: definitions and calls, expanded, are the devices, nodes and deviations of the flat circuit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.circuit import GROUND, Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.source import Constant
from circuits.lowering.flatten import flatten
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Deviation, Silicon
from circuits.testbench import Testbench
from netlists.write.traversal import Definition, Design, element, to_design

Found = dict[str, tuple[Device, Deviation, tuple[str, ...]]]
DIES = [Die(), Die("A", 3)]


def expand(design: Design) -> Found:
    """Every device by path, with its deviation and the paths of the nodes at its terminals."""
    named = {d.name: d for d in design.definitions}
    found: Found = {}

    def walk(definition: Definition, prefix: str, outer: dict[str, str]) -> None:
        def node(reference: str) -> str:
            return outer.get(reference, reference if reference == GROUND else prefix + reference)

        for device, deviation in definition.devices:
            found[prefix + device.name] = (device, deviation, tuple(map(node, device.terminals())))
        for call in (c for calls in definition.calls for c in calls):
            inner = named[call.definition]
            ports = dict(zip(inner.ports, map(node, call.nodes), strict=True))
            walk(inner, f"{prefix}{element(call.name, call.index)}.", ports)

    walk(design.top, "", {})
    return found


def flat_devices(circuit: Circuit, silicon: Silicon) -> Found:
    flat = flatten(circuit)
    names = flat.node_names()
    found: Found = {}
    for group in flat.groups:
        count = group.nodes.shape[1]
        deviation = Deviation(0.0, 0.0)
        if isinstance(group.device, Transistor):
            area = group.parameters["width"] * group.parameters["length"] * group.parameters["multiplicity"]
            deviation = silicon.deviation(circuit.name, (*group.path, (group.device.name, ())), area)
        for k in range(count):
            own = {a: float(v[k]) for a, v in group.parameters.items()}
            shift = Deviation(*(float(np.broadcast_to(x, count)[k]) for x in deviation))
            nodes = tuple(names[n] for n in group.nodes[:, k])
            found[group.label(k)] = (replace(group.device, **own), shift, nodes)  # type: ignore[type-var]
    return found


def nested() -> Circuit:
    """Arrays in arrays, parameters on three levels, node arrays that broadcast, two parts of one name."""
    part = Circuit(
        "part",
        (Port("a", "analog"), Port("y", "analog", "out")),
        (Transistor("m", "n", "a", "a", "y", "0", 3e-6, 3e-6), Resistor("r", "y", "in", 1e3),
         Resistor("q", "in", "0", 1e3)),
    )  # fmt: skip
    twin = replace(part, devices=(*part.devices[:2], Resistor("q", "in", "0", 2e3)))
    pair = Circuit(
        "pair",
        (Port("a", "analog"), Port("y", "analog", "out", (2,))),
        (),
        (
            InstanceArray("p", part, (2,), {"a": "a", "y": "y"}, {"r.resistance": (1.0, 2.0)}),
            Instance("t", twin, {"a": "a", "y": "inner"}, {"m.width": 5e-6}),
        ),
    )
    values = np.arange(6.0).reshape(2, 3) + 10.0
    rows = InstanceArray(
        "row", pair, (2, 3), {"a": "mid", "y": "out"}, {"p.r.resistance": values, "t.q.resistance": 7.0}
    )
    plain = InstanceArray("plain", pair, (4,), {"a": "x", "y": "low"})
    ports = (Port("x", "analog"), Port("out", "analog", "out", (3, 2)), Port("v", "bias", "in", (3,)))
    load = Resistor("load", "mid[1]", "x", 1.0)
    biases = (Bias("v", "v", "voltage", (1.0, 2.0, 3.0)),)
    ties = tuple(Resistor(f"tie{k}", f"v[{k}]", f"mid[{k}]", 1.0) for k in range(3))
    nodes = (Node("mid", (3,)), Node("low", (2,)))
    return Circuit("nest", ports, (load, *ties), (rows, plain), nodes, biases)


@pytest.mark.parametrize("die", DIES, ids=str)
@pytest.mark.parametrize("name", block_names())
def test_blocks_expand_to_their_flat_devices(name: str, die: Die) -> None:
    block = load_block(name)
    circuit = block.build()
    bench = block.testbench(circuit, block.defaults, block.process.v_dd)
    silicon = Silicon(AMI_1500_IDEAL, die=die)
    assert expand(to_design(bench, silicon)) == flat_devices(circuit, silicon)


@pytest.mark.parametrize("die", DIES, ids=str)
def test_nested_arrays_expand_to_their_flat_devices(die: Die) -> None:
    circuit, silicon = nested(), Silicon(AMI_1500_IDEAL, die=die)
    design = to_design(Testbench("t", circuit, (Source("x", "x", Constant(1.0)),), 1.0), silicon)
    found = expand(design)
    assert found == flat_devices(circuit, silicon)
    assert len(found) == 4 + 3 * 3 * (6 + 4)
    if die.number is None:
        # parts with r of 1 and 2 in `plain`, 10 to 15 in the rows; twins with q of 2k and 7; 7 pairs; the top
        assert len(design.definitions) == (2 + 6) + 2 + 7 + 1


def test_definitions_stand_before_their_use_under_names_of_their_own() -> None:
    bench = Testbench("t", nested(), (Source("x", "x", Constant(1.0)),), 1.0)
    design = to_design(bench, Silicon(AMI_1500_IDEAL, die=Die("A", 3)))
    seen: set[str] = set()
    for definition in design.definitions:
        assert all(c.definition in seen for calls in definition.calls for c in calls)
        assert definition.name.lower() not in seen
        seen.add(definition.name.lower())
    assert design.top.circuit is bench.circuit


def test_circuits_that_differ_in_their_ports_kinds_or_biases_are_not_one() -> None:
    part = Circuit("part", (Port("a", "bias"),), (Resistor("r", "a", "0", 1.0),))
    kinds = (
        part,
        replace(part, ports=(Port("a", "analog"),)),
        replace(part, biases=(Bias("a", "a", "voltage", 1.0),)),
        replace(part, biases=(Bias("a", "a", "voltage", 2.0),)),
        rebias(part),
    )
    instances = tuple(Instance(f"i{k}", kind, {"a": "x"}) for k, kind in enumerate(kinds))
    top = Circuit("top", (Port("x", "analog"),), (), instances)
    design = to_design(Testbench("t", top, (Source("x", "x", Constant(1.0)),), 1.0), Silicon(AMI_1500_IDEAL))
    assert [c.definition for calls in design.top.calls for c in calls] == [
        "part", "part_2", "part_3", "part_4", "part",
    ]  # fmt: skip


def test_sources_know_where_they_come_from() -> None:
    given = (Source("x", "x", Constant(1.0)), Source("v", "v[1]", Constant(9.0)))
    drives = to_design(Testbench("t", nested(), given, 1.0), Silicon(AMI_1500_IDEAL)).drives
    assert [(d.source.name, d.biased) for d in drives] == [
        ("x", False), ("v", False), ("v[0]", True), ("v[2]", True),
    ]  # fmt: skip


def test_parasitics_make_definitions_only_where_they_are() -> None:
    bench = Testbench("t", nested(), (Source("x", "x", Constant(1.0)),), 1.0)
    loads = {"plain[2].t.in": 1e-15, "plain[3].t.in": 1e-15, "row[1,2].p[0].in": 2e-15, "mid[1]": 3e-15}
    design = to_design(bench, Silicon(AMI_1500_IDEAL), loads)
    named = {d.name: d for d in design.definitions}
    rows, plain = design.top.calls
    assert design.top.parasitics == (Capacitor("parasitic0", "mid[1]", "0", 3e-15),)
    assert [len({c.definition for c in calls}) for calls in (rows, plain)] == [6, 2]
    assert plain[0].definition == plain[1].definition != plain[2].definition == plain[3].definition
    inner = named[named[plain[2].definition].calls[1][0].definition]
    assert inner.parasitics == (Capacitor("parasitic0", "in", "0", 1e-15),)
    assert sum(bool(d.parasitics) for d in design.definitions) == 3
