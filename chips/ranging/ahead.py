"""Neurons of a ranging chip that are integrated ahead, up to their next spike or for a while, as one goes on.

A step's length follows from the neuron alone: it is cut by its own inputs and by the end of what it is looked
ahead, which is `WATCHED` after where it was looked at. So how a run is cut into spans moves no bit of it, and
a neuron is integrated once, however short the spans are, unless an input comes before its look ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.ranging.law import Neurons
from chips.ranging.neuron_kernel import NEAR, NOW, RELEASE, UNDECIDED, advance, begin, copy_state
from circuits.arrays import F64, Bools
from circuits.compiled import compiled

WATCHED = 5e-3  # s, looked ahead of a neuron; ours

_compiled = compiled()


class Looked(NamedTuple):
    """Neurons, each as it was looked at last, and what lies ahead of it.

    base: after the last input, spike or look, float64[n, COLUMNS]; ahead: when it is due, likewise; due: of
    the next spike or the next look, s, float64[n]; fires: whether that is a spike, bool[n].
    """

    base: F64
    ahead: F64
    due: F64
    fires: Bools

    def copied(self) -> Looked:
        """Return neurons that may be written to."""
        return Looked(self.base.copy(), self.ahead.copy(), self.due.copy(), self.fires.copy())

    @property
    def undecided(self) -> int:
        """At how many moments a spike was too near to call, up to where each was looked at."""
        return int(self.base[:, UNDECIDED].sum() + self.base[:, NEAR].sum())


def resting(m: Neurons, columns: int, time: float) -> Looked:
    """Return neurons at rest at `time` s; columns: of a state."""
    n = m.t_inh.size
    made = Looked(np.zeros((n, columns)), np.zeros((n, columns)), np.zeros(n), np.zeros(n, np.bool_))
    for k in range(n):
        begin(m, k, made.base[k], time)
    look_all(m, made)
    return made


@_compiled
def _look(m: Neurons, w: Looked, k: int) -> None:
    """Integrate a neuron to its next spike, or as far as it is looked ahead: to its release at the most."""
    s = w.ahead[k]
    copy_state(w.base[k], s)
    until = s[NOW] + WATCHED
    if s[NOW] < s[RELEASE]:
        until = min(until, s[RELEASE])
    spike = advance(m, k, s, until)
    w.fires[k] = spike < np.inf
    w.due[k] = min(spike, until)


@_compiled
def look_all(m: Neurons, w: Looked) -> None:
    """Look at all neurons as they are."""
    for k in range(w.due.size):
        _look(m, w, k)


@_compiled
def go_on(m: Neurons, w: Looked, until: float, fired: Bools) -> float:
    """Go on to `until` (s) or to the first spike, and return the time reached; fired: who spikes then."""
    while True:
        first = np.inf
        for k in range(w.due.size):
            first = min(first, w.due[k])
        if first > until:
            return until
        found = False
        for k in range(w.due.size):
            if w.due[k] == first:
                fired[k] = w.fires[k]
                found = found or w.fires[k]
                copy_state(w.ahead[k], w.base[k])
                _look(m, w, k)
        if found:
            return float(first)


@_compiled
def bring(m: Neurons, w: Looked, time: float, fired: Bools) -> None:
    """Bring what all neurons are to `time` s, not beyond what is due; what lies ahead is not looked at.

    fired: who spikes then: whoever does by a step that ends there, and not by the longer one that was looked.
    """
    for k in range(w.due.size):
        while w.base[k, NOW] < time:
            if advance(m, k, w.base[k], time) < np.inf:
                fired[k] = True
