"""A portrait of a ROLLS die: f-I curves, time constants, refractory periods and weights of its neurons.

    tau_m = C_mem U_T / (kappa_n I_tau),   I_tau of the leak that a neuron's latch chooses
    rheobase = max over v_mem of (what leaves the membrane less the feedback) / share,

share being that part of an input that the leak's pair lets into the membrane (weak inversion, by
`chips.rolls.lumped`). f-I curves are run on the behavioural neuron (`chips.rolls.neuron.model`), the current
being what the DC transistor of each neuron gives at one gate voltage, as on a chip whose bias IF_DC_P is
swept; I_dc of a curve is that of the nominal device. Filters, pulses and charges are those of the chip's own
tables (`chips.rolls.tables`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.chip import STEP
from chips.rolls.circuit import FILTERS, Params, chip
from chips.rolls.lumped.whole import coupling
from chips.rolls.neuron.kernel import INJECTED, STATIC, Neurons, weak_share
from chips.rolls.neuron.model import neurons_of, respond
from chips.rolls.neuron.whole_membrane import MIDDLE
from chips.rolls.parts import devices_at, gate_voltages, part_gates, row_place
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import Program, VirtualInput, level_current, missing_levels
from chips.rolls.tables import Built, Prepared, build_tables, prepare
from chips.rolls.validity import cautions_of
from circuits.arrays import F64, I64, Bools
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import BiasKind
from circuits.lowering.on_die import DieDevices
from circuits.silicon.die import NOMINAL
from circuits.silicon.silicon import Silicon

DC = "IF_DC_P"
STEPS = 0.5e-3  # s, of a run; the model refines them itself
LONGEST = 0.4  # s, of a run: two spikes at 5 Hz
FIRST = 20e-3  # s, of the nominal neuron's first run
SPIKES = 8.0  # that a run waits for
LEAST = 1e-12  # A, ours: of the curves' unit, where the nominal neuron fires by itself
MULTIPLES = np.geomspace(0.7, 40.0, 15)  # of the nominal neuron's rheobase: the curves' currents; ours
LEVELS = (1, 2, 3, 4, -1, -2, -3, -4)


@dataclass(frozen=True, slots=True)
class Weight:
    """A weight level on a die.

    nominal: current of the nominal device, A; current: mean of the die, A; charge, charge_cv: mean (C) and
    coefficient of variation of one event's charge.
    """

    level: int
    nominal: float
    current: float
    charge: float
    charge_cv: float


@dataclass(frozen=True, slots=True)
class Portrait:
    """What every neuron of a die is like.

    Attributes
    ----------
    silicon : Silicon
        Process, temperature and die.
    kind : str
        Kind of the biases.
    currents : array
        Currents of the f-I curves, float64[k], A.
    rates : array
        Rates of the neurons at these currents, float64[k, 256], Hz.
    nominal_rates : array
        Rates of the nominal neuron, float64[k], Hz.
    rheobase : array
        Current above which each neuron fires, float64[256], A.
    restless : array
        Whether a neuron fires with the I_dc of the bias table alone, bool[256].
    tau, refractory : array
        Membrane time constant and refractory period, float64[256], s.
    filters : mapping of str to array
        Time constants by the name of the filter, float64[256], s.
    pulses : array
        Length of the pulses of the columns, float64[columns], s.
    weights : tuple of Weight
        Weights of all levels.
    missing : mapping of int to str
        Levels without a bias, and the bias that each lacks.
    cautions : tuple of str
        Where the chip's step is outside of what it was measured for.
    """

    silicon: Silicon
    kind: BiasKind
    currents: F64
    rates: F64
    nominal_rates: F64
    rheobase: F64
    restless: Bools
    tau: F64
    refractory: F64
    filters: Mapping[str, F64]
    pulses: F64
    weights: tuple[Weight, ...]
    missing: Mapping[int, str]
    cautions: tuple[str, ...]


def portrait(
    table: BiasTable, silicon: Silicon, kind: BiasKind = "gate", tau1: Sequence[int] = (),
    params: Params | None = None,
) -> Portrait:  # fmt: skip
    """Measure what a die is like.

    Parameters
    ----------
    table
        Biases of the chip; its IF_DC_P takes no part.
    silicon
        Process, temperature and die.
    kind
        Kind of the biases.
    tau1
        Neurons with the slower leak.
    params
        Sizes of the circuits; the usual ones unless given.

    Raises
    ------
    ParameterError
        A bias needs a gate beyond the supply.
    """
    params = Params() if params is None else params
    off = table.with_code(DC, 7, 0)
    program = weight_program(off, tau1)
    built = build_tables(params, program, kind, silicon, STEP)
    ready = prepare(params, silicon.process)
    nominal = replace(silicon, die=NOMINAL)
    own, reference = (neuron_devices(params, off, kind, s) for s in (silicon, nominal))
    latch = program.slow_leak()
    one = _first_fast(reference, ready, latch)
    currents = MULTIPLES * max(float(rheobase(one)[0]), LEAST)
    drives = dc_currents(own, reference, currents)
    expected = rates(one, currents[:, None], np.full(currents.size, FIRST))[:, 0]
    lengths = np.clip(SPIKES / np.maximum(expected, 1e-3), 10.0 * STEPS, LONGEST)
    threshold = rheobase(built.neurons)
    gate = gate_voltages(chip(params, table, kind), silicon)["v_dc"]
    return Portrait(
        silicon,
        kind,
        currents,
        rates(built.neurons, drives, lengths),
        expected,
        threshold,
        threshold <= own.saturated("leak.ml9", own.v_dd - gate),
        membrane_tau(own, ready, latch),
        built.neurons.refractory.copy(),
        {name: f.tau for name, f in zip(FILTERS, built.filters, strict=True)},
        built.lengths,
        weights(built, program),
        missing_levels(table),
        cautions_of(built, STEP),
    )


def nominal_neuron(table: BiasTable, silicon: Silicon, kind: BiasKind, params: Params) -> Neurons:
    """Return the nominal die's neuron with its faster leak and without I_dc, at a silicon's temperature."""
    nominal, off = replace(silicon, die=NOMINAL), table.with_code(DC, 7, 0)
    devices = neuron_devices(params, off, kind, nominal)
    return _first_fast(devices, prepare(params, silicon.process), np.zeros(NEURONS, np.bool_))


def _first_fast(devices: DieDevices, ready: Prepared, latch: Bools) -> Neurons:
    """The first neuron with the faster leak; latch: which have the slower one, bool[256]."""
    first = np.atleast_1d(np.argmin(latch))
    return neurons_of(devices.taken(first), ready.neuron, latch[first])


def neuron_devices(params: Params, table: BiasTable, kind: BiasKind, silicon: Silicon) -> DieDevices:
    """Return the transistors of all neurons of a chip with these biases."""
    gates = part_gates("neuron", gate_voltages(chip(params, table, kind), silicon))
    return devices_at(rolls_neuron.build(params.neuron), row_place(NEURONS, ("neuron", ())), silicon, gates)


def membrane_tau(d: DieDevices, ready: Prepared, latch: Bools) -> F64:
    """Return the membranes' time constants `C U_T / (kappa_n I_tau)`, s; C is all capacitance at v_mem.

    latch: whether a neuron's leak is tau1, else tau2, bool[n]. Under the full law kappa and I_tau are those
    with v_mem in the middle of its way.
    """
    membrane = ready.neuron[0, 0] + d.added("leak.c_mem")
    if d.full:
        slow, fast = (
            d.current(f"leak.{m}", d.gate[f"v_tau{k}"], MIDDLE) for m, k in (("ml3", 1), ("ml4", 2))
        )
        slope = coupling(d, "sodium.mn1", MIDDLE)
        return np.asarray(membrane * d.u_t / (slope * np.where(latch, slow, fast)))
    slow, fast = (d.saturated(f"leak.{m}", d.gate[f"v_tau{k}"]) for m, k in (("ml3", 1), ("ml4", 2)))
    leak = np.where(latch, slow, fast)
    return np.asarray(membrane * d.u_t / (d.fet["sodium.mn1"].kappa * leak))


def rheobase(m: Neurons) -> F64:
    """Return the least input current that makes each neuron fire, beside what its table injects, A.

    It is at most 0 for a neuron that fires without input.
    """
    needed = -m.table[:, :, STATIC] / weak_share(m) - m.table[:, :, INJECTED]
    return np.asarray(needed.max(axis=1))


def dc_currents(own: DieDevices, reference: DieDevices, currents: F64) -> F64:
    """Return what DC transistors give at the gates of the nominal one's `currents`, A, float64[k, n]."""
    name = "leak.ml9"
    gates = reference.gate_for(name, currents[:, None])[:, 0]  # nominal neurons are alike
    return np.stack([own.saturated(name, g) for g in gates])


