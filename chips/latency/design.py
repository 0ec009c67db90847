"""The design of a latency chip: sizes, times and weights, and the bias currents that give them.

Every time on the chip is a charge over a current (`chips.latency.measure`), so that a bias is the nominal
charge over the time that is wanted, at 27 degC. A bias line is one current for all its devices, or one for
each of an array of copies: the taps, the integrating neurons, the passive currents, the charges of the goal
by distance, the inhibitions by distance, the second layer's groups.

Codes are those of the bias generator (`circuits.blocks.bias.generator`), coarse and fine.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType

import numpy as np

from circuits.arrays import F64, I64
from circuits.bias import bias_voltages
from circuits.blocks.mos import mos
from circuits.circuit import Bias, BiasKind, Circuit, Port, PortKind
from circuits.count import whole_number
from circuits.errors import ParameterError
from circuits.event import WIDTH
from circuits.generator.code import codes_of, currents_of
from circuits.silicon.process import Polarity
from circuits.silicon.silicon import Silicon
from circuits.units import quantity

REACH = 3  # paths on either side that a memory inhibits: three standard deviations of 1
SYNAPSES = 8  # of an integrating neuron; ours, what is more is counted
REFERENCE = 2.0  # V, of all comparators
NAME = "latency_chip"


@dataclass(frozen=True, slots=True)
class Design:
    """What a latency chip is designed for: times in s, charges and inhibitions in thresholds of the race.

    The numbers are those of the network unless said.

    Attributes
    ----------
    group : tuple of int
        Ping direction of each path.
    share : tuple of float
        Passive current of each path over the largest, a ratio.
    second : tuple of float
        Delay of the second layer in each group, s.
    taps : int
        How many taps the delay line has, and units a memory.
    lead, hop : float
        Delays before its first tap and between two, s. The lead is ours: the network's neurons take that much
        longer from a tap to the memory's spike than this chip's.
    step, integration, window, tonic, hold, block : float
        Times of a memory's steps, integrating neuron, detectors and inhibition, s.
    race : float
        Latency of a cell of the largest passive current, s.
    goal, direction : float
        Charges of the goal and of the ping direction, in units of the threshold.
    goal_sigma : float
        Reach of the goal, a number of paths.
    pulse : float
        Length of the pulses of these charges, s.
    suppression : float
        Inhibition of other paths, in units of the threshold.
    suppression_sigma : float
        Reach of this inhibition, a number of paths.
    inhibition, recurrent, emergency : float
        Times of the inhibition, of the recurrent spikes and of the emergency neuron, s.

    Raises
    ------
    ParameterError
        What cannot be built; the text names it.
    """

    group: tuple[int, ...]
    share: tuple[float, ...]
    second: tuple[float, ...]
    taps: int = quantity(15, "")
    lead: float = quantity(4.6e-3, "s")
    hop: float = quantity(3e-3, "s")
    step: float = quantity(20e-3, "s")
    integration: float = quantity(8e-3, "s")
    window: float = quantity(3e-3, "s")
    tonic: float = quantity(10e-3, "s")
    hold: float = quantity(177e-3, "s")
    block: float = quantity(20e-3, "s")
    race: float = quantity(58e-3, "s")
    goal: float = quantity(0.08, "")
    goal_sigma: float = quantity(8.0, "")
    direction: float = quantity(0.1, "")
    pulse: float = quantity(2e-3, "s")
    suppression: float = quantity(0.21, "")
    suppression_sigma: float = quantity(1.0, "")
    inhibition: float = quantity(100e-3, "s")
    recurrent: float = quantity(1.35e-3, "s")
    emergency: float = quantity(68e-3, "s")

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming what cannot be built."""
        if len(self.group) != len(self.share) or not self.group:
            raise ParameterError(
                f"latency_chip.paths: {len(self.group)} groups and {len(self.share)} passive currents, must"
                " be as many, and one at least"
            )
        whole_number("latency_chip.taps", self.taps)
        if not 0 <= min(self.group) <= max(self.group) < len(self.second):
            raise ParameterError(f"latency_chip.group: must be 0 to {len(self.second) - 1}, as `second` has")
        for each in fields(self):
            value = getattr(self, each.name)
            for number in np.ravel(value) if each.name != "group" else ():
                if not (math.isfinite(number) and number > 0.0):
                    raise ParameterError(f"latency_chip.{each.name}: {number:g}, must be > 0 and finite")

    @property
    def paths(self) -> int:
        """Number of memories, one for each path."""
        return len(self.group)

    @property
    def span(self) -> float:
        """Latency of the last tap of the delay line, s."""
        return self.lead + self.taps * self.hop


