"""ROLLS' filters on the nominal die: their time constants, and how their current grows with what comes in.

A filter's output transistor has another slope than its integrator's, so that its current is a power of what
it has integrated, about 0.76:

    I = pivot (S / pivot)^p,    S = gain * charge a second

It is straight only near the current `pivot`, at which a chip's filter is made to agree with a network's
(`AT` times the neuron's rheobase). Gain and p are measured as on a bench: neurons of the nominal die are
driven at rates that bring 1.3 to 4 times their rheobase, and their own rates tell the current
(`system.mapping.rolls.neuron`). A filter that inhibits is measured beside a steady excitation.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from chips.rolls.calibration import code_for, neuron_rates
from chips.rolls.chip import STEP, Inputs, RollsChip
from chips.rolls.circuit import FILTERS, Params
from chips.rolls.portrait import weights
from chips.rolls.program.address import NEURONS, NONPLASTIC, VIRTUAL_EXCITATORY, VIRTUAL_INHIBITORY
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.tables import Built, build_tables
from circuits.arrays import F64, I64
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.rolls.neuron import KIND, Curve

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
_ORDER = ("virtual_excitatory", "excitatory", "inhibitory", "virtual_inhibitory")
BESIDE = "virtual_excitatory"  # excites where an inhibition is measured
# Numbers of the bench, ours: events of its neurons in Hz, the first with none, and the rate that is to bring
# the pivot; weight that is tried first, A, and how often it is corrected; rheobases of the excitation beside
# an inhibition; rates that count, Hz and in shares of the neuron's highest; rheobases between which a current
# counts; neurons that must fire
_RATES = np.concatenate(([0.0], np.geomspace(400.0, 4000.0, 23)))
_MIDDLE, _TRIED, _ROUNDS, _STEADY = 1600.0, 5e-9, 3, 5.0
_LEAST, _MOST, _BAND, _FEWEST = 3.0, 0.5, (0.5, 4.5), 4
_FARTHER, _NEAR = 0.25, 0.2  # where no neuron fires, of the gain; and of the next correction's logarithm
_FIRST_LEAK, _TRIALS = 5e-12, 3  # A, of a filter, which is tried first, and how many are


@dataclass(frozen=True, slots=True)
class Law:
    """What a filter does.

    tau : time constant, s; power : p; pivot : A; gain : A a C/s; error : largest relative one of the law.
    """

    tau: float
    power: float
    pivot: float
    gain: float
    error: float = 0.0

    def strength(self, current: float) -> float:
        """S that brings a current, both A."""
        return float(self.pivot * (current / self.pivot) ** (1.0 / self.power))

    def weight(self, charge: F64) -> F64:
        """Weights (A, the jump of S) of events that bring charges, C."""
        return np.asarray(charge * self.gain / self.tau)


def with_filters(biases: BiasTable, taus: Mapping[str, float]) -> BiasTable:
    """Return a table whose filters have time constants (s) by name, the nearest that its codes have."""
    leaks = dict.fromkeys(taus, _FIRST_LEAK)
    for _ in range(_TRIALS):
        for name, leak in leaks.items():
            biases = biases.with_code(LEAK_OF[name], *code_for(leak))
            biases = biases.with_code(GAIN_OF[name], *code_for(GAIN * biases.current(LEAK_OF[name])))
        found = {name: tau_of(bench_built(biases), name) for name in taus}
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


def laws(biases: BiasTable, curve: Curve, used: Collection[str]) -> dict[str, Law]:
    """Measure filters of the nominal die, beside neurons whose latch is off and that follow `curve`."""
    found: dict[str, Law] = {}
    needed = {*used, *((BESIDE,) if any(SIGN[name] < 0 for name in used) else ())}
    for name in (each for each in _ORDER if each in needed):
        biases, found[name] = _law(biases, name, curve, found.get(BESIDE))
    return found


def _law(biases: BiasTable, name: str, curve: Curve, beside: Law | None) -> tuple[BiasTable, Law]:
    """Law of a filter, and the table at which its bench was; beside: law of the excitation of the bench."""
    table = biases.with_code(FIRST_OF[name], *code_for(_TRIED))
    law = _measured(table, name, curve, beside)
    for _ in range(_ROUNDS - 1):
        charge = charges_of(bench_program(table), bench_built(table))[_event(name)]
        change = law.pivot / (law.gain * charge * _MIDDLE)
        if abs(np.log(change)) < _NEAR:
            break
        table = table.with_code(FIRST_OF[name], *code_for(table.current(FIRST_OF[name]) * change))
        law = _measured(table, name, curve, beside)
    return table, law


def _measured(table: BiasTable, name: str, curve: Curve, beside: Law | None) -> Law:
    """A line through the logarithms of current over charge a second, of the neurons of a bench that fire."""
    pivot, tau = AT * curve.rheobase, tau_of(bench_built(table), name)
    charges = charges_of(bench_program(table), bench_built(table))
    charge, steady = charges[_event(name)], 0.0
    if SIGN[name] < 0 and beside is not None:
        steady = beside.strength(_STEADY * curve.rheobase) / (beside.gain * charges[BESIDE])
    seen = _seen(table, name, steady)
    fires = (seen > _LEAST) & (seen < _MOST / curve.refractory)
    current = curve.current(np.where(fires, seen, 1.0))
    if steady:
        current, fires = current[0] - current, fires & (_RATES > 0.0)
    fires &= (current > _BAND[0] * curve.rheobase) & (current < _BAND[1] * curve.rheobase)
    if fires.sum() < _FEWEST:
        gain = pivot / (charge * _MIDDLE)
        return Law(tau, 1.0, pivot, gain if fires.any() else gain * _FARTHER)
    came, got = np.log(_RATES[fires] * charge), np.log(current[fires])
    power, offset = np.polyfit(came, got, 1)
    gain = np.exp(offset + (power - 1.0) * np.log(pivot)) ** (1.0 / power)
    error = np.abs(np.expm1(power * came + offset - got)).max()
    return Law(tau, float(power), pivot, float(gain), float(error))


def _seen(table: BiasTable, name: str, steady: float) -> F64:
    """Rates of the bench's neurons, Hz."""
    chip = RollsChip(bench_program(table), Silicon(ROLLS_180), KIND).with_tables(bench_built(table))
    return neuron_rates(chip, lambda duration: _drive(name, steady, duration))[: _RATES.size]


def _event(name: str) -> str | int:
    return name if name.startswith("virtual") else SIGN[name]


def _drive(name: str, steady: float, duration: float) -> Inputs:
    """Regular events of the bench's neurons, and a steady excitation of `steady` Hz."""
    found = [regular(k, COLUMNS[name], rate, duration, k) for k, rate in enumerate(_RATES)]
    found += [regular(k, COLUMNS[BESIDE], steady, duration, k) for k in range(_RATES.size)]
    return together(found)


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
