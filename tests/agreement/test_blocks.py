"""The solver agrees with ngspice: every block at one temperature, every device type in a small circuit."""

from __future__ import annotations

from collections.abc import Mapping
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
    OperationalAmplifier,
    Resistor,
    Source,
    Transistor,
)
from circuits.devices.device import Device
from circuits.devices.source import Constant, PiecewiseLinear, Pulse, Sampled
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, Process
from circuits.silicon.silicon import Silicon
from circuits.solver import operating_point as native
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from netlists.ngspice import agreement, engine
from netlists.ngspice.agreement import compare

pytestmark = pytest.mark.usefixtures("ngspice_library")

TEMPERATURES = (-20.0, 27.0, 85.0)  # degC; each block gets one, all of them `noctule reproduce agreement`
# The whole matrix runs whole testbenches, and shows that halving ngspice's tolerances moves nothing. What is
# allowed between the engines is the same here, where ngspice runs once, as finely as it takes to come that
# near: to behind the first spike, to behind two events where none comes, or for one call interval.
SHORTENED: Mapping[str, float] = {
    "axon-delay": 6.4e-3,
    "calcium-gate": 0.065,
    "centroid-board": 0.012,
    "coincidence-detector": 5e-3,
    "conductance-neuron": 7.5e-3,
    "delay-tap": 6.3e-3,
    "depressing-synapse": 6.5e-3,
    "dpi-synapse": 3.5e-3,
    "latency-neuron": 8.8e-3,
    "latency-unit": 69e-6,
    "lso-neuron": 6.9e-3,
    "plastic-synapse": 7.5e-3,
    "race-cell": 0.0215,
    "race-layer": 1.06e-3,
    "rebound-neuron": 3e-3,
    "rolls-neuron": 7e-3,
    "tonic-neuron": 0.0155,
    "vocalization-controller": 0.06,
    "wavefront-cell": 33e-6,
}
# reltol of ngspice, and its steps at least: with these the two differ by 0.7 of what is allowed or less.
COARSE = (3e-4, 200)
FINE: Mapping[str, tuple[float, int]] = {
    "axon-delay": (1e-3, 100),
    "centroid-board": (1e-5, 1_500),
    "coincidence-detector": (1e-3, 100),
    "dpi-synapse": (1e-3, 100),
    "envelope-detector": (5e-6, 2_000),
    "lso-neuron": (1e-4, 500),
    "plastic-synapse": (1e-3, 100),
    "race-layer": (1e-4, 500),
    "vocalization-controller": (1e-5, 1_500),
    "winner-take-all": (1e-4, 500),
}
# Blocks of several cells are small here, and quick by small capacitors, so that a spike comes within the run:
# one cell's race, its spike and the recurrent inhibition; the coincidence of A and B. Three cells, and two
# pings of a unit, are `benchmarks/latency_unit.py`'s. The centroid board averages two spikes in 5 ms.
SMALL: Mapping[str, Mapping[str, float]] = {
    "race-layer": {
        "membrane_capacitance": 0.1e-12, "timer_capacitance": 50e-15, "recurrent_capacitance": 50e-15,
        "cells": 1,
    },
    "latency-unit": {"membrane_capacitance": 0.5e-12, "timer_capacitance": 0.5e-12},
}  # fmt: skip
STIMULI: Mapping[str, Mapping[str, float | None]] = {
    "centroid-board": {"rate": 200.0},
    "race-layer": {"excite_0": None, "excite_1": None, "inhibit_1": None, "inhibit_2": None},
    "latency-unit": {"first": 60e-6, "integrating": 1e-3, "reset": None},
}
UM = 1e-6
V_DD = 5.0
SUPPLY = Source("vdd", "vdd", Constant(V_DD))
VDD = Port("vdd", "supply")


@pytest.mark.parametrize("name", block_names())
def test_every_block_agrees(name: str) -> None:
    testbench, silicon = bench_of(name)
    ours = simulate(testbench, silicon, rtol=agreement.SOLVER_RTOL)
    reltol, steps = FINE.get(name, COARSE)
    peer = engine.simulate(testbench, silicon, reltol=reltol, tmax=testbench.stop / steps)
    found = agreement.difference(ours, peer)
    assert found.share <= 1.0, (found, found.worst_node, found.worst_rms)
    assert found.excluded <= 0.1


def bench_of(name: str) -> tuple[Testbench, Silicon]:
    """A block's testbench at its temperature, made short, and begun in the solver's rest state."""
    block = load_block(name)
    silicon = Silicon(block.process, TEMPERATURES[block_names().index(name) % 3])
    bench = small(block, silicon) if name in STIMULI else agreement.scaled_testbench(block, silicon)
    bench = replace(bench, stop=min(bench.stop, SHORTENED.get(name, bench.stop)))
    return (agreement.started(bench, silicon) if bench.start else bench), silicon