def rates(neurons: Neurons, currents: F64, lengths: F64) -> F64:
    """Return the rates of the last interval, Hz, 0 below two spikes, float64[k, n].

    currents: into i_in, A, float64[k, n]; lengths: of each run, s, float64[k]; neurons that have not fired
    twice by then get LONGEST.
    """
    found = np.zeros(currents.shape)
    for k, (current, length) in enumerate(zip(currents, lengths, strict=True)):
        silent = np.ones(current.size, np.bool_)
        for stretch in (float(length), LONGEST):
            who = np.flatnonzero(silent)
            steps = np.tile(current[who], (max(round(stretch / STEPS), 1), 1))
            times = respond(neurons_chosen(neurons, who), steps, STEPS).spikes
            for n, spikes in zip(who, times, strict=True):
                if spikes.size > 1:
                    found[k, n], silent[n] = 1.0 / (spikes[-1] - spikes[-2]), False
            if not silent.any() or length >= LONGEST:
                break
    return found


def weights(built: Built, program: Program) -> tuple[Weight, ...]:
    """Return current and charge of an event, with its column's pulse, of all levels of a program."""
    found = []
    for level in LEVELS:
        at = program.levels == level
        if not at.any():
            continue
        sign = 0 if level > 0 else 1
        unit = built.filters[sign].unit  # C that moves z by one, of the postsynaptic neuron's filter
        charge = np.abs(built.tables.charges.T * unit[:, None])[at]
        mean = float(charge.mean())
        found.append(
            Weight(
                level,
                level_current(program.biases, level),
                built.levels[level],
                mean,
                float(charge.std()) / mean,
            )
        )
    return tuple(found)


def weight_program(table: BiasTable, tau1: Sequence[int]) -> Program:
    """Return a program with all levels that the biases have, and all virtual synapses in use."""
    known = [level for level in LEVELS if level not in missing_levels(table)]
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    if known:
        index = np.add.outer(np.arange(NEURONS), np.arange(NEURONS)) % len(known)
        levels[:] = np.array(known, dtype=np.int8)[index]
    inputs = tuple(
        VirtualInput(name, tuple(range(NEURONS)), inhibitory=name == "inhibitory")
        for name, code in (("excitatory", "VA_EXC_N"), ("inhibitory", "VA_INH_P"))
        if not table.is_off(code)
    )
    return Program(levels, table, tuple(tau1), inputs)


def neurons_chosen(m: Neurons, index: I64) -> Neurons:
    """Return the neurons `index`."""
    return Neurons(*(np.ascontiguousarray(x[index]) for x in m))
