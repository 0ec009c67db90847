"""The kernel of a network's equations, which `system.mapping.dynamics` states: steps of all neurons."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled

_STILL, _FAR = 1e-9, 500.0  # drives, or y, that count as none; exponents that no number holds beyond
_compiled = compiled()


class CellArrays(NamedTuple):
    """Neurons, as of `Cells`, all arrays of one shape; slope is 0 where a neuron has no upstroke."""

    tau: F64
    refractory: F64
    constant: Bools
    slope: F64


class FilterArrays(NamedTuple):
    """Filters: what each falls to in a step, sign, power and pivot, float64[filters]; weights by source.

    mean : of its current over a step, over that at the step's begin, float64[filters].
    neurons : float64[filters, sources, n]; channels : float64[filters, channels, n]; unit : of the neurons'
    currents, float64[n].
    """

    fall: F64
    mean: F64
    sign: F64
    power: F64
    pivot: F64
    neurons: F64
    channels: F64
    unit: F64


class StateArrays(NamedTuple):
    """What goes on from step to step.

    v : float64[n]; wait : until a neuron listens, s, float64[n]; strength : of filters, float64[filters, n];
    fired : which neurons spiked in the last step; come : room for what comes to a filter, float64[n].
    """

    v: F64
    wait: F64
    strength: F64
    fired: Bools
    come: F64


class Sent(NamedTuple):
    """Spikes, or room for them: times, s, and neurons."""

    times: F64
    neurons: I64


@_compiled
def _rises(tau: float, slope: float, v: float, drive: float, free: float, step: float) -> tuple[float, float]:
    """Voltage of a neuron with an upstroke after a step, and the share of a step until it spikes."""
    pace = step / (slope * tau)
    over = _STILL if abs(drive - 1.0) < _STILL else drive - 1.0
    y = math.exp((1.0 - v) / slope)
    moved = (y + 1.0 / over) * math.exp(-min(max(over * pace * free, -_FAR), _FAR)) - 1.0 / over
    if moved > _STILL:  # y has not come to 0
        return max(1.0 - slope * math.log(moved), 0.0), math.inf
    left = 1.0 + over * y  # below 0 the spike never comes
    part = math.log(max(left, _STILL)) / (over * pace) if left > 0.0 else math.inf
    return 1.0 - slope * math.log(_STILL), part


@_compiled
def _leaks(tau: float, v: float, drive: float, free: float, step: float) -> float:
    """Voltage of a neuron whose membrane leaks after a step."""
    return drive + (v - drive) * math.exp(-free * step / tau)


@_compiled
def _move(
    cells: CellArrays, at: tuple[int, ...], v: F64, wait: F64, drive: float, step: float
) -> tuple[bool, float]:
    """Move a neuron by a step; whether it spiked, and when, in shares of the step."""
    free = min(max(1.0 - wait[at] / step, 0.0), 1.0)  # share of the step in which it listens
    if cells.slope[at] > 0.0:
        after, part = _rises(cells.tau[at], cells.slope[at], v[at], drive, free, step)
    else:
        straight = max(v[at] + (drive - 1.0) * free * step / cells.tau[at], 0.0)
        after = straight if cells.constant[at] else _leaks(cells.tau[at], v[at], drive, free, step)
        part = free * (1.0 - v[at]) / (after - v[at]) if after >= 1.0 else math.inf
    if free > 0.0 and part <= free:
        share = 1.0 - free + part
        v[at], wait[at] = 0.0, max(cells.refractory[at] - (1.0 - share) * step, 0.0)
        return True, share
    v[at], wait[at] = after, max(wait[at] - step, 0.0)
    return False, 1.0


@_compiled
def move_all(cells: CellArrays, v: F64, wait: F64, drive: F64, step: float, fired: Bools, share: F64) -> None:
    """Move neurons by a step of `step` s; fill which spiked, and when, in shares of the step."""
    for at in np.ndindex(v.shape):
        fired[at], share[at] = _move(cells, at, v, wait, float(drive[at]), step)


@_compiled
def _add(come: F64, weights: F64, k: int, source: int) -> None:
    """Add what a source brings to filter k of each neuron."""
    for n in range(come.size):
        come[n] += weights[k, source, n]


@_compiled
def _take(filters: FilterArrays, state: StateArrays, channels: I64, begin: int, end: int) -> None:
    """Let the filters fall, and take what neurons that fired and events of channels bring."""
    strength, come = state.strength, state.come
    for k in range(filters.fall.size):
        come[:] = 0.0
        for source in range(come.size):
            if state.fired[source]:
                _add(come, filters.neurons, k, source)
        for n in range(come.size):
            strength[k, n] = filters.fall[k] * strength[k, n] + come[n]
        come[:] = 0.0
        for event in range(begin, end):
            _add(come, filters.channels, k, channels[event])
        for n in range(come.size):
            strength[k, n] += come[n]


@_compiled
def _drive(filters: FilterArrays, state: StateArrays, n: int) -> float:
    """Mean drive of a neuron over a step, in units of its current."""
    total = 0.0
    for k in range(filters.fall.size):
        s, pivot = state.strength[k, n], filters.pivot[k]
        now = s if filters.power[k] == 1.0 else pivot * (s / pivot) ** filters.power[k]
        total += filters.sign[k] * filters.mean[k] * now
    return float(total / filters.unit[n])


@_compiled
def run_steps(
    cells: CellArrays, filters: FilterArrays, state: StateArrays, channels: I64, bounds: I64, first: int,
    step: float, found: Sent,
) -> int:  # fmt: skip
    """Take steps from number `first` on; fill the spikes in the order of steps, and return how many.

    channels : of all events; bounds : of those of each step, int64[steps + 1].
    """
    count = 0
    for k in range(bounds.size - 1):
        _take(filters, state, channels, bounds[k], bounds[k + 1])
        for n in range(state.v.size):
            spiked, share = _move(cells, (n,), state.v, state.wait, _drive(filters, state, n), step)
            state.fired[n] = spiked
            if spiked:
                found.times[count], found.neurons[count] = (first + k + share) * step, n
                count += 1
    return count
