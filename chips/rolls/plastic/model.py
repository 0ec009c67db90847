"""Behavioural model of ROLLS' plastic synapses and learning circuits, with a die's own devices.

Weight, of the devices of `circuits.blocks.rolls.plastic_synapse`:

    jump:       dw = I t_pulse / C_w
    drift:      dw/dt = (I_drift - I_off) / C_w, I_off what the shut stacks of the other direction leak, less
                what the one of this direction does; while a neuron lets its weights move, only one of a
                stack's two switches is shut
    threshold:  where the pair mb2, mb3 with its mirror is in balance, weak inversion,
                w = v_wthr + V_T2 - V_T3 + [U_T ln(I_S3 I_S4 / (I_S2 I_S5)) + kappa_p (V_T5 - V_T4)] / kappa_n
                (the second stage turns there too: the first one's gain divides its offset)
    charge:     what mw2 draws through its switches in a pulse, and what their far nodes take

Learning circuit, of `circuits.blocks.rolls.calcium_gate`: the calcium is a DPI filter (`chips.rolls.lumped`)
whose output is that of `mk_thmin`; the other copies are in proportion to it. The membrane's threshold is
found like the weight's, whose mirror is the other way round.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.filter import Filter, filter_of, line_voltage
from chips.rolls.lumped.network import sink_over_line, stack
from chips.rolls.plastic.whole_model import (
    drifts,
    idle_through,
    junction,
    membrane_threshold,
    moved_by,
    one_open,
    shut,
    softness,
    weight_threshold,
    whole_sunk,
)
from circuits.arrays import F64, in_rows
from circuits.blocks.rolls import calcium_gate, plastic_synapse
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.on_die import DieDevices
from circuits.silicon.process import Process

CELL_DEVICES = (
    *(f"mu{k}" for k in (1, 2, 3)), *(f"md{k}" for k in (1, 2, 3)), *(f"mr{k}" for k in (1, 2, 3, 4)),
    *(f"mb{k}" for k in (2, 3, 4, 5)), *(f"mw{k}" for k in (1, 2, 3)),
)  # fmt: skip
WHOLE_DEVICES = (*CELL_DEVICES, "mb1", "mb6", "mb7")  # what the full law needs
OVERS = calcium_gate.THRESHOLDS


@dataclass(frozen=True, slots=True)
class CellModel:
    """Capacitances of a plastic synapse, F."""

    weight: float  # at w
    switch: float  # at the far nodes of the switch to the line
    held: float  # share of it that is at v_shift between pulses


@dataclass(frozen=True, slots=True)
class GateModel:
    """Capacitances of a learning circuit, F."""

    calcium: float  # at v_ca
    line: float
    nodes: tuple[float, float, float]  # of OVERS
    switch: float  # as in `CellModel`
    held: float


class Cells(NamedTuple):
    """Plastic synapses on a die, float64[m] each."""

    up: F64  # A
    down: F64
    rise: F64  # V/s
    fall: F64
    more_up: F64  # V/s, that the drift has more upwards while weights may go up, downwards while down
    more_down: F64
    middle: F64  # V
    current: F64  # A, that a high weight draws in a pulse
    switched: F64  # C, that it draws beside
    idle: F64  # A, between pulses
    capacitance: F64  # F, at w; a number where capacitors do not deviate
    effect: tuple[float, float] | None = None  # 1/V, shares of up and down by w, under the full law


CELL_ARRAYS = Cells._fields[:-2]  # of each weight


class Gates(NamedTuple):
    """Learning circuits on a die, float64[n] each unless said; k counts OVERS."""

    filter: Filter
    current: F64  # A, that a spike's pulse draws from the line
    switched: F64  # C, that it draws beside
    idle: F64  # A, between pulses
    ratio: F64  # float64[3, n]
    threshold: F64  # float64[3, n], A
    passed: F64  # float64[3, n], V
    capacitance: F64  # float64[3], F
    membrane: F64  # V
    soft: tuple[float, float] | None = None  # 1/V, of copies and thresholds by their node, full law


def cell_model(params: plastic_synapse.Params, process: Process) -> CellModel:
    """Return the capacitances of a plastic synapse's nodes."""
    c = capacitance_matrix(plastic_synapse.cell(params), process, ("w", "wx", "ws"))
    far = c[1:, 1:]
    return CellModel(float(c[0, 0]), float(far.sum()), float(far[0, 0] / far.sum()))


def gate_model(params: calcium_gate.Params, process: Process) -> GateModel:
    """Return the capacitances of a learning circuit's nodes."""
    nodes = ("v_ca", "line", *(f"over_{name}" for name in OVERS), "far", "step")
    c = capacitance_matrix(calcium_gate.gate(params), process, nodes)
    far, over = c[5:, 5:], tuple(float(c[2 + k, 2 + k]) for k in range(3))
    return GateModel(
        float(c[0, 0]), float(c[1, 1]), (over[0], over[1], over[2]), float(far.sum()),
        float(far[0, 0] / far.sum()),
    )  # fmt: skip


def cells_of(d: DieDevices, m: CellModel, line: float) -> Cells:
    """Return plastic synapses with the devices `d`, their line at `line` V."""
    switched = m.switch * np.maximum(_highest(d, "mw1", line) - m.held * d.gate["v_shift"], 0.0)
    if d.full:
        return _whole_cells_of(d, m, line, switched)
    up, down = d.saturated("mu3", d.below("v_up")), d.saturated("md3", d.gate["v_dn"])
    above, below = _shut(d, "mu1", "mu2"), _shut(d, "md1", "md2")
    weight = m.weight + d.added("c_w")
    more = d.saturated("mu1", 0.0) - above, d.saturated("md1", 0.0) - below
    rise = d.saturated("mr2", d.below("v_driftup")) + above - below - d.saturated("mr3", 0.0)
    fall = d.saturated("mr4", d.gate["v_driftdn"]) + below - above - d.saturated("mr1", 0.0)
    return Cells(
        up, down, rise / weight, fall / weight, more[0] / weight, more[1] / weight,
        _balance(d, ("mb2", "mb3", "mb5", "mb4"), d.gate["v_wthr"]),
        _sunk(d, "mw1", "mw3", "mw2", "v_weight", line), switched,
        d.saturated("mw1", 0.0, d.gate["v_shift"]), np.asarray(weight),
    )  # fmt: skip


