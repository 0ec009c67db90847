"""A plain circuit or testbench as a block: what it lacks of one comes by declared defaults.

A circuit without a testbench gets one. Its supplies carry the process's supply, but 0 V where their name
begins with `vss`, `vee` or `gnd`. Biases set their ports, an event comes in where a knob says when, and all
other inputs have a knob for their voltage. Output ports of events are watched. A testbench keeps its own
sources and its own end, unless the knob `duration` gives another.

What is measured is the same for all: of each node that is shown its lowest, highest, mean and last voltage,
or current where it stands for one (`circuits.measure.branch`), and of each watched one the number of spikes,
the time of the first and the rate by the last two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from math import isfinite
from typing import Any

import numpy as np

from circuits.blocks.arguments import Arguments
from circuits.blocks.block import DURATION, Block, Stimulus, Values, lasting
from circuits.blocks.measure import last_rate
from circuits.circuit import GROUND, Circuit, Port, references, split_reference
from circuits.devices.source import Constant, Source, Waveform
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.measure.branch import waveform
from circuits.silicon.process import AMI_1500, Process
from circuits.solver.transient import Result
from circuits.testbench import Testbench

STOP = 1e-3  # s, of a run that nothing else ends; ours
SHOWN = 8  # nodes at most that are measured and drawn by default; ours
_LOW = ("vss", "vee", "gnd")  # beginnings of names of supplies that are at 0 V
_RUN = lasting(STOP)

Made = Circuit | Testbench
Make = Callable[[Any, Values, float], Made]


def block_of(
    name: str, make: Make, arguments: Arguments, summary: str = "", process: Process = AMI_1500
) -> Block:
    """Give the block of a circuit or a testbench.

    Parameters
    ----------
    name, summary
        What it is called, and a line about it.
    make
        `make(params, knobs, v_dd)` gives the circuit or testbench for parameters, values of knobs by name,
        and a supply, V.
    arguments
        The parameters and knobs that `make` takes.
    process
        The process that its sizes are drawn for.
    """
    made = make(arguments.params, {}, process.v_dd)
    usual, circuit = arguments.params, circuit_of(made)

    def build(params: Any = usual) -> Circuit:
        return circuit_of(make(params, {}, process.v_dd))

    def testbench_of(params: Any) -> Callable[[Circuit, Values, float], Testbench]:
        return lambda inside, stimuli, v_dd: _driven(make, params, inside, stimuli, v_dd)

    knobs = (*_port_knobs(circuit), _RUN) if isinstance(made, Circuit) else _bench_knobs(made, arguments)
    shown = tuple(_shown(made))
    return Block(
        name, summary or f"a user's {'circuit' if isinstance(made, Circuit) else 'testbench'}",
        build, knobs, testbench_of(usual), measures, outcome, shown,
        process=process, testbench_of=testbench_of,
    )  # fmt: skip


def circuit_of(made: Made) -> Circuit:
    """The circuit itself, or that of a testbench."""
    return made if isinstance(made, Circuit) else made.circuit


def _port_knobs(circuit: Circuit) -> tuple[Stimulus, ...]:
    """A knob for each input port that no bias sets."""
    return tuple(_port_knob(port) for port in _inputs(circuit))


def _inputs(circuit: Circuit) -> Iterator[Port]:
    biased = {bias.port for bias in circuit.biases}
    return (port for port in circuit.ports if port.direction == "in" and port.name not in biased)


def _port_knob(port: Port) -> Stimulus:
    if port.kind == "supply":
        usual = "0 V" if port.name.lower().startswith(_LOW) else "the process's"
        return Stimulus(port.name, "V", None, f"supply at this port, {usual} if off", can_be_off=True)
    if port.kind == "event":
        return Stimulus(port.name, "s", None, "when an event comes in, none if off", can_be_off=True)
    return Stimulus(port.name, "V", None, "voltage at this port, must be given")


def _bench_knobs(bench: Testbench, arguments: Arguments) -> tuple[Stimulus, ...]:
    named = {knob.name for knob in arguments.knobs} | {f.name for f in fields(arguments.params)}
    end = DURATION if isfinite(bench.stop) else _RUN
    return arguments.knobs if end.name in named else (*arguments.knobs, end)


def _driven(make: Make, params: Any, circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The testbench of a circuit that `make` has made, in whatever place and under whatever biases."""
    made = make(params, stimuli, v_dd)
    if isinstance(made, Circuit):
        sources = tuple(Source(p.name, p.name, _wave(p, stimuli, v_dd)) for p in _inputs(circuit))
        watch = tuple(p.name for p in circuit.ports if (p.kind, p.direction) == ("event", "out"))
        return Testbench(circuit.name, circuit, sources, stimuli["duration"] or 0.0, watch)
    if stimuli and repr(made.circuit) != repr(circuit_of(make(params, {}, v_dd))):
        raise ParameterError(
            f"{circuit.name}: a stimulus changes the circuit, must change its sources alone; put what does so"
            " before the * of the function's arguments, where it is a parameter"
        )
    stop = stimuli.get("duration") or made.stop
    return replace(made, circuit=circuit, stop=stop)


