"""The chip's silicon and its bench for values of what is not known: process, die, biases and readings."""

from __future__ import annotations

import functools
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.bias import gate_voltage
from circuits.circuit import Circuit
from circuits.devices import Source, Transistor
from circuits.devices.source import Constant, polyline
from circuits.errors import SolverError
from circuits.extraction.coach.conditions import V_DD, BiasSetting, Condition
from circuits.extraction.coach.unknown import Theta, Unknown
from circuits.lowering.kernel import Machine, on_silicon, to_kernel
from circuits.measure.current import static_currents
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.edit import Edit
from circuits.silicon.process import POLARITIES, Polarity, Process, TransistorModel
from circuits.silicon.silicon import Silicon
from circuits.silicon.size import SizeTerms
from circuits.solver.newton import allocate
from circuits.solver.operating_point import operating_point, rest_state
from circuits.solver.sweep.continuation import with_source
from circuits.testbench import Testbench

ADC = 3.3 / 4096  # V, a step of the 12-bit converter
BUFFER_LOW, BUFFER_HIGH = 0.013, 1.781  # V, what the buffer reads at the rails
SECONDS = 0.1  # s, for which events are counted
DARK = 3.0  # counts in that time without a current
_OUTPUT = 4.0 / 12.0  # W / L of the bias generator's output device
_UM = 1e-6
_DECADES = 10.0 ** -np.arange(3.0, 20.0)
_BOX = (0.1e-6, 100e-6, 0.1e-6, 100e-6)
_LOGARITHMS = ("mu_cox", "early_field")
_NOTHING = Constant(0.0)
_KEPT = 64  # sweeps and circuits; ours

LUMPED = ("adaptive_neuron", "axon_hillock", "bench_dpi_synapse")
"""Circuits that were themselves fitted, with nuisances that hold what their own devices deviate by."""

MODEL: tuple[tuple[str, float, str], ...] = (
    ("v_t0", 0.05, "V"), ("kappa", 0.05, ""), ("mu_cox", 0.5, "ln"), ("mobility_reduction", 0.6, "1/V"),
    ("early_field", 0.7, "ln"), ("early_rise", 0.15, ""), ("surface_potential", 0.05, "V"),
)  # fmt: skip
"""Numbers of a transistor model that are fitted, their spread before and its unit; spreads are ours."""
_NOT_BELOW_ZERO = tuple(name for name, _, _ in MODEL if name not in _LOGARITHMS)
SIZE: tuple[tuple[str, int, float, float, str], ...] = (
    ("v_t0", 0, _UM, 0.03, "V um"), ("v_t0", 2, _UM, 0.01, "V um"), ("kappa", 0, _UM, 0.03, "um"),
    ("early_field", 0, _UM, 0.3e6, "V"),
)  # fmt: skip
"""Terms of the size: number, place of its coefficient, unit of length, spread and unit; ours."""
_POWER = {0: "1/L", 2: "1/W"}
MASTER_FACTORS: Mapping[str, tuple[float, float]] = {
    "60 pA": (0.0, 0.3), "460 pA": (0.1, 0.25), "3.8 nA": (0.2, 0.4), "30 nA": (-0.25, 0.25),
    "240 nA": (0.0, 0.5),
}  # fmt: skip
"""Logarithm of the factor of each master current for w = 3 W / L, and its spread; ours."""


def process_unknowns(base: Process) -> Iterator[Unknown]:
    """Numbers of the process that are fitted, about those of a process."""
    for polarity in POLARITIES:
        model = base.model(polarity)
        for name, sd, unit in MODEL:
            value = getattr(model, name)
            mean = math.log(value) if name in _LOGARITHMS else value
            yield Unknown(f"{polarity}.{name}", mean, sd, unit, "process")
        for name, place, length, sd, unit in SIZE:
            mean = 0.0 if model.size is None else getattr(model.size, name)[place] / length
            yield Unknown(f"{polarity}.{name} {_POWER[place]}", mean, sd, unit, "process")


