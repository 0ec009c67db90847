"""The charge that one event draws through its filter's line, of every synapse of a ROLLS chip.

`Q = I_w (t_end - t_begin - t_late)`: the level's current on this die (`chips.rolls.synapse.weight`), the
pulse of the column's extender, and how late the excitatory mirror comes. The inhibitory current is that with
the line where the pair holds it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.network import degenerated_sum, diode, sink_over_line
from chips.rolls.synapse.model import SynapseModel, pulse_of
from chips.rolls.synapse.weight import BITS, branches
from chips.rolls.synapse.whole_weight import before, drawn_by, idle, sinks, sourced, sources, sunk
from circuits.arrays import F64
from circuits.lowering.on_die import DieDevices

WEIGHT_DEVICES = (*(f"me{k}" for k in range(1, 10)), *(f"mi{k}" for k in (1, 2, 3, 4, 5, 6, 7)))

Bits = tuple[bool, bool]  # latches w0 and w1

QUIET = 10e-3  # s, ours: time between pulses for which the mirror's lateness is taken


class Draw(NamedTuple):
    """What synapses draw in a pulse: current (A), how late it comes (s), charge of their switches (C)."""

    current: F64
    late: F64
    switched: F64


def draw_of(model: SynapseModel, d: DieDevices, level: int, line: float) -> Draw:
    """Return what synapses `d` draw at `level`, 1 to 4 or -1 to -4, with their line at `line` V.

    The nodes behind the switch follow the line from v_shift as the pulse begins.
    """
    sign, switch = (0, "synapse.me9") if level > 0 else (1, "synapse.mi1")
    up = np.minimum(line, d.pinch(switch, d.v_dd) * d.u_t) - model.switch_held[sign] * d.gate["v_shift"]
    switched = model.switch_capacitance[sign] * np.maximum(up, 0.0)
    bits = BITS[abs(level) - 1]
    if d.full:
        current, late = (
            _whole_excitatory(model, d, bits, line) if level > 0 else _whole_inhibitory(d, bits, line)
        )
        return Draw(current, late, switched)
    lines = np.array([x for pair in branches(d, "e" if level > 0 else "i", bits) for x in pair])
    current, late = _excitatory(model, d, lines) if level > 0 else _inhibitory(d, lines, line)
    return Draw(current, late, switched)


def charge_of(drawn: Draw, length: F64) -> F64:
    """Return the charge of one event with a pulse of `length` (s), C."""
    return np.asarray(drawn.current * np.maximum(length - drawn.late, 0.0) + drawn.switched)


class Mirror(NamedTuple):
    """The mirror of excitatory weights: what its diode gets in a pulse and between, and its gate.

    given, off: A; high: of the gate in a pulse, V; before: QUIET after one, V; float64[m] each.
    """

    given: F64
    off: F64
    high: F64
    before: F64


def mirror_of(model: SynapseModel, d: DieDevices, lines: F64) -> Mirror:
    """Return the excitatory mirror of synapses; lines: their weights, as of `degenerated_sum`."""
    u_t, top, me7 = d.u_t, d.fet["synapse.me1"], d.fet["synapse.me7"]
    given, gate = [], []
    for switch in (d.v_dd, 0.0):
        current, voltage = np.empty(d.copies), np.empty(d.copies)
        degenerated_sum(top.current, d.pinch("synapse.me1", switch), lines, d.v_dd / u_t, current)
        diode(me7.current, me7.threshold / u_t, me7.kappa, current, d.v_dd / u_t, voltage)
        given.append(current)
        gate.append(voltage * u_t)
    # the mirror's gate falls by its own current between pulses
    slope = me7.kappa / u_t
    own = d.weak("synapse.me7", 0.0)
    fall = np.exp(-slope * gate[0]) + slope * own * QUIET / model.mirror_capacitance
    before = np.maximum(-np.log(fall) / slope, gate[1])
    return Mirror(given[0], given[1], gate[0], before)


def _excitatory(model: SynapseModel, d: DieDevices, lines: F64) -> tuple[F64, F64]:
    mirror = mirror_of(model, d, lines)
    lifted = d.pinch("synapse.me9", d.v_dd) * d.u_t - d.gate["v_shift"]
    late = model.mirror_capacitance * (mirror.high - mirror.before) - model.mirror_coupling * lifted
    return d.saturated("synapse.me8", mirror.high), np.asarray(late / mirror.given)


def _inhibitory(d: DieDevices, lines: F64, line: float) -> tuple[F64, F64]:
    near, far = d.fet["synapse.mi1"], d.fet["synapse.mi7"]
    both = near.current * far.current / (near.current + far.current)
    pinch = 0.5 * (d.pinch("synapse.mi1", d.v_dd) + d.pinch("synapse.mi7", d.v_dd))
    out = np.empty((d.copies, 1))
    sink_over_line(both, pinch, lines, np.array([line / d.u_t]), out)
    return out[:, 0].copy(), np.zeros(d.copies)


def _whole_excitatory(model: SynapseModel, d: DieDevices, bits: Bits, line: float) -> tuple[F64, F64]:
    """The same under the law with second-order effects, at the line's voltage, V."""
    given = drawn_by(d, sources(d, bits))
    high, low = given.gate[0], before(d, given, QUIET, model.mirror_capacitance)
    lifted = d.pinch("synapse.me9", d.v_dd) * d.u_t - d.gate["v_shift"]
    late = model.mirror_capacitance * (high - low) - model.mirror_coupling * lifted
    return sourced(d, high, np.array([line]))[:, 0].copy(), np.asarray(late / given.current[0])


def _whole_inhibitory(d: DieDevices, bits: Bits, line: float) -> tuple[F64, F64]:
    """The same under the law with second-order effects."""
    return sunk(d, sinks(d, bits), np.array([line]))[:, 0].copy(), np.zeros(d.copies)


def idle_draw(d: DieDevices, *, inhibitory: bool) -> F64:
    """Return what each synapse leaks from a line between pulses, A."""
    if d.full:
        return idle(d, inhibitory=inhibitory)
    return d.saturated("synapse.mi1" if inhibitory else "synapse.me9", 0.0, d.gate["v_shift"])


def pulse_length(model: SynapseModel, extenders: DieDevices) -> F64:
    """Return the length of the pulse that an event makes, of each extender, s."""
    begin, end = pulse_of(model, extenders)
    return np.asarray(end - begin)