def _wave(port: Port, stimuli: Values, v_dd: float) -> Waveform:
    """What drives an input of a circuit without a testbench."""
    value = stimuli[port.name]
    if port.kind == "event":
        return pulse(() if value is None else (value,), v_dd)
    if port.kind == "supply" and value is None:
        value = 0.0 if port.name.lower().startswith(_LOW) else v_dd
    if value is None:
        raise ParameterError(
            f"{port.name}: nothing drives it, must have a voltage; give stimulus {port.name}=VALUE, return a"
            f' testbench that drives it, or declare Port("{port.name}", "{port.kind}", "out")'
        )
    return Constant(value)


def _shown(made: Made) -> list[str]:
    """Nodes that are drawn and measured: watched ones and outputs, else those that nothing drives."""
    circuit = circuit_of(made)
    watched = made.watch if isinstance(made, Testbench) else ()
    outputs = [e for p in circuit.ports if p.direction == "out" for e in p.elements()]
    by_port = {p.name: p.elements() for p in circuit.ports}
    chosen = [*(e for name in watched for e in by_port.get(name, [name])), *outputs]
    if not chosen:
        sources = made.sources if isinstance(made, Testbench) else ()
        driven = {s.node for s in sources if s.quantity == "voltage"}
        # by a current alone, which leaves the voltage to the circuit
        fed = {s.node for s in sources} - driven
        fixed = driven | {p.name for p in _inputs(circuit)} - fed | {bias.port for bias in circuit.biases}
        arrays = {name for name, shape in circuit.shapes().items() if shape}
        chosen = [node for _, node in references(circuit) if node not in {GROUND, *fixed, *arrays}]
    return list(dict.fromkeys(chosen))[:SHOWN]


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run by name: of the nodes that are shown, V or A, and spikes of the watched ones."""
    numbers: dict[str, float | None] = {}
    for port, spikes in result.spikes.items():
        key = _key(port)
        numbers[f"{key}_spikes"] = float(spikes.size)
        numbers[f"{key}_first_s"] = float(spikes[0]) if spikes.size else None
        numbers[f"{key}_rate_Hz"] = last_rate(spikes)
    for node in _shown(result.machine.testbench):
        told = waveform(result, node)
        v = told.values
        mean = float(np.trapezoid(v, result.time) / (result.time[-1] - result.time[0]))
        found = {"min": float(v.min()), "max": float(v.max()), "mean": mean, "last": float(v[-1])}
        numbers |= {f"{_key(told.key)}_{word}_{told.unit}": value for word, value in found.items()}
    return numbers


def outcome(result: Result) -> str:
    """`spikes` or `silent` of a run with watched nodes, else `ran`."""
    if not result.spikes:
        return "ran"
    return "spikes" if any(times.size for times in result.spikes.values()) else "silent"


def _key(node: str) -> str:
    name, index = split_reference(node)
    return "_".join([name, *map(str, index)])
