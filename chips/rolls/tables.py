"""Tables of a ROLLS chip with a program, on a die at a temperature, from its circuit's transistors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.rolls.circuit import FILTERS, Params, chip
from chips.rolls.depression.layout import BuiltDepression
from chips.rolls.layout import (
    DELAY,
    POWER,
    REACH,
    REFRACTORY,
    SPIKING_COLUMNS,
    Banks,
    ChipTables,
    Membranes,
)
from chips.rolls.lumped.filter import (
    OMEGA_POINTS,
    Filter,
    Load,
    Shape,
    bank_of,
    filter_of,
    line_voltage,
    shape_of,
)
from chips.rolls.lumped.grid import edges
from chips.rolls.lumped.lines import lines_of, with_reach
from chips.rolls.neuron.kernel import Neurons
from chips.rolls.neuron.model import NODES, neurons_of
from chips.rolls.noise.layout import NoiseTables
from chips.rolls.parts import devices_at, extenders_at, gate_voltages, part_gates, row_place
from chips.rolls.plastic.tables import BuiltPlastic
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import Program, level_current
from chips.rolls.synapse.charge import WEIGHT_DEVICES, charge_of, draw_of, idle_draw, pulse_length
from chips.rolls.synapse.model import SynapseModel
from chips.rolls.synapse.model import model_of as synapse_model_of
from circuits.arrays import F64, I8
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.blocks.rolls.neuron import RESTING
from circuits.circuit import BiasKind, Circuit
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.on_die import DieDevices
from circuits.silicon.die import Path
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

STILL = 1e-3  # V, ours: kick of v_ahp below which adaptation counts as off
NO_SYNAPSE = 1e-9  # A, ours: taken for filters that nothing reaches
COLUMNS = 8  # of virtual synapses: four excitatory, four inhibitory
LONGEST_PART = 50e-6  # s, ours: of a step's parts
FEWEST = 6.0  # steps in which a neuron that takes them whole spikes once at most; ours
TOGETHER = 4096  # synapses whose charges are found together, so that their numbers stay in the cache; ours
FALLS = 0.1  # of what a filter puts out, in a step, below which its mean is enough; ours


@dataclass(frozen=True, slots=True)
class Prepared:
    """What all dies of a process share: models of the blocks with their capacitances."""

    synapse: SynapseModel
    neuron: F64  # float64[8, 8], F
    filters: tuple[tuple[float, float], ...]  # F, at v_syn and at the line, of FILTERS


@dataclass(frozen=True, slots=True)
class Built:
    """Tables for steps of a given length, and what they were made of.

    charge: Q_0 of each neuron's zeta, C; lengths: of the columns' pulses, s; filters, loads, shapes: of
    FILTERS; levels: mean current of a level, A; gates: bias voltages by port, V; noise, plastic, depression:
    where the chip has them.
    """

    tables: ChipTables
    neurons: Neurons
    filters: tuple[Filter, ...]
    loads: tuple[Load, ...]
    shapes: tuple[Shape, ...]
    charge: F64
    lengths: F64
    levels: Mapping[int, float]
    gates: Mapping[str, float]
    noise: NoiseTables | None = None
    plastic: BuiltPlastic | None = None
    depression: BuiltDepression | None = None


@lru_cache(maxsize=8)
def prepare(params: Params, process: Process) -> Prepared:
    """Return the models of a chip's blocks in a process."""
    synapse = synapse_model_of(dpi_synapse.build(params.synapse), process)
    at = []
    for name in FILTERS:
        c = _filter_capacitance(params, process, name)
        at.append((float(c[0, 0]), float(c[1, 1])))
    return Prepared(synapse, capacitance_matrix(rolls_neuron.build(params.neuron), process, NODES), tuple(at))


def _filter_capacitance(params: Params, process: Process, name: str) -> F64:
    make = dpi_synapse.inhibitory_filter if name.endswith("inhibitory") else dpi_synapse.excitatory_filter
    return capacitance_matrix(make(params.synapse), process, ("v_syn", "line"))


class _Written(NamedTuple):
    """What tables follow from of a program.

    levels, latches: its levels and leak latches, int8 and bool, as bytes; live: whether an input excites, and
    whether one inhibits.
    """

    levels: bytes
    latches: bytes
    biases: BiasTable
    live: tuple[bool, bool]


def build_tables(params: Params, program: Program, kind: BiasKind, silicon: Silicon, step: float) -> Built:
    """Return all tables of a chip on a silicon for steps of `step` s; the last ones are kept."""
    signs = {i.inhibitory for i in program.inputs}
    written = _Written(
        program.levels.tobytes(),
        program.slow_leak().tobytes(),
        program.biases,
        (False in signs, True in signs),
    )
    return _built(params, written, kind, silicon, step)