@dataclass(frozen=True, slots=True)
class Line:
    """A bias line: polarity of its devices, current (A, of the shape of their array) and size (um)."""

    polarity: Polarity
    current: F64  # A, shape of its array, () for one
    size: tuple[float, float] = (6.0, 24.0)


Lines = Mapping[str, Line]


@dataclass(frozen=True, slots=True)
class Charges:
    """Nominal charges to a threshold at 27 degC, C; pulse_width: of a tap's event, s."""

    timer: float
    tap: float
    tonic: float
    integrating: float
    race: float
    second: float
    recurrent: float
    pulse_width: float


def lines_of(design: Design, q: Charges) -> dict[str, Line]:
    """Return the bias lines of a design, by name, with the currents of the nominal die."""
    d, one = design, np.ones(())
    race = q.race / d.race
    apart = np.arange(REACH + 1)
    weight = np.exp(-(apart**2) / (2.0 * d.suppression_sigma**2))
    reach = np.arange(d.paths)
    goal = d.goal * np.exp(-(reach**2) / d.goal_sigma**2)
    hops, held = np.full(d.taps + 1, d.hop), np.full(d.taps + 1, q.pulse_width)
    hops[0], held[0] = d.lead, WIDTH
    return {
        "tap": Line("p", q.tap / (hops - held)),
        "integrating": Line("p", np.full(d.paths, q.integrating / d.integration)),
        "step": Line("p", q.timer / d.step * one),
        "cd": Line("p", 25e-9 * one),
        "window": Line("p", q.timer / d.window * one),
        "tonic": Line("p", q.tonic / d.tonic * one),
        "hold": Line("p", q.timer / d.hold * one),
        "block": Line("p", q.timer / d.block * one),
        "passive": Line("p", race * np.array(d.share)),
        "goal": Line("p", goal * q.race / d.pulse),
        "direction": Line("p", d.direction * q.race / d.pulse * one),
        "pulse": Line("p", q.timer / d.pulse * one),
        "inhibit": Line("n", d.suppression * race * weight),
        "inhibition": Line("p", q.timer / d.inhibition * one),
        "second": Line("p", q.second / np.array(d.second)),
        "kept": Line("p", q.timer / d.inhibition * one),
        "recurrent": Line("p", np.full(2, q.recurrent / d.recurrent)),
        "emergency": Line("p", q.race / d.emergency * one),
        "comparator": Line("n", 50e-9 * one, (6.0, 6.0)),
    }


@dataclass(frozen=True, slots=True)
class Biases:
    """Bias lines of a chip, and how their currents are made: by fixed gates, or as ideal currents.

    codes: coarse and fine codes of those lines that were set by codes, int64[..., 2].
    """

    lines: Lines
    kind: BiasKind = "gate"
    codes: Mapping[str, I64] = field(default_factory=lambda: MappingProxyType({}))

    def with_currents(self, currents: Mapping[str, F64]) -> Biases:
        """Return the biases with other currents (A) of some lines, as near as codes of the generator come."""
        codes = dict(self.codes)
        lines = dict(self.lines)
        for name, wanted in currents.items():
            codes[name] = codes_of(wanted)
            lines[name] = replace(lines[name], current=currents_of(codes[name]))
        return replace(self, lines=lines, codes=codes)


def gate_voltages(biases: Biases, silicon: Silicon) -> dict[str, F64]:
    """Return the voltages of all bias lines above the bulk's rail, V, of each line's shape.

    Copies of ideal biases stand on the silicon's die; a fixed gate knows neither die nor temperature.
    """
    circuit = bias_circuit(biases)
    v_dd = silicon.process.v_dd
    found = {}
    for bias in circuit.biases:
        volts = bias_voltages(circuit, bias, silicon)
        name = bias.name.removeprefix("i_")
        found[name] = v_dd - volts if biases.lines[name].polarity == "p" else volts
    return found


def bias_circuit(biases: Biases) -> Circuit:
    """Return a circuit with a port and a device `m_LINE` for each line, which stand for all of it."""
    ports, devices, made = [Port("vdd", "supply")], [], []
    kind: PortKind = "bias"
    for name, line in biases.lines.items():
        shape = line.current.shape
        ports.append(Port(f"v_{name}", kind, "in", shape))
        gate = f"v_{name}[0]" if shape else f"v_{name}"
        rail = "vdd" if line.polarity == "p" else "0"
        devices.append(mos(f"m_{name}", line.polarity, f"d_{name}", gate, rail, *line.size))
        value = tuple(map(float, line.current)) if shape else float(line.current)
        made.append(Bias(f"i_{name}", f"v_{name}", biases.kind, value, f"m_{name}"))
    return Circuit(NAME, tuple(ports), tuple(devices), biases=tuple(made))
