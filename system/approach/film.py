"""An approach as a film: ranges, boards, calls and echoes, spikes, and what is inside each neuron."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from chips.ranging import circuit as ranging_chip
from chips.ranging.calibration.found import values_of
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
from system.view.film import (
    Film,
    Line,
    Neuron,
    Panel,
    Raster,
    Shape,
    Stage,
    Track,
    busiest,
    merged,
)
from system.worlds.sound.targets import range_at


def film(trace: Trace, asked: tuple[str, ...] | None) -> Film:
    """Return the film of a run with what is inside the neurons that are asked for.

    asked: names of neurons; None for the `MOST` that spike most.
    """
    s = trace.scenario
    spikes = np.array(trace.spikes, dtype=np.float64).reshape(-1, 2)
    spikes = spikes[np.argsort(spikes[:, 0], kind="stable")]
    rows = tuple(f"neuron[{k}]" for k in range(ranging_chip.NEURONS))
    time = trace.time_s
    heard = merged((trace.calls[:, 0], trace.pulses, trace.echoes))
    return Film(
        title="",
        headline="",
        duration=s.duration,
        world=_world(trace),
        panels=(
            Panel(
                title="range",
                unit="m",
                lines=(
                    Line(name="first target", time=time, value=trace.range_m),
                    Line(name="estimate", time=time, value=trace.estimate_m),
                ),
            ),
            Panel(
                title="range-tuned neurons",
                raster=Raster(time=spikes[:, 0], row=spikes[:, 1].astype(np.int64), rows=rows),
            ),
            Panel(
                title="calls and what is heard",
                raster=Raster(time=heard[0], row=heard[1], rows=("call", "chip's call", "chip's echo")),
            ),
            Panel(
                title="proximity voltage",
                unit="V",
                lines=(Line(name="centroid board", time=time, value=trace.proximity_V),),
            ),
            Panel(
                title="call rate",
                unit="Hz",
                lines=(Line(name="vocalization board", time=time, value=trace.call_rate_Hz, step=True),),
            ),
        ),
        neurons=tuple(_neuron(trace, name) for name in busiest(rows, spikes[:, 1], asked)),
    )


def _world(trace: Trace) -> Stage:
    """The line of sight: the bat at 0, its targets on it, and where it takes the first one to be."""
    time, s = trace.time_s, trace.scenario
    zero = np.zeros(time.size)
    targets = [(t.name, range_at(t.trajectory, time)) for t in s.targets]
    farthest = max(float(np.max(r)) for _, r in targets)
    return Stage(
        unit="m",
        shapes=(
            Shape(
                role="floor",
                points=((-0.2, -0.5), (farthest + 0.3, -0.5), (farthest + 0.3, 0.5), (-0.2, 0.5)),
            ),
            Shape(role="way", points=((0.0, 0.0), (farthest, 0.0)), closed=False, name="line of sight"),
        ),
        tracks=(
            Track(name="bat", time=time, x=zero, y=zero, heading=zero, radius=0.08),
            *(Track(name=n, time=time, x=r, y=zero, radius=0.1, role="moving") for n, r in targets),
            Track(name="estimate", time=time, x=trace.estimate_m, y=zero - 0.25, radius=0.05),
        ),
    )


def _neuron(trace: Trace, name: str) -> Neuron:
    s, k = trace.scenario, int(name[name.index("[") + 1 : -1])
    silicon = s.silicon_at(s.beginning_c)
    chip = rebias(ranging_chip.build(), values_of(s.ranging_codes), s.bias_kind)
    circuit, place = circuit_at(chip, (("neuron", (k,)),))
    array = ((chip.name, ()), ("neuron", (ranging_chip.NEURONS,)))
    return Neuron(
        name=name,
        devices=devices_of(circuit, silicon, array, k),
        waveform=_waveform(trace, circuit, replace(silicon, place=place), name),
    )


def _isolated(trace: Trace, opened: float, v_dd: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
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
    return tuple(times), tuple(volts)


def _waveform(trace: Trace, circuit: Circuit, silicon: Silicon, name: str) -> Panel:
    """The nodes of a neuron of transistors, noiseless, while it gets the calls and echoes of the run."""
    s, v_dd = trace.scenario, silicon.process.v_dd
    waves = {"call": trace.pulses, "echo": trace.echoes}
    sources = [Source("vdd", "vdd", Constant(v_dd))]
    for port, times in waves.items():
        on = tuple(float(t) for t in times if t + 2 * WIDTH < s.duration)
        sources.append(Source(port, port, Pulse(0.0, v_dd, on, WIDTH, EDGE, EDGE) if on else Constant(0.0)))
    if s.isolation:
        volts = trimmed(s)
        circuit = replace(circuit, biases=tuple(b for b in circuit.biases if b.port != "v_ex_max"))
        shut = PiecewiseLinear(*_isolated(trace, V_EX_MAX if volts is None else volts, v_dd))
        sources.append(Source("v_ex_max", "v_ex_max", shut))
    bench = Testbench(name, circuit, tuple(sources), s.duration, watch=("spike",))
    nodes = ("v_mem", "membrane.v_r", "excitation.v_ex", "inhibition.v_inh", "spike")
    found = simulate(bench, silicon, rtol=CHIP_RTOL, record=nodes)
    lines = tuple(Line(name=node, time=found.time, value=found[node]) for node in nodes)
    return Panel(title=f"{name} at transistor level, noiseless, driven by this run", unit="V", lines=lines)