def bench_unknowns() -> Iterator[Unknown]:
    """Nuisances that all measurements share."""
    yield Unknown("temperature_c", 25.0, 2.5, "degC", "nuisance", "a laboratory's room; ours")
    for master, (mean, sd) in MASTER_FACTORS.items():
        yield Unknown(f"s {master}", mean, sd, "ln", "nuisance", "absolute scale of a master current")
    yield Unknown("dac offset", 0.0, 2e-3, "V", "nuisance", "within 5 mV of nothing")
    yield Unknown("adc offset", 0.0, 1.5e-3, "V", "nuisance")
    yield Unknown("adc scale", 0.002, 0.002, "", "nuisance", "the reference is 3.3 or 3.313 V")


def process_of(
    theta: Mapping[str, float], base: Process, polarities: Sequence[Polarity] = POLARITIES
) -> Process:
    """The process whose numbers of some polarities are those of `theta`, all others those of `base`."""
    models: dict[str, Any] = {p: _model(theta, p, base.model(p)) for p in polarities}
    return replace(base, **models)


def bounded(name: str, value: F64) -> F64:
    """Values of an unknown as a process has them: what is below zero is zero where no process can be below.

    Of a normal spread about a small number, as that of the mobility reduction, a part is below zero.
    """
    return np.maximum(value, 0.0) if name.partition(".")[2] in _NOT_BELOW_ZERO else value


def _model(theta: Mapping[str, float], polarity: Polarity, base: TransistorModel) -> TransistorModel:
    plain = {name: theta[f"{polarity}.{name}"] for name, _, _ in MODEL}
    plain = {n: max(x, 0.0) if n in _NOT_BELOW_ZERO else math.exp(x) for n, x in plain.items()}
    size = base.size or SizeTerms(*_BOX)
    terms: dict[str, Any] = {}
    for name, place, length, _, _ in SIZE:
        found = list(terms.get(name, getattr(size, name)))
        found[place] = theta[f"{polarity}.{name} {_POWER[place]}"] * length
        terms[name] = tuple(found)
    return replace(base, law="ekv-gamma", size=replace(size, **terms), **plain)


def code_name(circuit: str, bias: BiasSetting) -> str:
    """The unknown error of a code, which measurements of a circuit at that code share."""
    return f"{circuit} {bias.name} {bias.master} code {bias.fine}"


def code_unknowns(
    circuit: str, conditions: Iterable[Condition], sd: float, without: Collection[str] = ()
) -> Iterator[Unknown]:
    """Errors of all codes of some measurements but those of biases that are named.

    circuit: how their names begin; sd: of the logarithm of a current.
    """
    lines = (bias for each in conditions for bias in each.biases if bias.name not in without)
    for name in dict.fromkeys(code_name(circuit, bias) for bias in lines):
        yield Unknown(name, 0.0, sd, "ln", "nuisance", "error of the code")


@dataclass(frozen=True, slots=True)
class Bench:
    """The chip on its bench for values of what is not known.

    theta: the values. base: what is not fitted of the process. die: how devices deviate whose deviation is no
    unknown; the nominal die for none.
    """

    theta: Theta
    base: Process
    die: Die = NOMINAL

    def process(self, polarities: Sequence[Polarity] = POLARITIES) -> Process:
        """The process, of which only the given polarities are looked at."""
        return process_of(self.theta, self.base, polarities)

    def silicon(self, circuit: str, polarities: Sequence[Polarity] = POLARITIES) -> Silicon:
        """The silicon of a circuit, its identified devices with their deviations."""
        start = f"{circuit}."
        edits = tuple(
            Edit("set", (name.rpartition(".")[0],), name.rpartition(".")[2], self.theta[name])
            for name in self.theta
            if name.startswith(start)
        )
        drawn = NOMINAL if circuit in LUMPED else self.die
        die = replace(drawn, edits=edits) if edits else drawn
        return Silicon(self.process(polarities), self.theta["temperature_c"], die)

    def current(self, bias: BiasSetting, square: float, fine: float | None = None) -> float:
        """Current of a bias in a device of W / L = `square`, A: `w fine / 256 I_master`, w = 3 W / L."""
        code = bias.fine if fine is None else fine
        nominal = square / _OUTPUT * (code or 0.0) / 256.0 * bias.master_current
        return nominal * math.exp(self.theta[f"s {bias.master}"])

    def gate(self, bias: BiasSetting, device: Transistor, fine: float | None = None) -> float:
        """Voltage of a bias line at its output device, V: `device` is of the output device's polarity.

        A fine code of 0 parks the line at the rail of its type.
        """
        code = bias.fine if fine is None else fine
        if not code:
            return V_DD if bias.type == "P" else 0.0
        silicon = Silicon(self.process((device.polarity,)), self.theta["temperature_c"])
        magnitude = gate_voltage(
            silicon.law(device.polarity), device, self.current(bias, device.square, fine)
        )
        return V_DD - magnitude if device.polarity == "p" else magnitude

    def counts(self, current: F64, charge: float, dead: float, seconds: float = SECONDS) -> F64:
        """Events that a converter counts in a time: `t / (Q / I + t_d)` and the dark ones."""
        flow = np.maximum(current, 1e-18)
        return seconds / (charge / flow + dead) + DARK * seconds / SECONDS

    def adc(self, voltage: F64) -> F64:
        """What the converter behind the buffer reads, V."""
        read = (voltage + self.theta["adc offset"]) * (1.0 - self.theta["adc scale"])
        return np.clip(read, BUFFER_LOW, BUFFER_HIGH)


