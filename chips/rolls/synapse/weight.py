"""Currents of the weight levels of ROLLS' synapses on a die.

Sums hold in saturation; the excitatory ones have their switch at the common source, which the current pulls
down. n: copies of the synapse. Levels are those of `circuits.blocks.rolls.dpi_synapse.latches`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.network import degenerated_sum, diode, sink_over_line, stack
from chips.rolls.synapse.whole_weight import drawn_by, fall, idle, sinks, sourced, sources, sunk
from circuits.arrays import F64
from circuits.lowering.on_die import DieDevices

BITS = ((False, False), (True, False), (False, True), (True, True))  # w0, w1 of levels 1 to 4
GRID = 257  # points of a table over the line's voltage


class Weights(NamedTuple):
    """Currents of n synapses of one level, float64[n] unless said."""

    current: F64  # A, drawn from the line while the pulse lasts
    off: F64  # A, after it
    shape: F64  # float64[n, GRID]: share of `current` over the line's voltage, from 0 V to the supply
    delay: F64  # s, by which the current comes late where the mirror starts at rest
    mirror_level: F64  # V, of the mirror's gate while the pulse lasts
    mirror_rest: F64  # V
    mirror_current: F64  # A, I_S e^(-kappa V_T0 / U_T) of its diode


def weights_on(d: DieDevices, level: int, mirror_capacitance: float, mirror_coupling: float) -> Weights:
    """Return the currents of `level` (1 to 4, -1 to -4) of every copy."""
    if d.full:
        bits, capacitances = BITS[abs(level) - 1], (mirror_capacitance, mirror_coupling)
        return _whole_excitatory(d, bits, capacitances) if level > 0 else _whole_inhibitory(d, bits)
    return (_excitatory if level > 0 else _inhibitory)(
        d, BITS[abs(level) - 1], mirror_capacitance, mirror_coupling
    )


def branches(d: DieDevices, sign: str, bits: tuple[bool, bool]) -> list[tuple[F64, F64]]:
    """Return (specific current, pinch-off voltage) of the devices that carry current, or leak.

    sign: `e` or `i`; bits: latches w0 and w1 of the level.
    """
    found = []
    names = ("me", "v_exc") if sign == "e" else ("mi", "v_inh")
    for device, port, on in ((2, "", True), (4, "0", bits[0]), (6, "1", bits[1])):
        name = f"synapse.{names[0]}{device}"
        gate = d.below(f"{names[1]}{port}") if sign == "e" else d.gate[f"{names[1]}{port}"]
        pinch = np.broadcast_to(d.pinch(name, gate), d.copies)
        current = d.fet[name].current
        if not on:
            # the switch's off current where that is less
            switch = f"synapse.{names[0]}{device - 1}"
            closed = np.broadcast_to(d.pinch(switch, 0.0), d.copies)
            less = d.saturated(switch, 0.0) < d.saturated(name, gate)
            current = np.where(less, d.fet[switch].current, current)
            pinch = np.where(less, closed, pinch)
        found.append((np.ascontiguousarray(current), np.ascontiguousarray(pinch)))
    return found


def _excitatory(d: DieDevices, bits: tuple[bool, bool], capacitance: float, coupling: float) -> Weights:
    n, u_t = d.copies, d.u_t
    branch = branches(d, "e", bits)
    lines = np.array([x for pair in branch for x in pair])
    top = d.fet["synapse.me1"]
    given = []
    for gate in (d.v_dd, 0.0):
        out = np.empty(n)
        degenerated_sum(top.current, d.pinch("synapse.me1", gate), lines, d.v_dd / u_t, out)
        given.append(out)
    me7, me8 = d.fet["synapse.me7"], d.fet["synapse.me8"]
    em = []
    for current in given:
        out = np.empty(n)
        diode(me7.current, me7.threshold / u_t, me7.kappa, current, d.v_dd / u_t, out)
        em.append(out * u_t)
    me9 = d.fet["synapse.me9"]
    out = np.empty(n * GRID)
    stack(
        np.repeat(me8.current, GRID), np.repeat(d.pinch("synapse.me8", em[0]), GRID),
        np.repeat(me9.current, GRID), np.repeat(d.pinch("synapse.me9", d.v_dd), GRID),
        np.tile(np.linspace(0.0, d.v_dd / u_t, GRID), n), out,
    )  # fmt: skip
    lifted = d.pinch("synapse.me9", d.v_dd) * u_t - d.gate["v_shift"]
    return _weights(
        out.reshape(n, GRID),
        d.saturated("synapse.me9", 0.0, d.gate["v_shift"]),
        # the mirror's drain rises with its switch and lifts the gate
        (capacitance * (em[0] - em[1]) - coupling * lifted) / given[0],
        em[0],
        em[1],
        d.weak("synapse.me7", 0.0),
    )


def _inhibitory(d: DieDevices, bits: tuple[bool, bool], _: float, __: float) -> Weights:
    n, u_t = d.copies, d.u_t
    lines = np.array([x for pair in branches(d, "i", bits) for x in pair])
    near, far = d.fet["synapse.mi1"], d.fet["synapse.mi7"]
    # two switches with one gate are one of twice the length; both are far in their triode region
    both = near.current * far.current / (near.current + far.current)
    pinch = 0.5 * (d.pinch("synapse.mi1", d.v_dd) + d.pinch("synapse.mi7", d.v_dd))
    out = np.empty((n, GRID))
    sink_over_line(both, pinch, lines, np.linspace(0.0, d.v_dd / u_t, GRID), out)
    none = np.zeros(n)
    return _weights(out, d.saturated("synapse.mi1", 0.0, d.gate["v_shift"]), none, none, none, np.ones(n))


def _whole_excitatory(d: DieDevices, bits: tuple[bool, bool], c: tuple[float, float]) -> Weights:
    """The same under the law with all its effects; c: of the mirror's gate, and to its drain, F."""
    given = drawn_by(d, sources(d, bits))
    (high, rest), grid = given.gate, np.linspace(0.0, d.v_dd, GRID)
    lifted = d.pinch("synapse.me9", d.v_dd) * d.u_t - d.gate["v_shift"]
    delay = (c[0] * (high - rest) - c[1] * lifted) / given.current[0]
    return _weights(
        sourced(d, high, grid), idle(d, inhibitory=False), delay, high, rest, fall(d, high)[1]
    )  # fmt: skip


def _whole_inhibitory(d: DieDevices, bits: tuple[bool, bool]) -> Weights:
    """The same under the law with all its effects."""
    drawn, none = sunk(d, sinks(d, bits), np.linspace(0.0, d.v_dd, GRID)), np.zeros(d.copies)
    return _weights(drawn, idle(d, inhibitory=True), none, none, none, np.ones(d.copies))


def _weights(drawn: F64, off: F64, delay: F64, level: F64, rest: F64, mirror: F64) -> Weights:
    current = drawn[:, -1]
    return Weights(current, off, drawn / current[:, None], delay, level, rest, mirror)
