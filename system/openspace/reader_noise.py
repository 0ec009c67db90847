"""Readings of a ranging chip whose neurons jitter from call to call.

Inhibition of neuron k lasts t_inh + delta_k after a call (`chips.ranging.noise`). An echo meets it as one
that comes delta_k sooner meets a neuron without noise, whose state at the release does not depend on when
that was; so with L_k(d) how long after an echo of the delay d the neuron spikes,

    reading(d) = value of the k with the least L_k(d - delta_k), where that is at most `WINDOW`.

L_k is a table of this die (`STEP`, straight between its entries; next to one without a spike the nearest one
counts). Where all delta are as good as 0, so that the neuron is the same, it reads as
`system.openspace.reader` does, by the nearest entry. Each ping is a call, flicker goes on from ping to
ping, and a run begins in its stationary state.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.noise import SiliconNoise
from chips.ranging.chip import shipped_model
from chips.ranging.noise import Jitter, new_jitter, next_durations, no_jitter
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind
from circuits.compiled import compiled
from circuits.silicon.silicon import Silicon
from system.openspace.reader import STEP, WINDOW, Calibration, late_spikes, neurons_of, values_of

_compiled = compiled()


class Reader(NamedTuple):
    """What reads a chip with noise; without neurons there is none.

    late: float64[neurons, delays], s, L_k, inf for none; value: float64[neurons], s; jitter, t_inh (float64
    [neurons], s, after the last call) are overwritten by every ping, so that a reader is one run's at a time.
    """

    late: F64
    value: F64
    jitter: Jitter
    t_inh: F64


def no_reader() -> Reader:
    """Return what stands for a reader where the chip makes no noise."""
    return Reader(np.zeros((0, 0)), np.zeros(0), no_jitter(), np.zeros(0))


def reader_of(
    silicon: Silicon, calibration: Calibration, noise: SiliconNoise | None, area: float = 1.0,
    bias_kind: BiasKind = "generator", begun_c: float | None = None,
) -> Reader:  # fmt: skip
    """A reader before its first ping, of none for None; raises as `system.openspace.reader.readings` does.

    begun_c: temperature (degC) of the run's beginning where it moves, by whose inhibition relaxations are
    told apart.
    """
    if noise is None:
        return no_reader()
    value = values_of(silicon, calibration, area, bias_kind)
    neurons = neurons_of(silicon, area, bias_kind)
    model = shipped_model(silicon.process, bias_kind)
    first = neurons
    if begun_c is not None:
        first = neurons_of(replace(silicon, temperature_c=begun_c), area, bias_kind)
    jitter = new_jitter(model, neurons, silicon.of_area(area), noise, float(first.t_inh.min()), area=area)
    late = _late(silicon, area, bias_kind).copy()
    return Reader(late, value, jitter, neurons.t_inh.copy())


@lru_cache(maxsize=64)
def _late(silicon: Silicon, area: float, bias_kind: BiasKind) -> F64:
    found, _ = late_spikes(neurons_of(silicon, area, bias_kind))
    found.setflags(write=False)
    return found


@_compiled
def next_ping(r: Reader, time: float) -> None:
    """A call at `time` s, not before the last one of the run: inhibition is drawn anew."""
    next_durations(r.jitter, time, r.t_inh)


@_compiled
def read(r: Reader, delay: float) -> float:
    """Reading (s) of an echo's delay (s) after the last call, NaN for none."""
    which = _first(r, delay / STEP, 1.0)
    if which == _first(r, delay / STEP, 0.0):
        which = _first(r, math.floor(delay / STEP + 0.5), 0.0)
    return r.value[which] if which >= 0 else math.nan


def answers(r: Reader, delay: float) -> tuple[F64, I64]:
    """Return when neurons answer an echo of a delay (s) after the last call, s after it, and which do."""
    at = delay / STEP - (r.t_inh - r.jitter.t_inh) / STEP
    late = np.array([_late_at(table, place) for table, place in zip(r.late, at.tolist(), strict=True)])
    which = np.flatnonzero(late <= WINDOW)
    return delay + late[which], which


@_compiled
def _first(r: Reader, at: float, jitter: float) -> int:
    """Neuron that spikes first at a place in the tables, -1 for none; jitter: 1 for the drawn, 0 without."""
    least, which = WINDOW, -1
    for k in range(r.value.size):
        late = _late_at(r.late[k], at - jitter * (r.t_inh[k] - r.jitter.t_inh[k]) / STEP)
        if late < least or (late == least and which < 0):
            least, which = late, k
    return which


@_compiled
def _late_at(table: F64, at: float) -> float:
    """Entry of a table at a place between its entries."""
    at = min(max(at, 0.0), table.size - 1.0)
    k = min(int(at), table.size - 2)
    share = at - k
    near: float = table[k + 1] if share >= 0.5 else table[k]
    if table[k] < np.inf and table[k + 1] < np.inf:
        near = (1.0 - share) * table[k] + share * table[k + 1]
    return near
