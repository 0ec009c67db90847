"""Verilog-A netlists: structural modules that know all their nodes, and a testbench that drives them."""

from __future__ import annotations

import re

import pytest

from circuits.circuit import Circuit, InstanceArray, Port
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import NO_DEVIATION, Silicon
from circuits.testbench import Testbench
from netlists.registry import Settings
from netlists.verilog_a.law import MODULES
from netlists.verilog_a.text import DIALECT
from netlists.write.bsim3 import total_deviation

format_device = DIALECT.devices["ekv"]


def block_testbench(name: str) -> Testbench:
    block = load_block(name)
    return block.bench()


def bank() -> Testbench:
    part = Circuit(
        "module",  # a keyword
        (Port("a", "analog"), Port("y", "analog", "out")),
        (Transistor("m", "n", "a", "a", "y", "0", 3e-6, 3e-6), Resistor("r", "y", "inner", 1e6),
         Capacitor("c", "inner", "0", 1e-12)),
    )  # fmt: skip
    cells = InstanceArray("cell", part, (2,), {"a": "a", "y": "y"})
    ports = (Port("a", "analog"), Port("y", "analog", "out", (2,)))
    ramp = Source("a", "a", PiecewiseLinear((0.0, 1e-3, 2e-3), (0.0, 1.0, 1.0)))
    pull = Source("pull", "y[1]", Constant(1e-9), "current")
    return Testbench("bank", Circuit("bank", ports, (), (cells,)), (ramp, pull), 3e-3)


def modules(text: str) -> dict[str, str]:
    bare = re.sub(r"//.*", "", text)
    return {m.group(1): m.group(0) for m in re.finditer(r"module (\w+)\b.*?endmodule", bare, re.DOTALL)}


@pytest.mark.parametrize("name", block_names())
def test_every_instance_fits_its_module_and_every_node_is_declared(name: str) -> None:
    found = modules(
        DIALECT.write(block_testbench(name), Silicon(AMI_1500_IDEAL, die=Die("A", 3)), Settings())
    )
    ports = {}
    for module, text in found.items():
        head = re.match(r"module \w+(?:\((.*?)\))?;", text, re.DOTALL)
        assert head
        ports[module] = [p.strip() for p in (head.group(1) or "").split(",") if p.strip()]
    for module, text in found.items():
        declared = re.search(r"electrical (.*?);", text, re.DOTALL)
        nodes = {n.strip() for n in declared.group(1).split(",")} if declared else set()
        assert set(ports[module]) <= nodes
        for called, _, given in re.findall(r"^ {2}(\w+) (#\(.*?\) )?\w+\(([^#]*?)\);", text, re.MULTILINE):
            if called in found:
                connected = [n.strip() for n in given.split(",")]
                assert len(connected) == len(ports[called])
                assert set(connected) <= nodes
        assert ("ground gnd;" in text) is ("gnd" in nodes)
    assert "testbench" in found


def test_only_laws_that_are_used_are_written() -> None:
    found = modules(DIALECT.write(bank(), Silicon(AMI_1500_IDEAL), Settings()))
    assert set(found) & MODULES == {"noctule_nfet", "noctule_capacitor", "noctule_resistor"}
    assert list(found)[-3:] == ["module__r", "bank", "testbench"]
    assert "module__r xcell__1(a, y__1);" in found["bank"]


def test_sources_are_renewed_at_their_vertices() -> None:
    text = modules(DIALECT.write(bank(), Silicon(AMI_1500_IDEAL), Settings()))["testbench"]
    assert "@(initial_step) begin t0 = 0.0; v0 = 0.0; slope = 1000.0; end" in text
    assert "@(timer(0.001)) begin t0 = 0.001; v0 = 1.0; slope = 0.0; end" in text
    assert "V(a, gnd) <+ v0 + slope * ($abstime - t0);" in text
    assert "I(gnd, y__1) <+ 1e-09;" in text


def test_deviations_of_a_die_are_parameters() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die("A", 3))
    device = Transistor("m", "p", "d", "g", "s", "vdd", 3e-6, 3e-6)
    text = format_device(device, silicon)[0]
    total = total_deviation(silicon, "p", NO_DEVIATION)
    assert f".delta_v_t0({total.v_t0!r})" in text
    assert f".delta_beta({total.beta!r})" in text
    assert "delta" not in format_device(device, Silicon(AMI_1500_IDEAL))[0]


def test_all_devices_are_instances_with_notes() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    for device, module in (
        (Capacitor("c", "a", "0", 1e-12), "noctule_capacitor #(.c(1e-12)) cc(a, gnd);"),
        (Resistor("r", "a", "b[2]", 1e3), "noctule_resistor #(.r(1000.0)) rr(a, b__2);"),
        (
            ControlledSource("g", "a", "b", "c", "d", 1e-3),
            "noctule_transconductor #(.gm(0.001)) gg(a, b, c, d);",
        ),
    ):
        *note, line = format_device(device, silicon)
        assert note[0].startswith("//% ")
        assert line.strip() == module
    (line,) = format_device(OperationalAmplifier("u", "p", "n", "o", "vdd"), silicon)
    assert line.strip().startswith(
        "noctule_amplifier #(.gain(100000.0), .resistance(100.0), .offset(0.0)) uu("
    )


def test_parasitics_are_capacitors() -> None:
    text = DIALECT.write(bank(), Silicon(AMI_1500_IDEAL), Settings(parasitics={"cell[1].inner": 1e-15}))
    found = modules(text)
    assert "noctule_capacitor #(.c(1e-15)) cparasitic0(inner, gnd);" in found["module_2"]
    assert "parasitic" not in found["module__r"]
