"""ROLLS' filters on the nominal die: their time constants, and how their current grows with what comes in.

A filter's output transistor has another slope than its integrator's, so that its current is a power of what
it has integrated, about 0.76:

    I = pivot (S / pivot)^p,    S = gain * charge a second

It is straight only near the current `pivot`, at which a chip's filter is made to agree with a network's
(`AT` times the neuron's rheobase). Gain and p are measured on the nominal die under regular events: a line
through the logarithms of the filters' mean currents between `BAND` times the rheobase.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from chips.aer import Events, send
from chips.rolls.calibration import code_for
from chips.rolls.chip import STEP, Inputs, RollsChip
from chips.rolls.circuit import FILTERS, Params
from chips.rolls.portrait import LEVELS, weights
from chips.rolls.program.address import NEURONS, NONPLASTIC, VIRTUAL_EXCITATORY, VIRTUAL_INHIBITORY
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.tables import Built, build_tables, filters_of
from circuits.arrays import F64, I64
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.rolls.neuron import KIND

AT = 2.0  # of the rheobase; ours
GAIN = 0.5  # of a filter's threshold bias over its leak: small beside what a neuron needs; ours
LEAK_OF = dict(zip(FILTERS, ("NPDPIE_TAU_P", "NPDPII_TAU_P", "VDPIE_TAU_P", "VDPII_TAU_N"), strict=True))
GAIN_OF = dict(zip(FILTERS, ("NPDPIE_THR_P", "NPDPII_THR_P", "VDPIE_THR_P", "VDPII_THR_N"), strict=True))
FIRST_OF = dict(zip(FILTERS, ("NPA_WEIGHT_EXC_P", "NPA_WEIGHT_INH_N", "VA_EXC_N", "VA_INH_P"), strict=True))
EXTRA = {
    FILTERS[0]: ("NPA_WEIGHT_EXC0_P", "NPA_WEIGHT_EXC1_P"),
    FILTERS[1]: ("NPA_WEIGHT_INH0_N", "NPA_WEIGHT_INH1_N"),
}  # what the levels above the first add
SIGN = dict(zip(FILTERS, (1, -1, 1, -1), strict=True))
COLUMNS = {
    name: range(first, first + 4)
    for name, first in zip(
        FILTERS, (NONPLASTIC + 200, NONPLASTIC + 210, VIRTUAL_EXCITATORY, VIRTUAL_INHIBITORY), strict=True
    )
}  # that a bench drives
ROUNDED = 1e-12  # of weights that add up, up to which what is left of them is rounding; ours
NOTHING = Events(np.empty(0), np.empty(0, np.int64))
BESIDE = "virtual_excitatory"  # excites where an inhibition is measured
# Of the bench, ours: events of a neuron in Hz, and the rate that is to bring the pivot; for how many time
# constants and for how long (s) after these it runs; rheobases between which a current counts
_RATES, _MIDDLE = np.geomspace(300.0, 4000.0, 24), 1600.0
_SETTLED, _MEASURED, BAND = 8.0, 0.1, (0.5, 4.5)
_FEWEST = 3  # of the bench's rates, for a line; ours
_LEAK_TIMES_TAU, _TRIALS = 5e-14, 2  # A s, about what a filter's leak is tried first by, and how many are
_FIRST_GAIN, PULSE_LENGTH = 0.16, 82e-6  # about a filter's gain; s, about a pulse


@dataclass(frozen=True, slots=True)
class Law:
    """What a filter does.

    tau : time constant, s; power : p; pivot : A; gain : A a C/s; error : largest relative one of the mean
    current by these equations at the bench's rates, infinite where too few of them bring such currents.
    """

    tau: float
    power: float
    pivot: float
    gain: float
    error: float = 0.0

    def about(self, pivot: float) -> Law:
        """Return the same law with another pivot, A."""
        gain = self.gain * (self.pivot / pivot) ** ((1.0 - self.power) / self.power)
        return replace(self, pivot=pivot, gain=gain)

    def mean(self, charge: float, rate: F64) -> F64:
        """Mean current (A) under regular events (Hz) that bring a charge, C, by the equations."""
        share = 1.0 / (rate * self.tau)  # of a time constant, between two events
        most = float(self.weight(np.array(charge))) / -np.expm1(-share)  # S behind an event
        held = -np.expm1(-self.power * share) / (self.power * share)
        return np.asarray(self.pivot * (most / self.pivot) ** self.power * held)

    def weight(self, charge: F64) -> F64:
        """Weights (A, the jump of S) of events that bring charges, C."""
        return np.asarray(charge * self.gain / self.tau)


def with_filters(biases: BiasTable, taus: Mapping[str, float]) -> BiasTable:
    """Return a table whose filters have time constants (s) by name, the nearest that its codes have."""
    leaks = {name: _LEAK_TIMES_TAU / tau for name, tau in taus.items()}
    for _ in range(_TRIALS):
        for name, leak in leaks.items():
            biases = biases.with_code(LEAK_OF[name], *code_for(leak))
            biases = biases.with_code(GAIN_OF[name], *code_for(GAIN * biases.current(LEAK_OF[name])))
        virtual = bench_program(biases).virtual
        filters = filters_of(Params(virtual=virtual), biases, KIND, Silicon(ROLLS_180))
        found = {name: float(filters[FILTERS.index(name)].tau[0]) for name in taus}
        leaks = {name: biases.current(LEAK_OF[name]) * found[name] / taus[name] for name in taus}
    return biases


def tau_of(built: Built, name: str) -> float:
    """Time constant of a filter of the first neuron, s."""
    return float(built.filters[FILTERS.index(name)].tau[0])


def bench_program(biases: BiasTable) -> Program:
    """Return the program of a bench: columns of both signs and all virtual synapses, at every neuron."""
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    for name, columns in COLUMNS.items():
        if columns.start < VIRTUAL_EXCITATORY:
            levels[:, [c - NONPLASTIC for c in columns]] = SIGN[name]
    everywhere = tuple(range(NEURONS))
    inputs = VirtualInput("excite", everywhere), VirtualInput("inhibit", everywhere, inhibitory=True)
    return Program(levels, biases, inputs=inputs)


def every_level(biases: BiasTable) -> Program:
    """Return a program with a column of each level and both kinds of virtual synapses, at every neuron."""
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    levels[:, : len(LEVELS)] = LEVELS
    return Program(levels, biases, inputs=bench_program(biases).inputs)


@lru_cache(maxsize=4)
def bench_built(biases: BiasTable) -> Built:
    """Return the tables of the nominal die at 27 degC on a bench."""
    return built_of(bench_program(biases))


def built_of(program: Program) -> Built:
    """Return the tables of the nominal die at 27 degC with a program."""
    return build_tables(Params(virtual=program.virtual), program, KIND, Silicon(ROLLS_180), STEP)


def charges_of(program: Program, built: Built) -> dict[str | int, float]:
    """Return the charge of an event of each level, and of a virtual synapse by its filter, C."""
    found: dict[str | int, float] = {w.level: w.charge for w in weights(built, program)}
    for k, name in enumerate(FILTERS[2:]):
        unit = built.filters[2 + k].unit
        found[name] = float(np.abs(built.tables.virtual[4 * k] * unit).mean())
    return found


def laws(biases: BiasTable, rheobase: float, used: Collection[str]) -> dict[str, Law]:
    """Measure filters of the nominal die about the currents that neurons of a rheobase (A) need."""
    for name in used:
        tried = AT * rheobase / (_FIRST_GAIN * _MIDDLE * PULSE_LENGTH)
        biases = biases.with_code(FIRST_OF[name], *code_for(tried))
    charges, currents = charges_of(bench_program(biases), bench_built(biases)), _currents(biases)
    return {name: _law(biases, name, rheobase, charges[_event(name)], currents[name]) for name in used}


def _law(biases: BiasTable, name: str, rheobase: float, charge: float, currents: F64) -> Law:
    """The line through a filter's currents (A) at the bench's rates."""
    pivot = AT * rheobase
    tau = tau_of(bench_built(biases), name)
    near = (currents > BAND[0] * rheobase) & (currents < BAND[1] * rheobase)
    if near.sum() < _FEWEST:
        return Law(tau, 1.0, pivot, 1.0, np.inf)
    came, got = np.log(_RATES[near] * charge), np.log(currents[near])
    power, offset = np.polyfit(came, got, 1)
    gain = np.exp(offset + (power - 1.0) * np.log(pivot)) ** (1.0 / power)
    found = Law(tau, float(power), pivot, float(gain))
    error = np.abs(found.mean(charge, _RATES[near]) / currents[near] - 1.0).max()
    return replace(found, error=float(error))


@lru_cache(maxsize=4)
def _currents(biases: BiasTable) -> dict[str, F64]:
    """Mean currents of all filters at the bench's rates, A; a neuron has events of one filter and rate."""
    built = bench_built(biases)
    chip = RollsChip(bench_program(biases), Silicon(ROLLS_180), KIND).with_tables(built)
    longest = max(tau_of(built, name) for name in FILTERS)
    still, steps = round(_SETTLED * longest / chip.step), round(_MEASURED / chip.step)
    end = (still + steps) * chip.step
    parts = [
        regular(k, COLUMNS[name], rate, end, k + j * _RATES.size)
        for j, name in enumerate(FILTERS)
        for k, rate in enumerate(_RATES)
    ]
    given = together(parts)
    arrived = send(chip.bus, given.times, given.neurons + (given.columns << 8))
    _, _, state, _ = chip.run_steps(chip.at_rest(), still, arrived)
    total = np.zeros((2, NEURONS))
    for _ in range(steps):
        _, _, state, _ = chip.run_steps(state, 1, NOTHING)
        total += chip.synaptic_currents()
    found = (total / steps)[:, : len(FILTERS) * _RATES.size].reshape(2, len(FILTERS), _RATES.size)
    return {name: found[int(SIGN[name] < 0), j] for j, name in enumerate(FILTERS)}


def _event(name: str) -> str | int:
    return name if name.startswith("virtual") else SIGN[name]


def together(parts: Iterable[tuple[F64, I64, I64]]) -> Inputs:
    """Return events for the chip of several parts: times (s), neurons and columns of each."""
    times, neurons, columns = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(times, kind="stable")
    return Inputs(times[order], neurons[order], columns[order])


def regular(place: int, columns: range, rate: float, duration: float, neuron: int) -> tuple[F64, I64, I64]:
    """Return regular events of a neuron at a rate (Hz), by turns over columns: times (s), neurons, columns.

    place : of 64, by which they begin later.
    """
    count = int(rate * duration)
    times = (np.arange(count) + 0.5 + place / 64.0) / max(rate, 1.0)
    return (
        np.asarray(times, dtype=np.float64),
        np.full(count, neuron),
        columns.start + np.arange(count) % len(columns),
    )