def small(block: Block, silicon: Silicon) -> Testbench:
    circuit = block.build(block.params(**SMALL.get(block.name, {})))
    stimuli = block.defaults | STIMULI[block.name]
    return block.testbench(circuit, stimuli, silicon.process.v_dd)


@pytest.mark.parametrize("name", list(SMALL))
def test_small_blocks_spike_within_the_run(name: str) -> None:
    result = simulate(*bench_of(name))
    assert sum(times.size for times in result.spikes.values()) == 1


def varied(**changes: Any) -> Process:
    return replace(AMI_1500, n=replace(AMI_1500.n, **changes), p=replace(AMI_1500.p, **changes))


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


@pytest.mark.parametrize(
    "process",
    [
        AMI_1500,
        varied(law="ekv-gamma"),
        varied(early=0.05),
        varied(junction_leakage=1e-3),  # far above silicon's: 3 nA a junction, so that it matters here
        varied(law="ekv-gamma", early=0.03, junction_leakage=1e-4),
    ],
    ids=["ekv", "ekv-gamma", "early", "leakage", "all"],
)
@pytest.mark.parametrize("temperature", [-20.0, 85.0])
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
    silicon = Silicon(varied(law=law, early=0.02, junction_leakage=1e-9))
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
    found = compare(testbench, Silicon())
    assert found.agrees, found
    assert found.solver["y"].max() > 4.8


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
    found = compare(testbench, Silicon())
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
    found = compare(pulsed(circuit), Silicon())
    assert found.agrees, found
    assert len({float(t[0]) for t in found.solver.spikes.values()}) == 3


@pytest.mark.parametrize("die", [Die("A", 1003), Die("B", 7, corner="ss"), Die(corner="fs")], ids=str)
def test_a_die_is_the_same_silicon_in_both(die: Die) -> None:
    bank = InstanceArray("chain", inverter_chain(), (2,), {"vdd": "vdd", "a": "a", "y": "y"})
    circuit = Circuit("bank", (VDD, Port("a", "event"), Port("y", "event", "out", (2,))), (), (bank,))
    found = compare(pulsed(circuit), Silicon(die=die))
    assert found.agrees, found
    nominal = compare(pulsed(circuit), Silicon())
    assert agreement.difference(found.solver, nominal.ngspice).share > 1.0


def test_every_device_type_has_a_small_circuit_here() -> None:
    assert set(DEVICE_TYPES) == {
        Transistor, Capacitor, Resistor, ControlledSource, OperationalAmplifier, Source,
    }, "a new device type: add its small circuit to this file"  # fmt: skip


def test_disagreement_is_told() -> None:
    silicon = Silicon()
    testbench = pulsed(inverter_chain())
    ours = compare(testbench, silicon)
    loaded = engine.simulate(pulsed(inverter_chain((Capacitor("extra", "b", "0", 2e-13),))), silicon)
    apart = agreement.difference(ours.solver, loaded)
    assert apart.same_count
    assert apart.worst_rms > agreement.NODE_RMS
    assert apart.share > 1.0
    silent = replace(ours.solver, spikes={"y": np.zeros(0)})
    assert agreement.difference(silent, loaded).share == float("inf")
    assert not replace(ours, difference=apart).agrees
    assert not replace(ours, convergence=apart).agrees


def test_delays_follow_the_temperature() -> None:
    block: Block = load_block("rebound-neuron")
    nominal, cold, hot = (
        agreement.scaled_testbench(block, Silicon(temperature_c=t)) for t in (27.0, -20.0, 85.0)
    )
    starts = [next(s for s in t.sources if s.name == "echo").waveform for t in (nominal, cold, hot)]
    delays = [w.starts[0] - 1e-3 for w in starts if isinstance(w, Pulse)]
    assert delays[0] == pytest.approx(6.4e-3)
    # at a fixed gate voltage a weak current moves by a factor of ten and more over either range
    assert delays[1] > 10.0 * delays[0]
    assert delays[2] < 0.15 * delays[0]
    assert {w.width for w in starts if isinstance(w, Pulse)} == {10e-6}
    assert cold.stop > nominal.stop >= hot.stop
    assert agreement.delay_ratio(load_block("centroid-board"), Silicon(temperature_c=85.0)) == 1.0


def test_a_run_is_long_enough_for_the_blocks_own_delay() -> None:
    axon, cold = load_block("axon-delay"), Silicon(temperature_c=-20.0)
    bench = agreement.scaled_testbench(axon, cold)
    assert bench.stop > 5.0 * agreement.scaled_testbench(axon, Silicon()).stop
    assert simulate(bench, cold).spikes["delayed"].size == 1