@lru_cache(maxsize=1)  # 15 MiB, which mostly a chip has too
def _built(params: Params, written: _Written, kind: BiasKind, silicon: Silicon, step: float) -> Built:
    ready = prepare(params, silicon.process)
    gates = gate_voltages(_chip(params, written.biases, kind), silicon)
    neurons, membranes, unit = _neurons(params, silicon, _gates_of("neuron", gates), written.latches)
    filters = _filters(params, silicon, gates)
    levels = np.frombuffer(written.levels, dtype=np.int8)
    given = _Given(params, ready, levels, written.biases, gates, silicon, filters)
    draws, virtual = _draws(given), _virtual(given)
    charges = np.zeros((NEURONS, NEURONS))
    loads: list[Load] = []
    for sign in range(2):
        f = filters[sign]
        charge = draws.charge[sign]
        loads.append(Load(_mean_current(draws.current[sign], charge), draws.idle[sign]))
        charges += (1 - 2 * sign) * (charge / f.unit[:, None]).T
    units = []
    for sign in range(2):
        f = filters[2 + sign]
        rows = slice(4 * sign, 4 * sign + 4)
        loads.append(Load(_mean_current(virtual.current[rows].T, virtual.charge[rows].T), virtual.idle[sign]))
        units.append(virtual.charge[rows] / f.unit[None, :])
    live = (True, True, *written.live)
    shapes = tuple(shape_of(f, load) for f, load in zip(filters, loads, strict=True))
    banks = _banks(filters, loads, shapes, step)
    membranes = membranes._replace(
        lines=with_reach(membranes.lines.astype(np.float64), unit, step).astype(np.float32)
    )
    fast = _fast(membranes, unit, banks, shapes, live, step)
    parts = math.ceil(step / LONGEST_PART - 1e-9) if np.isfinite(fast).any() else 1
    tables = ChipTables(
        step, np.stack([s.omega for s in shapes]).astype(np.float32), banks, live, charges.astype(np.float32),
        np.concatenate(units).astype(np.float32), membranes, parts,
        _banks(filters, loads, shapes, step / parts), fast,
    )  # fmt: skip
    return Built(
        tables, neurons, tuple(filters), tuple(loads), shapes, unit, draws.lengths, draws.levels, gates
    )


@lru_cache(maxsize=4)
def _chip(params: Params, biases: BiasTable, kind: BiasKind) -> Circuit:
    """The chip's circuit, which is that of every die."""
    return chip(params, biases, kind)


def filters_of(params: Params, biases: BiasTable, kind: BiasKind, silicon: Silicon) -> list[Filter]:
    """Return the filters of a chip's tables by kind, in the order of `FILTERS`, without the other tables."""
    return _filters(params, silicon, gate_voltages(_chip(params, biases, kind), silicon))


def _filters(params: Params, silicon: Silicon, gates: Mapping[str, float]) -> list[Filter]:
    return [_filter(params, silicon, k, _gates_of(name, gates)) for k, name in enumerate(FILTERS)]


def _banks(filters: Sequence[Filter], loads: Sequence[Load], shapes: Sequence[Shape], step: float) -> Banks:
    """Filters of all kinds for steps of `step` s."""
    a, b, c, d = (bank_of(*each, step) for each in zip(filters, loads, shapes, strict=True))
    return a, b, c, d


def _fast(
    membranes: Membranes, unit: F64, banks: Banks, shapes: Sequence[Shape],
    live: Sequence[bool], step: float,
) -> F64:  # fmt: skip
    """What z of exciting filters a neuron needs to spike again in `FEWEST` steps, float64[SIGNS, n].

    What has to flow in until then is the charge from 0 V to where the membrane's own current is least.
    Infinite where a pause alone takes so long, or the filters fall by less than `FALLS` in a step.
    """
    grid = edges(membranes.lines.shape[1])[:-1]
    own = membranes.lines[:, :, 0] + membranes.lines[:, :, 1] * grid
    needed = unit * grid[np.argmin(np.where(grid < membranes.top[:, None], own, np.inf), axis=1)]
    left = FEWEST * step - membranes.spiking[:, REFRACTORY]
    current = np.where(left > 0.0, needed / np.where(left > 0.0, left, 1.0), np.inf)
    found = np.full((len(banks), needed.size), np.inf)
    for sign in (0, 2):
        bank, omega = banks[sign], shapes[sign].omega
        if not live[sign] or float(np.median(bank.fall)) < FALLS:
            continue
        # the output's law backwards
        power = np.expm1(np.sqrt(current / bank.specific)) ** 2 / (bank.scale * (1.0 - bank.fallen))
        found[sign] = np.interp(power, omega[:, POWER], OMEGA_POINTS, right=np.inf)
    return found


