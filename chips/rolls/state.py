"""The state of a ROLLS chip as voltages, by which it goes on at another temperature."""

from __future__ import annotations

import numpy as np

from chips.rolls.layout import OCTAVE_BITS, ZETA
from chips.rolls.lumped.filter import move_filters
from chips.rolls.lumped.grid import edges
from chips.rolls.tables import Built
from circuits.arrays import F64

PER = 1 << OCTAVE_BITS  # lines of an octave of zeta


def zeta_of(built: Built, v: F64) -> F64:
    """Return zeta of membrane voltages (V), float64[256]."""
    lines = built.tables.membranes.lines
    edge = edges(lines.shape[1])[:-1]
    found = np.empty(v.size)
    for k in range(v.size):
        found[k] = np.interp(v[k], lines[k, :, 6] + lines[k, :, 7] * edge, edge)
    return found


def voltage_of(built: Built, zeta: F64) -> F64:
    """Return membrane voltages of zeta, V, float64[256]."""
    mantissa, exponent = np.frexp(zeta)
    row = ((exponent - 1) << OCTAVE_BITS) + ((2.0 * mantissa - 1.0) * PER).astype(np.int64)
    lines = built.tables.membranes.lines[np.arange(zeta.size), row]
    return np.asarray(lines[:, 6] + lines[:, 7] * zeta)


def converted(values: F64, old: Built, new: Built) -> F64:
    """Return the state at another temperature: all voltages stay."""
    out = values.copy()
    out[ZETA] = zeta_of(new, voltage_of(old, values[ZETA]))
    move_filters(out, old, new)
    return out
