"""The state of a ROLLS chip as voltages, by which it goes on at another temperature.

What is known of a neuron that rises to its spike is the time that is left. By the time that its own current
needs to the top, this is a place on its way, which is a voltage; there the other temperature takes over.
Where less is left than a spike takes from the top on, and in the refractory period, what is left is the same
share of what it is at the other temperature.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.layout import DELAY, NEVER, OCTAVE_BITS, REFRACTORY, SHUT, TOP, WAIT, ZETA, Membranes
from chips.rolls.lumped.filter import move_filters
from chips.rolls.lumped.grid import edges
from chips.rolls.tables import Built
from circuits.arrays import F64

PER = 1 << OCTAVE_BITS  # lines of an octave of zeta


def zeta_of(built: Built, v: F64) -> F64:
    """Return zeta of membrane voltages (V), float64[256]."""
    lines = built.tables.membranes.voltage
    edge = edges(lines.shape[1])[:-1]
    found = np.empty(v.size)
    for k in range(v.size):
        found[k] = np.interp(v[k], lines[k, :, 0] + lines[k, :, 1] * edge, edge)
    return found


def voltage_of(built: Built, zeta: F64) -> F64:
    """Return membrane voltages of zeta, V, float64[256]."""
    mantissa, exponent = np.frexp(zeta)
    row = ((exponent - 1) << OCTAVE_BITS) + ((2.0 * mantissa - 1.0) * PER).astype(np.int64)
    lines = built.tables.membranes.voltage[np.arange(zeta.size), row]
    return np.asarray(lines[:, 0] + lines[:, 1] * zeta)


def converted(values: F64, old: Built, new: Built) -> F64:
    """Return the state at another temperature: all voltages stay."""
    out = values.copy()
    _land(out, old.tables.membranes, new.tables.membranes)
    out[ZETA] = zeta_of(new, voltage_of(old, out[ZETA]))
    move_filters(out, old, new)
    return out


def _land(out: F64, old: Membranes, new: Membranes) -> None:
    """Take neurons that rise to where they are on their way, and what is left of spikes and pauses along."""
    before, after, shut = old.spiking, new.spiking, out[SHUT].copy()
    sure = shut < 0.5 * NEVER
    rising = sure & (shut > before[:, DELAY])
    for k in np.flatnonzero(rising).tolist():
        out[ZETA, k] = _place(old, k, shut[k] - before[k, DELAY], out[ZETA, k])
    out[SHUT, rising], out[WAIT, rising] = NEVER, 0.0
    ending = sure & ~rising
    share, pause = (after[:, column] / before[:, column] for column in (DELAY, REFRACTORY))
    out[SHUT, ending] = shut[ending] * share[ending]
    out[WAIT] = np.where(ending, out[SHUT] + after[:, REFRACTORY], out[WAIT])
    waiting = ~sure & (out[WAIT] > 0.0)
    out[WAIT, waiting] *= pause[waiting]


def _place(m: Membranes, k: int, left: float, begun: float) -> float:
    """Zeta of neuron k on its way from `begun` to the top, where `left` s are left by its own current."""
    top = float(m.spiking[k, TOP])
    edge = edges(m.rise.shape[1])[:-1]
    times = m.rise[k, :, 0] + m.rise[k, :, 1] * edge
    on = (edge >= begun) & (edge < top)
    zeta, rest = np.append(edge[on], top), np.append(times[on], 0.0)
    return float(np.interp(-left, -rest, zeta)) if on.any() else begun
