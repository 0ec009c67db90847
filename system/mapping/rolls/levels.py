"""Weights on the few that ROLLS has: four levels a sign, and events of one virtual synapse, repeated.

    levels 1 to 4:  c,  c + a,  c + b,  c + a + b        a, b, c above 0
    virtual:        u, 2 u, 3 u, ...                     up to `MOST` events

Both are chosen so that the squares of what is missing are least, over all synapses; 0 is one of the choices.
One to three weights of a sign, or multiples of one, are met.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.catalogue import later

optimise = later("scipy.optimize")

MOST = 32  # events for one; ours
CLOSE = 0.02  # of a weight, rms, at which no more events are tried for; ours
_SUMS = np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]])
_LEAST = 1e-3  # of c, that a and b are at least: a bias that is off has no levels; ours
_ROUNDS = 20  # of each start


class Levels(NamedTuple):
    """Charges of levels 1 to 4, and the level of each weight, 0 for none, int64 of the weights' shape."""

    charges: F64
    chosen: I64


class Repeats(NamedTuple):
    """Charge of one event, and how many stand for each weight, int64 of the weights' shape."""

    charge: float
    chosen: I64


def levels_of(weights: F64) -> Levels:
    """Return levels for weights of one sign, 0 or above, of any shape."""
    values, counts = np.unique(weights[weights > 0.0], return_counts=True)
    if values.size <= _SUMS.shape[1]:
        steps = np.concatenate((values[:1], values[1:] - values[:1]))
        steps = np.concatenate((steps, np.full(_SUMS.shape[1] - steps.size, steps[-1])))
        charges = _SUMS @ steps
    else:
        charges = min((_improved(start, values, counts) for start in _starts(values)), key=lambda x: x[0])[1]
    return Levels(charges, _nearest(weights, charges))


def repeats_of(weights: F64) -> Repeats:
    """Return the charge of an event, and their numbers, for weights of one sign, 0 or above."""
    values, counts = np.unique(weights[weights > 0.0], return_counts=True)
    best, least = float(values[-1]), np.inf
    for most in range(1, MOST + 1):
        unit = float(values[-1]) / most
        off = values - unit * np.rint(values / unit)
        error = float(np.sqrt((counts * off**2).sum() / (counts * values**2).sum()))
        if error < least:
            best, least = unit, error
        if least <= CLOSE:
            break
    return Repeats(best, np.rint(weights / best).astype(np.int64))


def _nearest(weights: F64, charges: F64) -> I64:
    choices = np.concatenate(([0.0], charges))
    return np.asarray(np.abs(weights[..., None] - choices).argmin(axis=-1))


def _starts(values: F64) -> Iterator[F64]:
    """Steps c, a, b to begin with: from several places of the weights' range."""
    for low in (0.05, 0.2, 0.4):
        for middle in (0.4, 0.6, 0.8):
            first, second, last = np.quantile(values, [low, middle, 1.0])
            yield np.array([first, max(second - first, 1e-3 * first), max(last - second, 1e-3 * first)])


def _improved(steps: F64, values: F64, counts: I64) -> tuple[float, F64]:
    """Squares that are left, and the charges, after weights are given to levels and levels moved in turn."""
    root, charges = np.sqrt(counts), _SUMS @ steps
    for _ in range(_ROUNDS):
        chosen = _nearest(values, charges)
        used = chosen > 0
        rows = root[used, None] * _SUMS[chosen[used] - 1]
        moved, _ = optimise.nnls(rows, root[used] * values[used])
        moved[1:] = np.maximum(moved[1:], _LEAST * max(moved[0], values[0]))
        charges = _SUMS @ np.maximum(moved, _LEAST * values[0])
    given = np.concatenate(([0.0], charges))[_nearest(values, charges)]
    return float((counts * (values - given) ** 2).sum()), charges