@dataclass(frozen=True, slots=True, eq=False)
class Swept:
    """Operating points: voltages by node and currents by device or source, float64[points] each."""

    voltage: Mapping[str, F64]
    current: Mapping[str, F64]


def swept(machine: Machine, over: Mapping[str, F64]) -> Swept:
    """Operating points while several sources move together, each looked for near the one before.

    Parameters
    ----------
    machine
        The circuit.
    over
        Values of sources by name, float64[points] each, V or A.

    Raises
    ------
    SolverError
        There is no operating point at a place.
    """
    k = machine.kernel
    columns = {machine.source_names.index(name): values for name, values in over.items()}
    count = next(iter(over.values())).size
    found = np.empty((count, k.columns))
    v = _first(machine, {s: float(values[0]) for s, values in columns.items()})
    w, matrix = allocate(k), np.zeros((k.unknowns, k.unknowns))
    for i in range(count):
        for s, values in columns.items():
            v[k.unknowns + s] = values[i]
        start = v.copy()
        if not rest_state(k, v, w, matrix, _DECADES):
            v = _first(machine, {s: float(values[i]) for s, values in columns.items()})
            if not np.isfinite(v).all():
                raise SolverError(f"{machine.testbench.title}: no operating point at point {i}; {start[:3]}")
        found[i] = v
    voltage = dict(zip(machine.names, found[:, machine.column].T, strict=True))
    return Swept(voltage, static_currents(machine, found))


def _first(machine: Machine, values: Mapping[int, float]) -> F64:
    for s, value in values.items():
        machine = with_source(machine, s, value)
    return operating_point(machine).voltage.copy()


def solved(circuit: Circuit, sources: tuple[Source, ...], silicon: Silicon, over: Mapping[str, F64]) -> Swept:
    """Operating points of a circuit on a silicon while some of its sources move together; as `swept`.

    The last ones are kept, since some unknowns change the readings alone.
    """
    moved = tuple((name, values.tobytes()) for name, values in over.items())
    return _solved(circuit, sources, silicon, moved)


@functools.lru_cache(maxsize=_KEPT)
def _solved(
    circuit: Circuit, sources: tuple[Source, ...], silicon: Silicon, over: tuple[tuple[str, bytes], ...]
) -> Swept:
    machine = on_silicon(_machine(circuit, tuple(replace(s, waveform=_NOTHING) for s in sources)), silicon)
    lines = tuple(polyline(s.name, s.waveform) for s in sources)
    return swept(replace(machine, polylines=lines), {name: np.frombuffer(values) for name, values in over})


@functools.lru_cache(maxsize=_KEPT)
def _machine(circuit: Circuit, sources: tuple[Source, ...]) -> Machine:
    """A circuit with sources at nothing on some silicon, of which others are made."""
    return to_kernel(Testbench(circuit.name, circuit, sources, math.inf))


def lowered(testbench: Testbench, silicon: Silicon) -> Machine:
    """The testbench on its silicon."""
    return to_kernel(testbench, silicon)
