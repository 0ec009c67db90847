"""The solver agrees with ngspice: every block on one die, every device type in a small circuit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from circuits.blocks.block import Block
from circuits.circuit import Circuit, InstanceArray, Port
from circuits.devices import (
    DEVICE_TYPES,
    Capacitor,
    ControlledSource,
    Diode,
    OperationalAmplifier,
    Resistor,
    Source,
    Transistor,
)
from circuits.devices.device import Device
from circuits.devices.source import Constant, PiecewiseLinear, Pulse, Sampled
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver import operating_point as native
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from netlists.ngspice import agreement, engine
from netlists.ngspice.agreement import USUAL, compare
from netlists.ngspice.form import delay_ratio, scaled_testbench, started
from tests.agreement.blocks import CASES, USUAL_CASE, case_of, silicon_of

pytestmark = pytest.mark.usefixtures("kept_ngspice")

UM = 1e-6
V_DD = 5.0
SUPPLY = Source("vdd", "vdd", Constant(V_DD))
VDD = Port("vdd", "supply")


@pytest.mark.parametrize("name", block_names())
def test_every_block_agrees(name: str) -> None:
    block, case = load_block(name), case_of(name)
    silicon = silicon_of(block)
    testbench = scaled_testbench(block, silicon, case.form)
    if case.begun or testbench.start:
        testbench = started(testbench, silicon)
    ours = simulate(testbench, silicon, rtol=agreement.SOLVER_RTOL)
    peer = engine.simulate(testbench, silicon, reltol=case.reltol, tmax=testbench.stop / case.points)
    found = agreement.difference(ours, peer, case.allowed)
    assert agreement.shows_something(ours, found), f"nothing happens on {silicon}"
    assert any(t.size for t in ours.spikes.values()) or not testbench.watch, "silent: it needs another form"
    assert found.share <= 1.0, (found, found.worst_node, found.worst_rms)
    assert found.excluded <= 0.1
    if case.variation != "plain":
        plain = replace(silicon, die=replace(silicon.die, variation="plain"))
        apart = agreement.difference(
            simulate(testbench, plain, rtol=agreement.SOLVER_RTOL), peer, case.allowed
        )
        assert apart.share > 1.0, "the components change nothing that is compared"


def test_a_block_s_silicon_hangs_on_its_name_and_on_nothing_else() -> None:
    drawn = {name: silicon_of(load_block(name)) for name in block_names()}
    assert len({silicon.die.number for silicon in drawn.values()}) > 0.8 * len(drawn)
    for name, silicon in drawn.items():
        assert case_of(name).coldest <= silicon.temperature_c <= case_of(name).hottest
    block = load_block("rebound-neuron")
    assert silicon_of(replace(block, summary="another")) == drawn["rebound-neuron"]
    assert silicon_of(replace(block, name="rebound-neuron-2")).die != drawn["rebound-neuron"].die


def test_what_is_not_usual_has_a_reason() -> None:
    assert set(CASES) <= set(block_names())
    assert all(case.why for case in CASES.values())
    assert not USUAL_CASE.why


def test_nothing_agrees_where_nothing_was_compared() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    found = compare(pulsed(inverter_chain()), silicon)
    flat = replace(found.difference, moved=0.5 * USUAL.node_rms)
    silent = replace(found.solver, spikes={"y": np.zeros(0)})
    assert replace(found, difference=flat).compared
    assert replace(found, solver=silent).compared
    nothing = replace(found, difference=flat, solver=silent)
    assert not nothing.compared
    assert not nothing.agrees


def varied(**changes: Any) -> Process:
    return replace(
        AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, **changes), p=replace(AMI_1500_IDEAL.p, **changes)
    )


def inverter_chain(load: tuple[Device, ...] = ()) -> Circuit:
    """Two inverters, the first starved by a stacked pair whose sources are off their bulks."""
    devices = (
        Transistor("mp1", "p", "b", "a", "top", "vdd", 6 * UM, 1.5 * UM),
        Transistor("mp2", "p", "top", "0", "vdd", "vdd", 6 * UM, 6 * UM),
        Transistor("mn1", "n", "b", "a", "foot", "0", 3 * UM, 1.5 * UM),
        Transistor("mn2", "n", "foot", "vdd", "0", "0", 3 * UM, 6 * UM, 2.0),
        Transistor("mp3", "p", "y", "b", "vdd", "vdd", 6 * UM, 1.5 * UM),
        Transistor("mn3", "n", "y", "b", "0", "0", 3 * UM, 1.5 * UM),
        Capacitor("cb", "b", "0", 1e-12),
        *load,
    )
    return Circuit("chain", (VDD, Port("a", "event"), Port("y", "event", "out")), devices)


def pulsed(circuit: Circuit, stop: float = 1e-6) -> Testbench:
    drive = Source("a", "a", Pulse(0.0, V_DD, (0.2 * stop,), 0.3 * stop, 0.05 * stop, 0.05 * stop))
    return Testbench("pulsed", circuit, (SUPPLY, drive), stop, watch=("y",))


COLD, HOT = -20.0, 85.0  # degC


@pytest.mark.parametrize(
    ("process", "temperature"),  # each effect by itself at one, and what has several at both
    [
        (AMI_1500_IDEAL, COLD),
        (AMI_1500_IDEAL, HOT),
        (varied(law="ekv-gamma"), HOT),
        (varied(early_field=5e6), COLD),
        (varied(junction_leakage=1e-3), HOT),  # far above silicon's: 3 nA a junction, so that it matters here
        (varied(law="ekv-gamma", early_field=10e6, junction_leakage=1e-4), COLD),
        (varied(early_field=2e6, early_rise=0.5, mobility_reduction=1.0), HOT),
        (varied(junction_leakage=1e-6, gate_induced_leakage=1e-4, gate_induced_slope=1.0), COLD),
        (AMI_1500, COLD),
        (AMI_1500, HOT),
    ],
    ids=[
        "ekv-cold", "ekv-hot", "ekv-gamma", "early", "leakage", "all", "reduced", "induced", "full-cold",
        "full-hot",
    ],
)  # fmt: skip
def test_transistors_agree_under_every_law(process: Process, temperature: float) -> None:
    found = compare(pulsed(inverter_chain()), Silicon(process, temperature))
    assert found.agrees, found
    assert found.solver.spikes["y"].size == 1


@pytest.mark.parametrize("law", ["ekv", "ekv-gamma"])
@pytest.mark.parametrize("polarity", ["n", "p"])
def test_drain_currents_agree_from_weak_to_strong_inversion(law: str, polarity: Any) -> None:
    """Diode-connected devices fed with 1 pA to 100 uA, sources off their bulks."""
    currents = [1e-12, 1e-10, 1e-8, 1e-6, 1e-4]
    ports = tuple(Port(f"d{k}", "analog") for k in range(len(currents)))
    bulk = "vdd" if polarity == "p" else "0"
    devices = tuple(
        Transistor(f"m{k}", polarity, f"d{k}", f"d{k}", "s", bulk, 3 * UM, 3 * UM)
        for k in range(len(currents))
    )
    load = Resistor("load", "vdd", "0", 1e6)  # an nFET has no use for the supply
    circuit = Circuit("diodes", (VDD, Port("s", "analog"), *ports), (load, *devices))
    sign, source = (1.0, 0.4) if polarity == "n" else (-1.0, V_DD - 0.4)
    drives = tuple(Source(f"i{k}", f"d{k}", Constant(sign * i), "current") for k, i in enumerate(currents))
    testbench = Testbench("diodes", circuit, (SUPPLY, Source("s", "s", Constant(source)), *drives), 1e-3)
    reduced = varied(law=law, early_field=15e6, early_rise=0.2, mobility_reduction=0.5, junction_leakage=1e-9)
    silicon = Silicon(reduced)
    ours, peer = native.operating_point(testbench, silicon), engine.operating_point(testbench, silicon)
    for k in range(len(currents)):
        assert peer[f"d{k}"] == pytest.approx(ours[f"d{k}"], abs=1e-6)


def test_an_operational_amplifier_agrees_within_and_at_its_rails() -> None:
    amplifier = OperationalAmplifier("u", "x", "fb", "y", "vdd", "0", 1e4, 1e3, 1e-3)
    devices = (
        amplifier,
        Resistor("rf", "y", "fb", 2e4),
        Resistor("ri", "fb", "0", 1e4),
        Capacitor("cy", "y", "0", 1e-7),
        Capacitor("cf", "fb", "0", 1e-12),
    )
    circuit = Circuit("amplifier", (VDD, Port("x", "analog"), Port("y", "analog", "out")), devices)
    ramp = PiecewiseLinear((0.0, 1e-3, 2e-3), (0.2, 3.0, 0.5))
    testbench = Testbench("amplifier", circuit, (SUPPLY, Source("x", "x", ramp)), 2.5e-3)
    found = compare(testbench, Silicon(AMI_1500_IDEAL))
    assert found.agrees, found
    assert found.solver["y"].max() > 4.8


def test_a_rectifier_agrees() -> None:
    store = {"saturation_current": 1e-12, "junction_capacitance": 5e-12, "transit_time": 5e-9}
    devices = (
        Diode("d", "a", "o", **store), Diode("e", "0", "a", breakdown_voltage=8.0, **store),
        Resistor("s", "x", "a", 1e3), Capacitor("c", "o", "0", 1e-9), Resistor("r", "o", "0", 1e5),
    )  # fmt: skip
    circuit = Circuit("rectifier", (Port("x", "analog"), Port("o", "analog", "out")), devices)
    ramp = PiecewiseLinear((1e-6, 2e-6, 6e-6, 7e-6), (0.0, 5.0, 5.0, -5.0))
    found = compare(Testbench("rectifier", circuit, (Source("x", "x", ramp),), 2e-5), Silicon(AMI_1500_IDEAL))
    assert found.agrees, found
    assert found.solver["o"].max() > 4.0


def test_a_controlled_source_and_current_sources_agree() -> None:
    devices = (
        ControlledSource("g", "y", "0", "x", "0", 1e-3),
        Resistor("rx", "x", "0", 1e6),
        Resistor("ry", "y", "0", 2e3),
        Capacitor("cx", "x", "0", 1e-10),
        Capacitor("cxy", "x", "y", 1e-12),
    )
    circuit = Circuit("gain", (Port("x", "analog"), Port("y", "analog", "out")), devices)
    wave = Sampled(0.0, 1e6, 1e-6 * np.sin(np.linspace(0.0, 6.0, 1001)))
    testbench = Testbench("gain", circuit, (Source("i", "x", wave, "current"),), 1e-3)
    found = compare(testbench, Silicon(AMI_1500_IDEAL))
    assert found.agrees, found
    assert np.ptp(found.solver["y"]) > 1.0


def test_an_array_with_its_own_parameters_agrees() -> None:
    lengths = {
        "mn2.length": np.array([3.0, 6.0, 12.0]) * UM,
        "cb.capacitance": np.array([1.0, 0.5, 2.0]) * 1e-12,
    }
    part = inverter_chain()
    connections = {"vdd": "vdd", "a": "a", "y": "y"}
    bank = InstanceArray("chain", part, (3,), connections, lengths)
    circuit = Circuit("bank", (VDD, Port("a", "event"), Port("y", "event", "out", (3,))), (), (bank,))
    found = compare(pulsed(circuit), Silicon(AMI_1500_IDEAL))
    assert found.agrees, found
    assert len({float(t[0]) for t in found.solver.spikes.values()}) == 3


@pytest.mark.parametrize("die", [Die("A", 1003), Die("B", 7, corner="ss"), Die(corner="fs")], ids=str)
def test_a_die_is_the_same_silicon_in_both(die: Die) -> None:
    bank = InstanceArray("chain", inverter_chain(), (2,), {"vdd": "vdd", "a": "a", "y": "y"})
    circuit = Circuit("bank", (VDD, Port("a", "event"), Port("y", "event", "out", (2,))), (), (bank,))
    found = compare(pulsed(circuit), Silicon(AMI_1500_IDEAL, die=die))
    assert found.agrees, found
    nominal = compare(pulsed(circuit), Silicon(AMI_1500_IDEAL))
    assert agreement.difference(found.solver, nominal.ngspice).share > 1.0


def test_every_device_type_has_a_small_circuit_here() -> None:
    assert set(DEVICE_TYPES) == {
        Transistor, Capacitor, Resistor, Diode, ControlledSource, OperationalAmplifier, Source,
    }, "a new device type: add its small circuit to this file"  # fmt: skip


def test_disagreement_is_told() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    testbench = pulsed(inverter_chain())
    ours = compare(testbench, silicon)
    loaded = engine.simulate(pulsed(inverter_chain((Capacitor("extra", "b", "0", 2e-13),))), silicon)
    apart = agreement.difference(ours.solver, loaded)
    assert apart.same_count
    assert apart.worst_rms > USUAL.node_rms
    assert apart.share > 1.0
    silent = replace(ours.solver, spikes={"y": np.zeros(0)})
    assert agreement.difference(silent, loaded).share == float("inf")
    assert not replace(ours, difference=apart).agrees
    assert not replace(ours, convergence=apart).agrees


def test_delays_follow_the_temperature() -> None:
    block: Block = load_block("rebound-neuron")
    nominal, cold, hot = (
        scaled_testbench(block, Silicon(AMI_1500_IDEAL, temperature_c=t)) for t in (27.0, -20.0, 85.0)
    )
    starts = [next(s for s in t.sources if s.name == "echo").waveform for t in (nominal, cold, hot)]
    delays = [w.starts[0] - 1e-3 for w in starts if isinstance(w, Pulse)]
    assert delays[0] == pytest.approx(6.4e-3)
    # at a fixed gate voltage a weak current moves by a factor of ten and more over either range
    assert delays[1] > 10.0 * delays[0]
    assert delays[2] < 0.15 * delays[0]
    assert {w.width for w in starts if isinstance(w, Pulse)} == {10e-6}
    assert cold.stop > nominal.stop >= hot.stop
    assert delay_ratio(load_block("centroid-board"), Silicon(AMI_1500_IDEAL, temperature_c=85.0)) == 1.0


def test_a_run_is_long_enough_for_the_blocks_own_delay() -> None:
    axon, cold = load_block("axon-delay"), Silicon(AMI_1500_IDEAL, temperature_c=-20.0)
    bench = scaled_testbench(axon, cold)
    assert bench.stop > 5.0 * scaled_testbench(axon, Silicon(AMI_1500_IDEAL)).stop
    assert simulate(bench, cold).spikes["delayed"].size == 1
