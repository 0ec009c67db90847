"""A range-tuned neuron of an approach's chip by its transistors, driven by what the chip heard in the run."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from chips.polyline import thin
from chips.ranging import circuit as ranging_chip
from chips.ranging.calibration.found import values_of
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.sonar.first_target_isolation import V_EX_MAX
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, PiecewiseLinear, Pulse
from circuits.event import EDGE, WIDTH
from circuits.place import circuit_at
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from system.approach.loop import CHIP_RTOL, trimmed
from system.approach.trace import Trace
from system.view.devices import devices_of
from system.view.film import Line, Neuron, Panel

NODES = ("v_mem", "membrane.v_r", "excitation.v_ex", "inhibition.v_inh", "spike")
"""Nodes of a neuron that a page shows."""

TOLERANCE = 1e-3  # V by which a waveform of a page may be off; ours


def looked_into(trace: Trace, name: str) -> Neuron:
    """Return a neuron, `neuron[2]`, with its devices and its nodes over the run."""
    k = int(name[name.index("[") + 1 : -1])
    circuit, silicon, _ = neuron_of(trace, k)
    array = ((ranging_chip.build().name, ()), ("neuron", (ranging_chip.NEURONS,)))
    return Neuron(
        name=name,
        devices=devices_of(circuit, replace(silicon, place=None), array, k),
        waveform=_waveform(trace, circuit, silicon, name),
    )


def neuron_of(trace: Trace, k: int) -> tuple[Circuit, Silicon, str]:
    """Return the circuit of a neuron by its number, the silicon with its place, and its path on a die."""
    s = trace.scenario
    chip = rebias(ranging_chip.build(), values_of(s.ranging_codes), s.bias_kind)
    circuit, place = circuit_at(chip, (("neuron", (k,)),))
    return circuit, replace(s.silicon_at(s.beginning_c), place=place), f"{chip.name}/neuron[{k}]"


def bench_of(trace: Trace, circuit: Circuit, silicon: Silicon, begin: float, end: float) -> Testbench:
    """Return a neuron's testbench with the calls and echoes of a stretch of the run, s, which begins at 0."""
    s, v_dd = trace.scenario, silicon.process.v_dd
    sources = [Source("vdd", "vdd", Constant(v_dd))]
    for port, times in (("call", trace.pulses), ("echo", trace.echoes)):
        on = tuple(float(t - begin) for t in times if begin <= t < end - 2 * WIDTH)
        sources.append(Source(port, port, Pulse(0.0, v_dd, on, WIDTH, EDGE, EDGE) if on else Constant(0.0)))
    if s.isolation:
        volts = trimmed(s)
        circuit = replace(circuit, biases=tuple(b for b in circuit.biases if b.port != "v_ex_max"))
        times, values = _isolated(trace, V_EX_MAX if volts is None else volts, v_dd)
        inner = times > begin
        first = float(values[~inner][-1]) if (~inner).any() else float(values[0])
        shut = PiecewiseLinear((0.0, *(times[inner] - begin)), (first, *values[inner]))
        sources.append(Source("v_ex_max", "v_ex_max", shut))
    return Testbench(circuit.name, circuit, tuple(sources), end - begin, watch=("spike",))


def _isolated(trace: Trace, opened: float, v_dd: float) -> tuple[F64, F64]:
    """Times (s) and voltages (V) of v_ex_max: the supply from a call's first spike to the next call."""
    spikes = np.sort([time for time, _ in trace.spikes])
    times, volts, shut = [0.0], [opened], False
    for begin, end in pairwise((*trace.pulses, np.inf)):
        if shut:
            times += [float(begin), float(begin) + EDGE]
            volts += [v_dd, opened]
        first = np.searchsorted(spikes, begin, side="right")
        shut = bool(first < spikes.size and spikes[first] < end)
        if shut:
            times += [float(spikes[first]), float(spikes[first]) + EDGE]
            volts += [opened, v_dd]
    return np.array(times), np.array(volts)


def waveform(name: str, time: F64, volts: F64) -> Line:
    """Return a waveform, s and V, float64[n], without the points that a straight line tells as well."""
    times, values = thin(time, volts, TOLERANCE)
    return Line(name=name, time=times, value=values)


def _waveform(trace: Trace, circuit: Circuit, silicon: Silicon, name: str) -> Panel:
    """The nodes of a neuron of transistors, noiseless, while it gets the calls and echoes of the run."""
    bench = bench_of(trace, circuit, silicon, 0.0, trace.scenario.duration)
    found = simulate(bench, silicon, rtol=CHIP_RTOL, record=NODES)
    lines = tuple(waveform(node, found.time, found[node]) for node in NODES)
    return Panel(title=f"{name} at transistor level, noiseless, driven by this run", unit="V", lines=lines)
