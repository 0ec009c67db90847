"""The adjoint run: the transposed equations of a transient, from what is measured back to its beginning.

    (share_k0 C + G_k)^T m_k = dM/dv_k - C^T (share_(k+1)1 m_(k+1) + share_(k+2)2 m_(k+2))

with G_k the devices' conductances at step k, and at row 0 the transposed equations of the operating point. A
parameter p then moves the measure by

    dM/dp = - sum over k of m_k^T dR_k/dp

R as of `circuits.gradient.way`. One factorisation a step serves all measures. These are the derivatives
of the transient as it was computed, with steps that move with its edges (`circuits.gradient.section`).

Source: Director and Rohrer, "The generalized adjoint network and network sensitivities" (1969).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.gradient.section import OWN, Section, drive, lay, new_section, shift
from circuits.gradient.sums import (
    Ends,
    Heap,
    Sums,
    add_direct,
    add_heap,
    heap_up,
    heap_up_pairs,
    lay_moved,
    lay_rates,
    new_heap,
    through,
)
from circuits.gradient.way import Way
from circuits.lowering.factor import factor_and_solve
from circuits.lowering.kernel import Kernel
from circuits.solver.lanes.sheet import Sheet, fill, has_others, new_sheet, take
from circuits.solver.newton import Work, add_others, allocate, fill_jacobian, set_base
from circuits.solver.operating_point import solve_dense, write_dense
from circuits.vectors.vector import WIDTH, store

_NONE = np.zeros((0, 0))


class Tap(NamedTuple):
    """What a measure reads of a current.

    name : of the device or source.
    conducted : float64[rows], its slope by what flows without charge at each row, unit/A.
    rate : float64[rows], by the rate of the charge there, unit/A.
    stored : float64[rows], by the charge itself, unit/C.
    """

    name: str
    conducted: F64
    rate: F64
    stored: F64


class Adjoint(NamedTuple):
    """An adjoint run of some measures.

    voltage : float64[rows, columns], V, of the points that were gone through.
    moved : float64[measures, rows, unknowns], m at each of them.
    sums : what devices move the measures by.
    taps : number of a measure and what it reads of a current, whose devices are in `sums` too.
    timing : float64[measures, rows], by the times of rows that sources fix, in its unit a second.
    given : float64[measures, rows, sources], slopes by the sources' values that a measure has of its own.
    beside : float64[measures, sources], what of these is no current's, over all rows.
    """

    voltage: F64
    moved: F64
    sums: Sums
    taps: tuple[tuple[int, Tap], ...] = ()
    timing: F64 = _NONE
    given: F64 = _NONE
    beside: F64 = _NONE


class _Rows(NamedTuple):
    """Working memory of what devices do at rows; every: int64[transistors], all of them."""

    work: Work
    sheet: Sheet
    every: I64


class _Room(NamedTuple):
    """Working memory of one run; matrix: float64[unknowns, unknowns]."""

    rows: _Rows
    matrix: F64
    section: Section


def _new_rows(k: Kernel) -> _Rows:
    return _Rows(allocate(k), new_sheet(k), np.arange(k.transistors.sign.size))


def backwards(
    k: Kernel, way: Way, slopes: F64, timing: F64, held: Bools, ends: Ends, sums: Sums
) -> Adjoint | None:
    """Solve the adjoint run, and sum up what devices move each measure by.

    Parameters
    ----------
    k
        The kernel.
    way
        The transient.
    slopes
        float64[measures, rows, unknowns], of each measure by the voltages; becomes m.
    timing
        float64[measures, rows], of each measure by the times of the rows, in its unit a second; becomes, for
        those that sources fix, that of the whole run.
    held
        bool[unknowns], which of them are held at the beginning, and so have no equation there.
    ends
        Of resistors, and of what has a capacitance.
    sums
        To what the run's are added.

    Returns
    -------
    Adjoint or None
        m and the sums; None where the equations are singular.
    """
    moved, n = slopes, k.unknowns
    room, heap = (
        _Room(_new_rows(k), np.zeros((n, n)), new_section(k)),
        new_heap(k, len(slopes), (ends[0].shape[1], ends[1].shape[1])),
    )
    if not _backwards(k, way, (moved, timing), held, ends, room, heap):
        return None
    if not np.isfinite(moved).all():
        return None
    add_heap(heap, sums)
    return Adjoint(way.voltage, moved, sums, timing=timing)


def contracted(k: Kernel, voltage: F64, moved: F64) -> F64:
    """Return `- sum m R` of each measure with the direct currents of a kernel, float64[measures].

    k: a kernel of the same pattern; voltage: float64[rows, columns], V, with its own sources' values.
    """
    heap = new_heap(k, moved.shape[0])
    _contract(k, voltage, moved, _new_rows(k), heap)
    return heap.direct


def add_rows(k: Kernel, voltage: F64, moved: F64, sums: Sums) -> None:
    """Add what the transistors do at rows, float64[rows, columns], V, to the sums of measures."""
    heap = new_heap(k, moved.shape[0])
    _add_rows(k, voltage, moved, _new_rows(k), heap)
    add_heap(heap, sums)


@compiled(forceinline=True)
def apart(moved: F64, a: int, b: int) -> float:
    """Difference of m between two columns; it is 0 at those that sources fix."""
    return (moved[a] if a < moved.size else 0.0) - (moved[b] if b < moved.size else 0.0)


@compiled()
def _solve_transposed(k: Kernel, a: F64, b: F64) -> None:
    """Solve with the transpose of a matrix whose entries `a` are factored; b, float64[n], in place."""
    f = k.factor
    for i in range(b.size):
        own = b[i] * a[f.diagonal[i]]
        b[i] = own
        for p in range(f.upper_start[i], f.upper_start[i + 1]):
            b[f.upper_column[p]] -= a[f.upper[p]] * own
    for i in range(b.size - 1, -1, -1):
        total = b[i]
        for p in range(f.lower_start[i], f.lower_start[i + 1]):
            total -= a[f.lower[p]] * b[f.lower_row[p]]
        b[i] = total


@compiled()
def _owe(k: Kernel, share: F64, row: int, moved: F64) -> None:
    """Take from the right side at a row what the next two have of its charge; moved: of a measure."""
    last = share.shape[0] - 1
    one = share[row + 1, 1] if row < last else 0.0
    two = share[row + 2, 2] if row < last - 1 else 0.0
    for i in range(k.unknowns):
        owed = one * moved[row + 1, i] if row < last else 0.0
        if row < last - 1:
            owed += two * moved[row + 2, i]
        if owed != 0.0:
            for p in range(k.charge.start[i], k.charge.start[i + 1]):
                if k.charge.column[p] < k.unknowns:
                    moved[row, k.charge.column[p]] -= k.charge.value[p] * owed


@compiled()
def _backwards(
    k: Kernel, way: Way, solved: tuple[F64, F64], held: Bools, ends: Ends, room: _Room, heap: Heap
) -> bool:
    """Go backwards; solved: of each measure by the voltages and by the times, to become as of `backwards`."""
    (moved, owed), own, last = solved, room.rows, way.voltage.shape[0] - 1
    for first in range(last // WIDTH * WIDTH, -1, -WIDTH):
        fill(k, own.every, way.voltage, first, own.sheet)
        for row in range(min(first + WIDTH - 1, last), first - 1, -1):
            take(k, own.sheet, row - first, way.voltage[row], own.work)
            if row > 0:
                _step(k, way, row, moved, owed, room)
            elif not _begin(k, way, moved, held, room):
                return False
            for m in range(moved.shape[0] if has_others(k) else 0):
                add_direct(k, moved[m, row], own.work, m, heap.direct)
        lay_rates(way, first, heap)
        for m in range(moved.shape[0]):
            heap_up(k, moved[m], first, own.sheet, m, heap)
            heap_up_pairs(ends, own.sheet, m, heap)
    return True


@compiled()
def _step(k: Kernel, way: Way, row: int, moved: F64, owed: F64, room: _Room) -> None:
    """Solve the equations of a step; the working memory is as evaluated there."""
    w, section = room.rows.work, room.section
    set_base(k, way.share[row, 0], w)
    fill_jacobian(k, w)
    drive(k, way, row, section, w)
    unused = w.rate[: k.unknowns]
    unused[:] = 0.0
    factor_and_solve(k.factor, w.jacobian, unused)
    own = lay(k, way, row, section)
    through = _across(k, section, w) if own else 0.0
    for m in range(moved.shape[0]):
        _owe(k, way.share, row, moved[m])
        _solve_transposed(k, w.jacobian, moved[m, row])
        shift(own and abs(through) > OWN, through, row, way, moved[m, row], owed[m], section)


@compiled()
def _begin(k: Kernel, way: Way, moved: F64, held: Bools, room: _Room) -> bool:
    """Solve the equations of the beginning; the working memory is as evaluated there."""
    set_base(k, 0.0, room.rows.work)
    fill_jacobian(k, room.rows.work)
    for m in range(moved.shape[0]):
        _owe(k, way.share, 0, moved[m])
        _write_transposed(k, held, room.rows.work, room.matrix)
        for i in range(k.unknowns):
            moved[m, 0, i] = 0.0 if held[i] else moved[m, 0, i]
        if not solve_dense(room.matrix, moved[m, 0]):
            return False
    return True


@compiled()
def _across(k: Kernel, section: Section, w: Work) -> float:
    """Solve the section at a step; returns what that makes of the step's time."""
    through = 0.0
    for i in range(k.unknowns):
        section.solved[i] = section.across[i]
    _solve_transposed(k, w.jacobian, section.solved)
    for i in range(k.unknowns):
        through += section.solved[i] * section.moves[0, i]
    return through