def _whole_cells_of(d: DieDevices, m: CellModel, line: float, switched: F64) -> Cells:
    """The same under the law with second-order effects."""
    (up, higher), (down, lower) = moved_by(d, "mu3", d.below("v_up")), moved_by(d, "md3", d.gate["v_dn"])
    leaks, weight = shut(d), m.weight + d.added("c_w")
    (rise, fall), more = drifts(d, leaks), one_open(d, leaks)
    return Cells(
        up, down, rise / weight, fall / weight, more[0] / weight, more[1] / weight,
        weight_threshold(d), whole_sunk(d, ("mw1", "mw3"), "mw2", "v_weight", line), switched,
        idle_through(d, "mw1"), np.asarray(weight), (higher, lower),
    )  # fmt: skip


def gates_of(d: DieDevices, m: GateModel, line: float | None = None) -> Gates:
    """Return learning circuits with the devices `d`; line: V, found from the step's current unless given."""
    aliased = d._replace(
        fet={**d.fet, "md5": d.fet["mk_thmin"]},
        gate={**d.gate, "v_tau": d.gate["v_catau"], "v_thr": d.gate["v_cathr"]},
        more=None if d.more is None else {"c_syn": d.more["c_ca"], "c_line": d.more["c_line"]},
    )
    own = filter_of(aliased, m.calcium, m.line, inhibitory=False)
    nominal = float(np.mean(d.saturated("mc2", d.gate["v_caw"])))
    at = line_voltage(own, nominal, d.u_t) if line is None else line
    ratio, threshold, passed = [], [], []
    for name, inverter in zip(OVERS, ("mq3", "mq6", "mq5"), strict=True):
        ratio.append(d.mirror("mk_thmin", f"mk_{name}").weak)
        passed.append(d.inverter_threshold(inverter))
        threshold.append(_threshold(d, name, passed[-1]))
    switched = m.switch * np.maximum(_highest(d, "mc1", at) - m.held * d.gate["v_shift"], 0.0)
    if d.full:
        drawn, idle = whole_sunk(d, ("mc1", "mc3"), "mc2", "v_caw", at), idle_through(d, "mc1")
        membrane = membrane_threshold(d)
    else:
        drawn = _sunk(d, "mc1", "mc3", "mc2", "v_caw", at)
        idle = d.saturated("mc1", 0.0, d.gate["v_shift"])
        membrane = _balance(d, ("mm2", "mm3", "mm4", "mm5"), d.gate["v_memthr"])
    return Gates(
        own, drawn, switched, idle, np.array(ratio), np.array(threshold), np.array(passed), np.array(m.nodes),
        membrane, softness(d, OVERS) if d.full else None,
    )  # fmt: skip


def _threshold(d: DieDevices, name: str, passed: F64) -> F64:
    """What the calcium's copy has to bring for its node to rise, A; passed: where that node turns, V."""
    device, gate = f"ms_{name}", d.gate[f"v_{name}"]
    if not d.full:
        return d.saturated(device, gate)
    copy = junction(d, f"mk_{name}", d.below("v_cathr"), d.v_dd - passed)
    return np.asarray(d.current(device, gate, passed) - copy)


def _shut(d: DieDevices, first: str, second: str) -> F64:
    """What two shut switches in series leak, A."""
    out, far = np.empty(d.copies), np.full(d.copies, 0.5 * d.v_dd / d.u_t)
    lower, upper = (_each(d.pinch(name, 0.0), d) for name in (first, second))
    stack(d.fet[first].current, lower, d.fet[second].current, upper, far, out)
    return out


def _each(x: F64, d: DieDevices) -> F64:
    return in_rows(np.broadcast_to(x, d.copies))


def _balance(d: DieDevices, names: tuple[str, str, str, str], reference: F64) -> F64:
    """Input at which a pair is in balance, V.

    names: of its input and reference, and of the mirror's devices at the reference and at the input.
    """
    a, b, opposite, beside = (d.fet[name] for name in names)
    logs = np.log(b.current * beside.current / (a.current * opposite.current))
    mirror = opposite.kappa * (opposite.threshold - beside.threshold)
    return np.asarray(reference + a.threshold - b.threshold + (d.u_t * logs + mirror) / a.kappa)


def _highest(d: DieDevices, switch: str, line: float) -> F64:
    """Where the node behind a switch ends that is on, V."""
    return np.minimum(line, d.pinch(switch, d.v_dd) * d.u_t)


def _sunk(d: DieDevices, near: str, far: str, sink: str, gate: str, line: float) -> F64:
    """What a transistor draws from a line through two switches that are on, A."""
    a, b = d.fet[near].current, d.fet[far].current
    pinch = 0.5 * (d.pinch(near, d.v_dd) + d.pinch(far, d.v_dd))
    shut = np.full(d.copies, -60.0)
    none, out = np.full(d.copies, 1e-30), np.empty((d.copies, 1))
    pinched = _each(d.pinch(sink, d.gate[gate]), d)
    lines = np.array([d.fet[sink].current, pinched, none, shut, none, shut])
    sink_over_line(a * b / (a + b), _each(pinch, d), lines, np.array([line / d.u_t]), out)
    return out[:, 0].copy()
