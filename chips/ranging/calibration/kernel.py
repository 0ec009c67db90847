"""Compiled trials of the bench: a call, an echo, or both, again and again, and what every neuron answers."""

from __future__ import annotations

import numpy as np

from chips.ranging.kernel import Chip, Plan, next_due, on_call, on_echo, take
from chips.ranging.law import Neurons
from circuits.arrays import F64, I64
from circuits.compiled import compiled

CALL, ECHO, BOTH = 1, 2, 3  # what a trial sends

_compiled = compiled()


@_compiled
def trials(
    m: Neurons, p: Plan, c: Chip, begin: float, period: float, sent: int, delays: F64, counts: I64
) -> None:
    """Count the spikes of each neuron in trials that follow each other.

    begin: of the first one, s; period: from one to the next, s; sent: `CALL`, `ECHO` or `BOTH`; delays: of
    the echo, s, float64[trials]; counts: is added to, int64[1 + trials, n], the first row before any trial.
    """
    _count(m, p, c, begin, counts[0])
    for i in range(delays.size):
        now = begin + i * period
        if sent & CALL:
            on_call(m, p, c, now)
        if sent & ECHO:
            _count(m, p, c, now + delays[i], counts[i + 1])
            on_echo(m, p, c, now + delays[i], np.nan)
        _count(m, p, c, now + period, counts[i + 1])


@_compiled
def _count(m: Neurons, p: Plan, c: Chip, until: float, counts: I64) -> None:
    """Take all spikes before `until` s."""
    while True:
        due, k = next_due(c)
        if due >= until:
            return
        if take(m, p, c, k):
            counts[k] += 1
