"""The discrete spiking wavefront model of Hwu et al. (2018), equations (1) to (5), step for step.

    v_i(t+1) = u_i(t) + I_i(t)                                  (1)
    u_i(t+1) = min(u_i(t) + 1, 0)                               (2)
    I_i(t+1) = sum_j [d_ij(t) = 1]                              (3)
    d_ij(t+1) = max(d_ij(t) - 1, 0)                             (4)
    D_ij(t+1) = D_ij(t) + delta (map_xy - D_ij(t))              (5)

Order of updates: the right-hand sides of (1) to (4) are all read at t. Then every neuron with v_i(t+1) > 0
has spiked at step t + 1: v = 1, u = -5, and its delays are set to D, whatever was under way in them. So a
spike of j at step T has d = 1 at T + D - 1, I = 1 at T + D and v = 1 at T + D + 1: a hop takes D + 1 steps,
one more than the cost. A spike that is still under way when its neuron fires again is lost with its buffer.

map_xy is the value at the sending neuron (section II.B: "the neuron at that location would schedule its
spike"), so all D_ij of one j are equal, and so are all d_ij, which are set together: one D and one d a
neuron are kept. The countdown reaches 1 only from a whole number, so D is rounded when it is written. A
cost of 0 blocks: such a neuron never fires. Neighbours are the eight of section II.A; delays are 5 at
first; every run begins at rest, with one spike of the start at step 0, and ends with the step in which the
goal first fires.

Nothing keeps the wave from coming back: neurons fire again as soon as u lets them. Where a neuron of long
delay is made to fire again and again within that delay, its spike never leaves it, and what lies behind
stays silent; so a run has a limit of steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circuits.arrays import F64, I32, I64
from circuits.compiled import compiled
from circuits.errors import ParameterError

REFRACTORY = -5  # u after a spike
_V, _U, _I, _D, _NEXT = range(5)  # rows of the state
_ROOM = 8  # spikes a neuron for which there is room at first
_LONGEST = 2**20  # steps of a delay

Cell = tuple[int, int]  # row, column

_compiled = compiled()


@dataclass(frozen=True, slots=True)
class SpikeTable:
    """The AER table: neuron row * columns + column, and time step, of each spike in order, int64[m] each.

    shape: (rows, columns); last: the last step that was run.
    """

    neurons: I64
    steps: I64
    shape: tuple[int, int]
    last: int

    def first_spikes(self) -> F64:
        """Return the first step of each neuron's spikes, float64[rows, columns], inf where it never fired."""
        first = np.full(self.shape[0] * self.shape[1], np.inf)
        np.minimum.at(first, self.neurons, self.steps.astype(np.float64))
        return first.reshape(self.shape)

    def counts(self) -> I64:
        """Return how many spikes each neuron has, int64[rows, columns]."""
        return np.bincount(self.neurons, minlength=self.shape[0] * self.shape[1]).reshape(self.shape)


def learn(delays: F64, values: NDArray[np.integer] | F64, rate: float = 1.0) -> F64:
    """Apply equation (5) once: delays are moved towards the map's values by `rate`, 0 to 1.

    All arrays are [rows, columns]. Raises `ParameterError` for another rate.
    """
    if not 0.0 <= rate <= 1.0:
        raise ParameterError(f"learn.rate: {rate:g}, must be 0 to 1; 1 learns a value at once")
    return delays + rate * (np.asarray(values, dtype=np.float64) - delays)


