"""Parts of the latency chip at their places: testbenches at transistor level with the chip's own biases.

A block that stands at a place of the chip has the devices of that place, and its bias ports the voltages of
the chip's lines, so that the solver runs the very part whose lumped numbers `chips.latency.model` makes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from chips.latency.design import NAME, REFERENCE, Biases, gate_voltages
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Pulse, Waveform
from circuits.event import EDGE, WIDTH
from circuits.silicon.die import Place
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

# which line each port of a part takes, and which element of it, where it is an array: None the part's own
Wires = Mapping[str, str]
UNIT_WIRES: Wires = {
    "v_exc": "cd", "v_window": "window", "v_tonic": "tonic", "v_hold": "hold", "v_block": "block",
    "v_cmp": "comparator",
}  # fmt: skip
INHIBITION_WIRES: Wires = {"v_tonic": "tonic", "v_hold": "hold", "v_cmp": "comparator"}
TAP_WIRES: Wires = {"v_tap": "tap", "v_cmp": "comparator"}
NEURON_WIRES: Wires = {"v_exc": "integrating", "v_step": "step", "v_cmp": "comparator"}
RACE_WIRES: Wires = {
    "v_passive": "passive", "v_charge": "goal", "v_pulse": "pulse", "v_inh": "inhibit",
    "v_hold": "inhibition", "v_cmp": "comparator",
}  # fmt: skip


def standing(silicon: Silicon, *parts: tuple[str, tuple[int, ...]]) -> Silicon:
    """Return the silicon with a place on the chip; parts: names and indices of the instances on the way."""
    place: Place = ((NAME, ()), *parts)
    return replace(silicon, place=place)


def line_volts(
    biases: Biases, silicon: Silicon, wires: Wires, element: Mapping[str, int]
) -> dict[str, float]:
    """Return the voltages of a part's bias ports from ground, V.

    wires: line of each port; element: which one, of a line that is an array.
    """
    gates = gate_voltages(biases, silicon)
    found = {"v_ref": REFERENCE}
    for port, name in wires.items():
        gate = float(np.ravel(gates[name])[element.get(name, 0)])
        found[port] = silicon.process.v_dd - gate if biases.lines[name].polarity == "p" else gate
    return found


def bench_at(
    title: str,
    circuit: Circuit,
    volts: Mapping[str, float],
    events: Mapping[str, Sequence[float]],
    stop: float,
    v_dd: float,
    watch: tuple[str, ...] = ("spike",),
) -> Testbench:  # fmt: skip
    """Return the testbench of a part: its bias ports held, events (s) at its event ports.

    A tonic neuron begins balanced at its reference, and stays there until the reset that runs begin with.
    volts: by bias port, V; events: by event port, none at the others; stop: s; watch: ports whose spikes are
    kept.
    """
    sources = [Source("vdd", "vdd", Constant(v_dd))]
    sources += [Source(port, port, Constant(v)) for port, v in volts.items()]
    for port in circuit.ports:
        if port.kind != "event" or port.direction == "out":
            continue
        for name in port.elements():
            times = tuple(sorted(events.get(name, ())))
            wave: Waveform = Pulse(0.0, v_dd, times, WIDTH, EDGE, EDGE) if times else Constant(0.0)
            sources.append(Source(name, name, wave))
    return Testbench(title, circuit, tuple(sources), stop, watch=watch, begin="at_rest")