@compiled()
def _write_transposed(k: Kernel, held: Bools, w: Work, matrix: F64) -> None:
    """Write the transposed Jacobian, where what is held has no equation."""
    write_dense(k, w, matrix)
    for i in range(k.unknowns):
        for j in range(i):
            matrix[i, j], matrix[j, i] = matrix[j, i], matrix[i, j]
    for i in range(k.unknowns):
        if held[i]:
            for j in range(k.unknowns):
                matrix[i, j] = matrix[j, i] = 0.0
            matrix[i, i] = 1.0


@compiled()
def _contract(k: Kernel, voltage: F64, moved: F64, room: _Rows, heap: Heap) -> None:
    """Add what the direct currents at rows do to measures, to the heap's `direct`."""
    for first in range(0, voltage.shape[0], WIDTH):
        fill(k, room.every, voltage, first, room.sheet)
        for m in range(moved.shape[0]):
            lay_moved(moved[m], first, heap)
            store(heap.rate, 0, through(k, room.sheet, heap))
            for lane in range(WIDTH):
                heap.direct[m] -= heap.rate[0, lane]
        for row in range(first, min(first + WIDTH, voltage.shape[0]) if has_others(k) else first):
            add_others(k, voltage[row], room.work)
            for m in range(moved.shape[0]):
                add_direct(k, moved[m, row], room.work, m, heap.direct)


@compiled()
def _add_rows(k: Kernel, voltage: F64, moved: F64, room: _Rows, heap: Heap) -> None:
    """Add what devices do at rows to the heap, but for the currents of transistors, which are there."""
    for first in range(0, voltage.shape[0], WIDTH):
        fill(k, room.every, voltage, first, room.sheet)
        for m in range(moved.shape[0]):
            heap_up(k, moved[m], first, room.sheet, m, heap)
        for row in range(first, min(first + WIDTH, voltage.shape[0]) if has_others(k) else first):
            add_others(k, voltage[row], room.work)
            for m in range(moved.shape[0]):
                add_direct(k, moved[m, row], room.work, m, heap.direct)
