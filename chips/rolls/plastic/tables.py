"""Tables of a ROLLS chip's plastic array, on a die at a temperature, from its transistors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from chips.rolls.circuit import Params
from chips.rolls.layout import Membranes
from chips.rolls.lumped.filter import Filter, Load, Shape, bank_of, filter_of, line_voltage, shape_of
from chips.rolls.lumped.grid import edges
from chips.rolls.neuron.whole_membrane import WholeMembrane
from chips.rolls.parts import devices_at, extenders_at, gate_voltages, part_gates, row_place
from chips.rolls.plastic.circuit import (
    CELL,
    EXTENDER,
    GATE,
    GATE_EXTENDER,
    Learning,
    plastic_chip,
    plastic_ports,
)
from chips.rolls.plastic.layout import NODES, PlasticTables
from chips.rolls.plastic.model import (
    CELL_ARRAYS,
    CELL_DEVICES,
    WHOLE_DEVICES,
    CellModel,
    Cells,
    GateModel,
    Gates,
    cell_model,
    cells_of,
    gate_model,
    gates_of,
)
from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import Program
from chips.rolls.synapse.charge import pulse_length
from chips.rolls.synapse.model import SynapseModel
from chips.rolls.synapse.model import model_of as synapse_model_of
from circuits.arrays import F32, F64, Bools
from circuits.blocks.rolls import calcium_gate, dpi_synapse, plastic_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.blocks.rolls.neuron import RESTING
from circuits.circuit import BiasKind
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.on_die import DieDevices
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

FILTER = "plastic"
NMDA_DEVICES = (*(f"nmda_gate.mg{k}" for k in (1, 2, 4, 5, 6, 7)), "leak.ml1", "leak.ml2")
NMDA_CURRENT = 1e-10  # A, ours: into the NMDA gate, at which its share is taken under the full law


@dataclass(frozen=True, slots=True)
class BuiltPlastic:
    """Tables for steps of a given length, and what they were made of.

    filters, loads, shapes: of the plastic synapses and of the calcium; cells: of all weights, float64[post *
    pre]; lengths: of the columns' pulses, s.
    """

    tables: PlasticTables
    filters: tuple[Filter, Filter]
    loads: tuple[Load, Load]
    shapes: tuple[Shape, Shape]
    cells: Cells
    gates: Gates
    lengths: F64


@dataclass(frozen=True, slots=True)
class _Ready:
    """What all dies of a process share."""

    cell: CellModel
    gate: GateModel
    extender: SynapseModel
    gate_extender: SynapseModel
    filter: tuple[float, float]  # F, at v_syn and at the line


@lru_cache(maxsize=8)
def _prepare(params: Params, learning: Learning, process: Process) -> _Ready:
    c = capacitance_matrix(dpi_synapse.excitatory_filter(params.synapse), process, ("v_syn", "line"))
    extenders = [
        synapse_model_of(dpi_synapse.build(each.synapse), process) for each in (learning.cell, learning.gate)
    ]
    return _Ready(
        cell_model(learning.cell, process), gate_model(learning.gate, process), extenders[0], extenders[1],
        (float(c[0, 0]), float(c[1, 1])),
    )  # fmt: skip


@lru_cache(maxsize=2)
def _cell_devices(learning: Learning, silicon: Silicon) -> DieDevices:
    """Devices of the whole array, without their gates."""
    place = row_place(NEURONS, (CELL, (NEURONS,)))
    wanted = CELL_DEVICES if silicon.process.effects == "ideal" else WHOLE_DEVICES
    return devices_at(plastic_synapse.cell(learning.cell), place, silicon, {}, wanted)


def build_plastic(
    params: Params, learning: Learning, program: Program, kind: BiasKind, silicon: Silicon, step: float,
    membranes: Membranes,
) -> BuiltPlastic:  # fmt: skip
    """Return all tables of the plastic array on a silicon for steps of `step` s.

    membranes: of the same chip, which say where a membrane of zeta is.
    """
    ready = _prepare(params, learning, silicon.process)
    volts = gate_voltages(plastic_chip(params, learning, program.biases, kind), silicon)
    gates = {
        part: {port: np.asarray(volts[outer]) for port, outer in plastic_ports(part).items()}
        for part in (CELL, GATE, EXTENDER, GATE_EXTENDER)
    }
    slow = devices_at(
        dpi_synapse.excitatory_filter(params.synapse), row_place(NEURONS, (FILTER, ())), silicon,
        part_gates(FILTER, volts),
    )  # fmt: skip
    own = filter_of(slow, *ready.filter, inhibitory=False)
    lengths = pulse_length(
        ready.extender,
        extenders_at(learning.cell.synapse, (("plastic_extender", (NEURONS,)),), silicon, gates[EXTENDER]),
    )
    spikes = pulse_length(
        ready.gate_extender,
        extenders_at(
            learning.gate.synapse, row_place(NEURONS, (GATE_EXTENDER, ())), silicon, gates[GATE_EXTENDER]
        ),
    )
    line = line_voltage(own, program.biases.current("PA_WHIDN_N"), slow.u_t)
    cells = cells_of(_cell_devices(learning, silicon)._replace(gate=gates[CELL]), ready.cell, line)
    learners = devices_at(
        calcium_gate.gate(learning.gate), row_place(NEURONS, (GATE, ())), silicon, gates[GATE]
    )
    found = gates_of(learners, ready.gate)
    latched = (
        program.plastic.latches if program.plastic is not None else np.zeros((NEURONS, NEURONS), np.bool_)
    )
    neuron = devices_at(
        rolls_neuron.build(params.neuron), row_place(NEURONS, ("neuron", ())), silicon,
        part_gates("neuron", volts), NMDA_DEVICES,
    )  # fmt: skip
    share = nmda_share(neuron, membranes)
    membrane = zeta_at(found.membrane, membranes)
    return assemble(
        Parts(own, cells, found, lengths, spikes, latched, share, membrane, silicon.process.v_dd), step
    )


@dataclass(frozen=True, slots=True)
class Parts:
    """What tables are assembled of: a filter, cells and learning circuits, and lengths of pulses (s).

    latched: bool[post, pre]; share: float32[n, rows, 2]; membrane: zeta, float64[n].
    """

    filter: Filter
    cells: Cells
    gates: Gates
    lengths: F64
    spikes: F64
    latched: Bools
    share: F32
    membrane: F64
    v_dd: float


def assemble(p: Parts, step: float) -> BuiltPlastic:
    """Return the tables for steps of `step` s."""
    square, latched = p.latched.shape, p.latched
    lengths = np.broadcast_to(p.lengths, square)
    cell = {name: np.broadcast_to(np.reshape(getattr(p.cells, name), square), square) for name in CELL_ARRAYS}
    charge = np.where(latched, cell["current"] * lengths + cell["switched"], 0.0)
    held = p.cells.capacitance
    held = held.reshape(square) if held.size > 1 else held
    moved = np.where(latched, lengths / held, 0.0)
    up, down, effect = moves(cell["up"] * moved, cell["down"] * moved, p.cells.effect, 0.5 * p.v_dd)
    load = Load(_drawn(cell["current"], latched), cell["idle"].sum(axis=1))
    calcium = Load(p.gates.current, p.gates.idle)
    spike = (p.gates.current * p.spikes + p.gates.switched) / p.gates.filter.unit
    shapes = shape_of(p.filter, load), shape_of(p.gates.filter, calcium)
    banks = bank_of(p.filter, load, shapes[0], step), bank_of(p.gates.filter, calcium, shapes[1], step)
    tables = PlasticTables(
        np.stack([s.omega for s in shapes]).astype(np.float32), banks, spike.astype(np.float32), p.share,
        np.full(square[0], RESTING, np.float32), p.gates.ratio.astype(np.float32),
        p.gates.threshold.astype(np.float32),
        np.broadcast_to((step / p.gates.capacitance)[:, None], (NODES, square[0])).astype(np.float32),
        p.gates.passed.astype(np.float32), p.membrane, np.array([p.v_dd], np.float32),
        _columns(up), _columns(down), _columns(cell["rise"] * step),
        _columns(cell["fall"] * step), _columns(cell["middle"]), _columns(charge / p.filter.unit[:, None]),
        np.array([step * p.cells.more_up.mean(), step * p.cells.more_down.mean()], np.float32), effect,
        None if p.gates.soft is None else np.array(p.gates.soft, np.float32),
    )  # fmt: skip
    return BuiltPlastic(
        tables, (p.filter, p.gates.filter), (load, calcium), shapes, p.cells, p.gates, p.lengths
    )


def moves(up: F64, down: F64, effect: tuple[float, float] | None, half: float) -> tuple[F64, F64, F32 | None]:
    """Return jumps at `half` the supply, V, and `PlasticTables.effect`.

    up, down: of constant currents as they are there, V; effect: as of `Cells`, 1/V.
    """
    if effect is None:
        return up, down, None
    a, b = effect
    return -np.expm1(-a * up) / a, -np.expm1(-b * down) / b, np.array([a, b, half], np.float32)


def nmda_share(d: DieDevices, membranes: Membranes) -> F32:
    """Return what the NMDA gate brings into the input of a current, as lines over zeta, float32[n, rows, 2].

    In weak inversion it is the pair's share times the gains of its two mirrors; under the full law it is that
    of NMDA_CURRENT.
    """
    v, grid = _voltages(membranes)
    share = WholeMembrane(d, v).nmda(NMDA_CURRENT) / NMDA_CURRENT if d.full else _weak_share(d, v)
    slope = np.diff(share, axis=1) / np.diff(grid)[None, :]
    return np.stack((share[:, :-1] - slope * grid[None, :-1], slope), axis=2).astype(np.float32)


def _weak_share(d: DieDevices, v: F64) -> F64:
    """Share of a current at membranes `v`, V, by weak inversion, float64[n, points]."""
    mg1, mg2 = d.fet["nmda_gate.mg1"], d.fet["nmda_gate.mg2"]
    passing = np.log(mg1.current) + d.pinch("nmda_gate.mg1", d.below("v_nmda"))
    pinch = d.columns().pinch("nmda_gate.mg2", d.v_dd - v)
    share = 1.0 / (1.0 + np.exp(np.log(mg2.current)[:, None] + pinch - passing[:, None]))
    for diode, copy in (("nmda_gate.mg4", "nmda_gate.mg5"), ("nmda_gate.mg6", "nmda_gate.mg7")):
        share = share * d.mirror(diode, copy).weak[:, None]
    return share


def zeta_at(v: F64, membranes: Membranes) -> F64:
    """Return zeta of membranes at voltages `v` (V), float64[n], above the top where they do not get there."""
    volts, grid = _voltages(membranes)
    return np.array([np.interp(x, row, grid) for x, row in zip(v, volts, strict=True)])


def _voltages(membranes: Membranes) -> tuple[F64, F64]:
    """Voltages, float64[n, rows + 1], at the ends of a chip's lines, and zeta there."""
    grid = edges(membranes.voltage.shape[1])
    lines = membranes.voltage.astype(np.float64)
    low = lines[:, :, 0] + lines[:, :, 1] * grid[:-1]
    high = lines[:, -1:, 0] + lines[:, -1:, 1] * grid[-1]
    return np.concatenate((low, high), axis=1), grid


def _drawn(current: F64, latched: Bools) -> F64:
    """Mean current of each filter's latched synapses, A, of all where it has none."""
    count = latched.sum(axis=1)
    own = np.where(latched, current, 0.0).sum(axis=1) / np.maximum(count, 1)
    return np.asarray(np.where(count > 0, own, current.mean()))


def _columns(x: F64) -> F32:
    """Values of weights by post and pre, as the kernel has them: float32[pre, post]."""
    return np.ascontiguousarray(np.asarray(x).T, dtype=np.float32)