def _mean_current(current: F64, charge: F64) -> F64:
    """Mean current of each filter's synapses, weighted with their charge, A; of all where it has none."""
    total = charge.sum(axis=1)
    if not (total > 0.0).any():
        return np.full(total.size, NO_SYNAPSE)
    weighted = (current * charge).sum(axis=1)
    each = weighted / np.where(total > 0.0, total, 1.0)
    return np.asarray(np.where(total > 0.0, each, weighted.sum() / total.sum()))


@lru_cache(maxsize=8)
def _neurons(
    params: Params, silicon: Silicon, gates: tuple[tuple[str, float], ...], latches: bytes
) -> tuple[Neurons, Membranes, F64]:
    """Neurons of a die, kept for programs that differ in weights alone; latches: bool[256], slow leak."""
    place = row_place(NEURONS, ("neuron", ()))
    d = devices_at(rolls_neuron.build(params.neuron), place, silicon, dict(gates))
    ready = prepare(params, silicon.process)
    neurons = neurons_of(d, ready.neuron, np.frombuffer(latches, dtype=np.bool_), RESTING)
    return neurons, *_membranes(neurons)


@lru_cache(maxsize=16)
def _filter(params: Params, silicon: Silicon, k: int, gates: tuple[tuple[str, float], ...]) -> Filter:
    """Filters of a kind on a die, kept likewise."""
    name = FILTERS[k]
    inhibitory = name.endswith("inhibitory")
    make = dpi_synapse.inhibitory_filter if inhibitory else dpi_synapse.excitatory_filter
    d = devices_at(make(params.synapse), row_place(NEURONS, (name, ())), silicon, dict(gates))
    capacitances = prepare(params, silicon.process).filters[k]
    return filter_of(d, *capacitances, inhibitory=inhibitory)


@lru_cache(maxsize=2)
def synapse_devices(params: Params, silicon: Silicon) -> DieDevices:
    """Return the weight devices of the whole array, without their gates."""
    place = row_place(NEURONS, ("synapse", (NEURONS,)))
    return devices_at(dpi_synapse.synapse(params.synapse), place, silicon, {}, WEIGHT_DEVICES, "synapse.")


@lru_cache(maxsize=4)
def _virtual_devices(params: Params, silicon: Silicon, name: str, count: int) -> DieDevices:
    """Weight devices of the virtual synapses of a sign, without their gates, kept likewise."""
    place = row_place(NEURONS, (name, (count,)))
    return devices_at(dpi_synapse.synapse(params.synapse), place, silicon, {}, WEIGHT_DEVICES, "synapse.")


@lru_cache(maxsize=6)
def _pulse_lengths(
    params: Params, silicon: Silicon, place: Path, gates: tuple[tuple[str, float], ...]
) -> F64:
    """Pulse of each extender in the arrays of `place`, s, kept likewise."""
    extenders = extenders_at(params.synapse, place, silicon, dict(gates))
    found = pulse_length(prepare(params, silicon.process).synapse, extenders)
    found.flags.writeable = False
    return found


def _gated(d: DieDevices, part: str, gates: Mapping[str, float]) -> DieDevices:
    """Devices of a part with its gates."""
    given = part_gates(part, gates)
    return d._replace(gate={port: np.asarray(v, dtype=np.float64) for port, v in given.items()})