def run_spikes(
    delays: NDArray[np.integer] | F64, start: Cell, goal: Cell | None = None, limit: int | None = None
) -> SpikeTable:
    """Run equations (1) to (4) from a spike of `start` at step 0, to the step in which `goal` fires.

    delays: D of the sending neuron, [rows, columns], written as by `round_delays`, 0 for blocked; limit:
    steps at most, by default what the longest path without return would take, D + 1 summed over all
    neurons. A run in which nothing is under way any more ends, too. From a blocked start nothing fires.
    Raises `ParameterError` for a delay below 0 or not finite, and for a start or goal off the grid.
    """
    whole = _written(delays)
    rows, columns = whole.shape
    stride = columns + 1
    padded = np.zeros((rows + 2) * stride + 1, dtype=np.int32)
    padded[stride:-1].reshape(rows + 1, stride)[:rows, 1:] = whole
    first = _place(start, "start", whole.shape)
    progress = np.array([0, 0, -1 if goal is None else _place(goal, "goal", whole.shape)])
    state, table = (
        np.zeros((5, padded.size), dtype=np.int32),
        np.empty((2, _ROOM * whole.size), dtype=np.int64),
    )
    limit = int((whole + 1).sum()) if limit is None else limit
    if padded[first] > 0:
        _fire(state, padded, first, columns, table, progress)
        while not _run(state, padded, columns, table, progress, limit):
            table = np.concatenate((table, np.empty_like(table)), axis=1)
    neurons, steps = table[:, : progress[0]]
    return SpikeTable(neurons.copy(), steps.copy(), (rows, columns), int(progress[1]))


def round_delays(delays: NDArray[np.integer] | F64) -> I64:
    """Delays as they are written, int64: the nearest whole number, halves up, at least 1; 0 stays blocked."""
    whole = np.maximum(np.floor(np.asarray(delays, dtype=np.float64) + 0.5), 1.0)
    return np.where(np.asarray(delays) > 0, whole, 0.0).astype(np.int64)


def _written(delays: NDArray[np.integer] | F64) -> I64:
    wrong = np.argwhere(~((delays >= 0) & (delays < _LONGEST)))
    if wrong.size:
        row, column = (int(k) for k in wrong[0])
        raise ParameterError(
            f"delays[{row}, {column}]: {delays[row, column]:g} steps, must be 0 to {_LONGEST}; scale the map"
        )
    return round_delays(delays)


def _place(cell: Cell, name: str, shape: tuple[int, ...]) -> int:
    """Number of a cell on the padded grid."""
    row, column = cell
    if not (0 <= row < shape[0] and 0 <= column < shape[1]):
        raise ParameterError(
            f"run.{name}: ({row}, {column}), must be on the grid of {shape[0]} x {shape[1]}; count from 0"
        )
    return (row + 1) * (shape[1] + 1) + column + 1


@_compiled
def _fire(state: I32, delays: I32, i: int, columns: int, table: I64, progress: I64) -> None:
    """A spike of neuron i of the padded grid: v = 1, u = -5, d = D, and a row of the table."""
    state[_V, i], state[_U, i], state[_D, i] = 1, REFRACTORY, delays[i]
    row, column = i // (columns + 1) - 1, i % (columns + 1) - 1
    table[0, progress[0]], table[1, progress[0]] = row * columns + column, progress[1]
    progress[0] += 1


@_compiled
def _run(state: I32, delays: I32, columns: int, table: I64, progress: I64, limit: int) -> bool:
    """Go on until the goal fires, nothing is under way or `limit`: True; or until the table is full: False.

    state: int32[5, padded] of v, u, I, d and I of the next step; progress: int64[3] of spikes so far, step
    and the goal's number on the padded grid, -1 for none.
    """
    u, received, d, arriving = state[_U], state[_I], state[_D], state[_NEXT]
    stride, goal = columns + 1, progress[2]
    under_way = True
    while under_way and progress[1] < limit and (goal < 0 or u[goal] != REFRACTORY):
        if progress[0] + delays.size > table.shape[1]:
            return False
        progress[1] += 1
        under_way = False
        arriving[:] = 0
        for j in range(d.size):
            if d[j] == 1:
                for step in (-stride, 1 - stride, 1, stride + 1, stride, stride - 1, -1, -stride - 1):
                    arriving[j + step] += 1
        for i in range(d.size):
            state[_V, i] = u[i] + received[i]
            u[i] = min(u[i] + 1, 0)
            received[i] = arriving[i]
            d[i] = max(d[i] - 1, 0)
            if state[_V, i] > 0 and delays[i] > 0:
                _fire(state, delays, i, columns, table, progress)
            under_way = under_way or d[i] > 0 or received[i] > 0
    return True
