"""Tables of a ROLLS chip's depressed synapses, on a die at a temperature, from its transistors."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from chips.noise import SiliconNoise, die_name
from chips.noise_draw import new_draws
from chips.rolls.circuit import NAME, Params, chip
from chips.rolls.depression.circuit import CELLS, RECOVERY, STD, check_cell, depressing_chip
from chips.rolls.depression.layout import (
    COEFFICIENTS,
    BuiltDepression,
    DepressionNoise,
    DepressionTables,
    most_devices,
)
from chips.rolls.depression.model import CELL_DEVICES, CellModel, Depression, cell_model, depression_of
from chips.rolls.depression.program import ShortTermDepression
from chips.rolls.layout import ZERO
from chips.rolls.lumped.filter import line_voltage
from chips.rolls.parts import devices_at, gate_voltages, part_gates, row_place
from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import Program, level_current
from chips.rolls.synapse.weight import BITS
from chips.rolls.tables import Built, prepare, synapse_devices
from circuits.arrays import F64, I32, I64
from circuits.blocks.rolls.depressing_synapse import Params as CellParams
from circuits.blocks.rolls.depressing_synapse import depression
from circuits.circuit import BiasKind
from circuits.devices.ekv import interpolation
from circuits.lowering.on_die import DieDevices
from circuits.silicon.process import ELEMENTARY_CHARGE, Process
from circuits.silicon.silicon import Silicon

LEVELS = (1, 2, 3, 4)


def with_depression(
    built: Built, params: Params, program: Program, kind: BiasKind, silicon: Silicon,
    noise: SiliconNoise | None = None,
) -> Built:  # fmt: skip
    """Return the tables of a chip on a silicon with its depressed synapses.

    These leave the table of constant charges. noise: of its devices, None for none. The tables stay as they
    are where the program has no depression. Raises `ParameterError` for a cell of another synapse.
    """
    chosen = program.depression
    if chosen is None:
        return built
    check_cell(chosen, params.synapse)
    d = _devices(params, program, chosen, kind, silicon)
    found = _assembled(built, params, program, chosen, d, silicon.process)
    if noise is not None and found.step.size:
        found = replace(found, noise=cell_noise(found, chosen, silicon, noise))
    inhibiting = np.minimum(built.tables.charges, ZERO)
    return replace(built, tables=built.tables._replace(charges=inhibiting), depression=found)


def cell_noise(
    found: BuiltDepression, chosen: ShortTermDepression, silicon: Silicon, noise: SiliconNoise
) -> DepressionNoise:
    """Return the noise of the cells' steps and recoveries."""
    diffuse = ELEMENTARY_CHARGE / (_cell_model(chosen.cell, silicon.process).gate * found.u_t)
    path = die_name(NAME, silicon.die)
    return DepressionNoise(
        new_draws(noise.seed, noise.trial, path, most_devices(found.tables)),
        np.array([diffuse], np.float32),
        (found.electrons * diffuse * found.step / found.u_t).astype(np.float32),
    )


def _devices(
    params: Params, program: Program, chosen: ShortTermDepression, kind: BiasKind, silicon: Silicon
) -> DieDevices:
    """Weight devices of the whole array, and those of its cells."""
    whole = depressing_chip(chip(params, program.biases, kind), chosen, program.biases, kind)
    volts = gate_voltages(whole, silicon)
    gates = part_gates("synapse", volts) | {"v_std": volts[STD], "v_rec": volts[RECOVERY]}
    d, cells = synapse_devices(params, silicon), _cell_devices(chosen.cell, silicon)
    return d._replace(
        fet={**d.fet, **cells.fet},
        more=cells.more,
        gate={port: np.asarray(v, dtype=np.float64) for port, v in gates.items()},
    )


@lru_cache(maxsize=2)
def _cell_devices(params: CellParams, silicon: Silicon) -> DieDevices:
    """Devices of all cells, without their gates."""
    found: dict[str, DieDevices] = {}
    for name in CELLS:
        place = row_place(NEURONS, (name, (NEURONS,)))
        found[name] = devices_at(depression(params), place, silicon, {}, CELL_DEVICES, f"{name}.")
    first = found[CELLS[0]]
    more = {name: x for d in found.values() for name, x in (d.more or {}).items()}
    fets = {name: fet for d in found.values() for name, fet in d.fet.items()}
    return first._replace(fet=fets, more=more or None)


@lru_cache(maxsize=8)
def _cell_model(params: CellParams, process: Process) -> CellModel:
    return cell_model(params, process)


def _assembled(
    built: Built, params: Params, program: Program, chosen: ShortTermDepression, d: DieDevices,
    process: Process,
) -> BuiltDepression:  # fmt: skip
    pre, post = np.nonzero(program.levels.T > 0)
    level = program.levels[post, pre].astype(np.int64)
    first = np.concatenate(([0], np.cumsum(np.array([0, *(1 + sum(b) for b in BITS)])[level])))
    rows = _Rows(int(first[-1]), pre.size)
    model, synapse = _cell_model(chosen.cell, process), prepare(params, process).synapse
    unit = built.filters[0].unit
    for each in LEVELS:
        mine = np.flatnonzero(level == each)
        if mine.size:
            line = line_voltage(built.filters[0], level_current(program.biases, each), d.u_t)
            at = d.taken(post[mine] * NEURONS + pre[mine])
            on = depression_of(model, synapse, at, each, line, built.lengths[pre[mine]])
            rows.take(on, mine, first[mine], unit[post[mine]])
    slot = np.full((NEURONS, NEURONS), -1, np.int32)
    slot[pre, post] = np.arange(pre.size)
    start = np.searchsorted(pre, np.arange(NEURONS + 1)).astype(np.int64)
    return rows.built(start, post.astype(np.int32), slot, first.astype(np.int32), built.tables.step)


class _Rows:
    """Devices and synapses of all levels, filled a level at a time."""

    def __init__(self, devices: int, synapses: int) -> None:
        self.step, self.tau, self.electrons, self.rest = np.zeros((4, devices))
        self.bend, self.scale, self.part = np.zeros((3, devices))
        self.shape = np.zeros((synapses, COEFFICIENTS))
        self.kappa, self.u_t = 1.0, 1.0

    def take(self, on: Depression, synapses: I64, first: I64, unit: F64) -> None:
        """Synapses of a level, whose devices begin at `first`; unit: charge that moves z by one, C."""
        b = on.branches
        self.kappa, self.u_t = b.kappa, b.u_t
        slope, mean, variance = b.kappa / b.u_t, b.mean, b.variance
        rest = (b.current * interpolation(b.pinch)).sum(axis=0)
        for j in range(b.step.shape[0]):
            at = first + j
            self.step[at], self.tau[at] = b.step[j], b.tau[j]
            self.electrons[at], self.rest[at] = b.electrons[j], b.rest[j]
            self.scale[at] = np.exp(0.5 * (b.pinch[j] - slope * mean[j]))
            self.bend[at] = 0.25 * slope**2 * variance[j]
            self.part[at] = b.current[j] / rest
        self.shape[synapses] = on.curve / unit[:, None]

    def built(self, start: I64, post: I32, slot: I32, first: I32, step: float) -> BuiltDepression:
        """Tables for steps of `step` s."""
        tables = DepressionTables(
            start, post, slot, first, *(x.astype(np.float32) for x in (
                step / self.tau, np.exp(-self.step / self.u_t), self.scale, self.bend, self.part,
                np.array([0.5 * self.kappa]), self.shape,
            )),
        )  # fmt: skip
        return BuiltDepression(tables, self.step, self.tau, self.u_t, self.electrons, self.rest)