def _gates_of(part: str, gates: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    return tuple(sorted(part_gates(part, gates).items()))


@dataclass(frozen=True, slots=True)
class _Given:
    """What the currents of a die's synapses follow from; levels: int8[post times pre]; gates in V."""

    params: Params
    models: Prepared
    levels: I8
    biases: BiasTable
    gates: Mapping[str, float]
    silicon: Silicon
    filters: Sequence[Filter]

    def pulse_lengths(self, place: Path) -> F64:
        """Pulse of each extender in the arrays of `place`, s."""
        return _pulse_lengths(self.params, self.silicon, place, _gates_of("extender", self.gates))


@dataclass(frozen=True, slots=True)
class _Draws:
    """Of both signs: current (A) and charge (C), float64[post, pre]; idle: float64[post], A."""

    current: tuple[F64, F64]
    charge: tuple[F64, F64]
    idle: tuple[F64, F64]
    lengths: F64
    levels: Mapping[int, float]


def _draws(given: _Given) -> _Draws:
    d = _gated(synapse_devices(given.params, given.silicon), "synapse", given.gates)
    lengths = given.pulse_lengths((("extender", (NEURONS,)),))
    levels = given.levels
    current, charge = np.zeros((2, levels.size)), np.zeros((2, levels.size))
    means = {}
    for level in (k for k in range(-4, 5) if k != 0):
        index = np.flatnonzero(levels == level)
        if index.size == 0:
            continue
        sign = 0 if level > 0 else 1
        line = line_voltage(given.filters[sign], level_current(given.biases, level), d.u_t)
        own = _of_level(d, level)
        for begin in range(0, index.size, TOGETHER):
            some = index[begin : begin + TOGETHER]
            drawn = draw_of(given.models.synapse, own.taken(some), level, line)
            current[sign, some] = drawn.current
            charge[sign, some] = charge_of(drawn, lengths[some % NEURONS])
        means[level] = float(current[sign, index].mean())
    square = (NEURONS, NEURONS)
    idle = [idle_draw(d, inhibitory=bool(s)).reshape(square).sum(axis=1) for s in range(2)]
    return _Draws(
        (current[0].reshape(square), current[1].reshape(square)),
        (charge[0].reshape(square), charge[1].reshape(square)), (idle[0], idle[1]), lengths, means,
    )  # fmt: skip


def _of_level(d: DieDevices, level: int) -> DieDevices:
    """The devices of synapses that draw a level's current."""
    kind = "synapse.me" if level > 0 else "synapse.mi"
    return d._replace(fet={name: fet for name, fet in d.fet.items() if name.startswith(kind)})


@dataclass(frozen=True, slots=True)
class _Virtual:
    """Current (A) and charge (C) of the columns, float64[COLUMNS, n]; idle: of both signs, A."""

    current: F64
    charge: F64
    idle: tuple[F64, F64]


def _virtual(given: _Given) -> _Virtual:
    current, charge = np.zeros((COLUMNS, NEURONS)), np.zeros((COLUMNS, NEURONS))
    idle = [np.zeros(NEURONS), np.zeros(NEURONS)]
    counts = (given.params.virtual.excitatory, given.params.virtual.inhibitory)
    for sign, (name, count) in enumerate(zip(("virtual_exc", "virtual_inh"), counts, strict=True)):
        if not count:
            continue
        d = _gated(_virtual_devices(given.params, given.silicon, name, count), name, given.gates)
        lengths = given.pulse_lengths(row_place(NEURONS, (f"{name}_extender", (count,))))
        weight = given.biases.current(("VA_EXC_N", "VA_INH_P")[sign])
        line = line_voltage(given.filters[2 + sign], weight, d.u_t)
        drawn = draw_of(given.models.synapse, d, -1 if sign else 1, line)
        rows = slice(4 * sign, 4 * sign + count)
        current[rows] = drawn.current.reshape(NEURONS, count).T
        charge[rows] = charge_of(drawn, lengths).reshape(NEURONS, count).T
        idle[sign] = idle_draw(d, inhibitory=bool(sign)).reshape(NEURONS, count).sum(axis=1)
    return _Virtual(current, charge, (idle[0], idle[1]))


def _membranes(m: Neurons) -> tuple[Membranes, F64]:
    lines = lines_of(m)
    inverse, first = 1.0 / lines.charge, lines.lines[:, 0]
    columns = (inverse, lines.top, m.delay, m.refractory, m.kick, first[:, 0] + first[:, 1], first[:, 1])
    spiking = np.zeros((lines.top.size, SPIKING_COLUMNS))
    spiking[:, : len(columns)] = np.stack(columns, axis=1)
    adapting = bool((np.abs(m.kick) > STILL).any())
    return (
        Membranes(
            lines.lines.astype(np.float32), lines.lines[:, :, REACH:].astype(np.float32),
            inverse.astype(np.float32),
            (1.0 / m.ground_current).astype(np.float32), lines.top, spiking, lines.rise.astype(np.float32),
            adapting, m.quiet,
            m.taken, m.drawn, float(m.ahp_step[0]),
        ),
        lines.charge,
    )  # fmt: skip


def spikes_a_step(tables: ChipTables) -> int:
    """Return an upper bound of a neuron's spikes in a step."""
    spiking = tables.membranes.spiking
    shortest = float((spiking[:, REFRACTORY] + spiking[:, DELAY]).min())
    return math.ceil(tables.step / shortest) + 1
