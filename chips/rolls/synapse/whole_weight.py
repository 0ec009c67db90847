"""Currents of the weight levels of ROLLS' synapses and their pulse, under the law with all its effects.

The networks are those of `chips.rolls.synapse.weight` and of `chips.rolls.synapse.model.pulse_of`, with every
drain where it stands (`chips.rolls.lumped.whole`). n: copies of the synapse.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import TERMS, points_of, rows_of, series
from chips.rolls.lumped.whole_sum import mirrored_sum, sunk_sum
from circuits.arrays import F64
from circuits.lowering.on_die import DieDevices

POINTS = 65  # of the pulse's node, over which its time is summed
HELD = 0.4  # of the supply, ours: a line at which a leak is taken
_NUDGE = 1e-3  # V, of a numerical slope


class Lines(NamedTuple):
    """Devices that carry a level's current, or leak: float64[k, TERMS, n], and their gates, float64[k, n]."""

    rows: F64
    gates: F64


class Drawn(NamedTuple):
    """What an excitatory level's diode gets, A, and its voltage, V: in a pulse and between, float64[2, n].

    source: of the weights, V below the supply, likewise.
    """

    current: F64
    gate: F64
    source: F64


def sources(d: DieDevices, bits: tuple[bool, bool]) -> Lines:
    """Return the excitatory weights' devices, and of the second and third the switches; bits: the latches."""
    names = [f"synapse.me{k}" for k in (2, 4, 3, 6, 5)]
    on = [d.v_dd if bit else 0.0 for bit in bits]
    gates = (d.below("v_exc"), d.below("v_exc0"), on[0], d.below("v_exc1"), on[1])
    return Lines(
        np.array([rows_of(d.fet[name]) for name in names]),
        np.array([np.broadcast_to(g, d.copies) for g in gates]),
    )


def sinks(d: DieDevices, bits: tuple[bool, bool]) -> Lines:
    """Return the three inhibitory weights' devices, or their switches where these let less through."""
    rows, gates = np.empty((3, TERMS, d.copies)), np.empty((3, d.copies))
    for k, (device, port, on) in enumerate(((2, "", True), (4, "0", bits[0]), (6, "1", bits[1]))):
        name, given = f"synapse.mi{device}", d.gate[f"v_inh{port}"]
        rows[k], gates[k] = rows_of(d.fet[name]), given
        if not on:
            switch = f"synapse.mi{device - 1}"
            less = d.saturated(switch, 0.0) < d.saturated(name, given)
            rows[k] = np.where(less, rows_of(d.fet[switch]), rows[k])
            gates[k] = np.where(less, 0.0, gates[k])
    return Lines(rows, gates)


def drawn_by(d: DieDevices, lines: Lines) -> Drawn:
    """Return what the mirror of excitatory weights gets of `lines`."""
    found = np.empty((2, 3, d.copies))
    top, mirror = rows_of(d.fet["synapse.me1"]), rows_of(d.fet["synapse.me7"])
    for k, switch in enumerate((d.v_dd, 0.0)):
        mirrored_sum(top, *lines, mirror, (switch, d.v_dd), found[k])
    return Drawn(found[:, 0], found[:, 1], found[:, 2])


def sourced(d: DieDevices, gate: F64, grid: F64) -> F64:
    """Return what the mirror's copy draws from the line through its switch, A, float64[n, grid].

    gate: of the mirror, V, float64[n]; grid: voltages of the line, V.
    """
    out = np.empty((d.copies, grid.size))
    low, high, line = (points_of(x, *out.shape) for x in (gate, d.v_dd, grid[None, :]))
    series(rows_of(d.fet["synapse.me8"]), rows_of(d.fet["synapse.me9"]), low, high, line, out)
    return out


def sunk(d: DieDevices, lines: Lines, grid: F64) -> F64:
    """Return what an inhibitory level draws from the line, A, float64[n, grid]; grid: of the line, V."""
    out = np.empty((d.copies, grid.size))
    sunk_sum(joined(d, "synapse.mi1", "synapse.mi7"), *lines, d.v_dd, grid, out)
    return out


def joined(d: DieDevices, first: str, second: str) -> F64:
    """Return two switches with one gate as one of twice the length; both are far in their triode region."""
    near, far = rows_of(d.fet[first]), rows_of(d.fet[second])
    both = 0.5 * (near + far)
    both[0] = near[0] * far[0] / (near[0] + far[0])  # specific current
    both[6] *= 0.5  # early
    return both


def idle(d: DieDevices, *, inhibitory: bool) -> F64:
    """Return what each synapse leaks from a line between pulses, A."""
    switch = "synapse.mi1" if inhibitory else "synapse.me9"
    return d.current(switch, 0.0, HELD * d.v_dd, d.gate["v_shift"])


def before(d: DieDevices, drawn: Drawn, quiet: float, capacitance: float) -> F64:
    """Return where the mirror's gate is `quiet` s after a pulse, V; capacitance: at that gate, F."""
    high, rest = drawn.gate
    slope, own = fall(d, high)
    falls = np.exp(-slope * high) + slope * own * quiet / capacitance
    return np.asarray(np.maximum(-np.log(falls) / slope, rest))


def fall(d: DieDevices, gate: F64) -> tuple[F64, F64]:
    """Return slope (1/V) and current at 0 V (A) of the mirror's diode as it goes on from its gate, V."""
    more, less = (d.pinch("synapse.me7", gate + x) for x in (_NUDGE, -_NUDGE))
    slope = np.asarray((more - less) / (2.0 * _NUDGE))
    return slope, np.asarray(d.weak("synapse.me7", gate) * np.exp(-slope * gate))


def recharge(d: DieDevices, capacitance: F64, threshold: F64, moved: tuple[F64, F64]) -> F64:
    """Return the time in which I_pwlk brings the pulse's node to the threshold of its inverter, s.

    capacitance: at the node, F, float64[n]; moved: charge that it needs more at ground and at
    the threshold, C.
    """
    over, v = d.columns(), threshold[:, None] * np.linspace(0.0, 1.0, POINTS)
    rising = over.current("extender.mp2", points_of(d.below("v_pwlk"), *v.shape), d.v_dd - v)
    rising = rising - over.current("extender.mp1", 0.0, v)
    taken = np.trapezoid(capacitance[:, None] / rising, v, axis=1)
    return np.asarray(taken + moved[0] / rising[:, 0] + moved[1] / rising[:, -1])
