"""The way of a transient as the adjoint run needs it: each accepted step, and its differences.

With the rate at a step k, `share_k0 v_k + share_k1 v_(k-1) + share_k2 v_(k-2)`, the transient has solved

    R_k = C (share_k0 v_k + share_k1 v_(k-1) + share_k2 v_(k-2)) + G v_k + i(v_k) = 0

which is backward Euler in the first step after a bend of a stimulus, and BDF2 else (`solver.integrate`).
Row 0 is the state in which the run begins, with no rate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.lowering.kernel import Machine, Sources
from circuits.solver.integrate import source_values
from circuits.solver.newton import with_charges
from circuits.solver.transient import Result

SAME_TIME = 1e-13  # s, as the integrator's


class Way(NamedTuple):
    """A transient, a row a step.

    time : float64[rows], s.
    voltage : float64[rows, columns], V.
    share : float64[rows, 3], 1/s.
    order : int64[rows], how many rows before it the parabola through a row's step takes, 1 or 2.
    drive : float64[rows, sources], how fast each source moves after a row, V/s or A/s.
    fastest : float64[rows], rate of the source that moves fastest there.
    free : bool[rows], whether no source bends at a row, and it is neither the first nor the last.
    """

    time: F64
    voltage: F64
    share: F64
    order: I64
    drive: F64
    fastest: F64
    free: Bools


def way_of(result: Result) -> Way:
    """Return the way of a run that recorded all nodes."""
    machine = result.machine
    kept = np.concatenate([[True], np.diff(result.time) > 0.0])
    time = result.time[kept]
    voltage = np.zeros((time.size, machine.kernel.columns))
    columns = np.array([machine.column_of(n) for n in result.nodes], np.int64)
    _spread(result.voltage, kept, columns, voltage)
    sources = machine.sources()
    cursor = sources.start[:-1].copy()
    _drive(sources, cursor, time, voltage, machine.kernel.unknowns)
    voltage = with_charges(machine.kernel, voltage)
    order = _orders(machine, time)
    return Way(time, voltage, _shares(time, order), order, *_moving(machine, time, order))


@compiled()
def _spread(recorded: F64, kept: Bools, columns: I64, voltage: F64) -> None:
    """Copy the rows that are kept, each node into its column."""
    at = 0
    for row in range(kept.size):
        if kept[row]:
            for node in range(columns.size):
                voltage[at, columns[node]] = recorded[row, node]
            at += 1


@compiled()
def _drive(s: Sources, cursor: I64, time: F64, voltage: F64, unknowns: int) -> None:
    """Fill in what the sources have at each row."""
    for row in range(time.size):
        source_values(s, cursor, time[row], voltage[row], unknowns)


def _orders(machine: Machine, time: F64) -> I64:
    """0 for the beginning, 1 for the first step and for each after a bend of a stimulus, 2 for the others."""
    bends = [t for (t, _), sampled in zip(machine.polylines, machine.sampled, strict=True) if not sampled]
    every = np.unique(np.concatenate([np.zeros(1), *bends]))
    at_bend = np.abs(every[nearest(every, time)] - time) <= SAME_TIME
    order = np.full(time.size, 2, dtype=np.int64)
    order[1:][at_bend[:-1]] = 1
    order[:2] = [0, 1][: time.size]
    return order


def nearest(times: F64, time: F64) -> I64:
    """Return which of some rising times is nearest to each of others, int64[time]; all in s."""
    after = np.minimum(np.searchsorted(times, time), times.size - 1)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(times[after] - time) < np.abs(times[before] - time), after, before)


def _moving(machine: Machine, time: F64, order: I64) -> tuple[F64, F64, Bools]:
    """How fast sources move at each row, and which rows are at no bend of one."""
    drive, free = np.zeros((time.size, len(machine.polylines))), np.zeros(time.size, np.bool_)
    free[1:-1] = order[2:] != 1
    for source, (at, value) in enumerate(machine.polylines):
        if at.size > 1:
            slope = np.concatenate([[0.0], np.diff(value) / np.diff(at), [0.0]])
            before, after = (slope[np.searchsorted(at, time + apart)] for apart in (-SAME_TIME, SAME_TIME))
            drive[:, source] = after
            free &= before == after
    return drive, np.abs(drive).max(axis=1, initial=0.0), free


def _shares(time: F64, order: I64) -> F64:
    share = np.zeros((time.size, 3))
    h = np.diff(time)
    first = np.flatnonzero(order == 1)
    share[first, 0], share[first, 1] = 1.0 / h[first - 1], -1.0 / h[first - 1]
    later = np.flatnonzero(order == 2)
    step = h[later - 1]
    w = step / h[later - 2]
    share[later, 0] = (1.0 + 2.0 * w) / ((1.0 + w) * step)
    share[later, 1] = -(1.0 + w) / step
    share[later, 2] = w * w / ((1.0 + w) * step)
    return share
