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
from circuits.gradient.ends import Ends
from circuits.gradient.section import OWN, Section, drive, lay, new_section, shift
from circuits.gradient.way import Way
from circuits.lowering.factor import factor_and_solve
from circuits.lowering.kernel import Kernel
from circuits.solver.newton import Work, allocate, evaluate, fill_jacobian, set_base
from circuits.solver.operating_point import solve_dense, write_dense

_NONE = np.zeros((0, 0))


class Sums(NamedTuple):
    """Sums over the steps of a measure, each `- sum m dR`, by device.

    by_drain, by_gate, by_source : float64[measures, transistors], by the voltages at the channel, unit/V.
    current : float64[measures, transistors], by ln of the channel's current, unit.
    early : float64[measures, transistors], by ln of what the Early effect divides by the length, unit.
    junction : float64[measures, transistors], by ln of the junctions' leakage, unit.
    junction_own : float64[measures, 2, transistors], by drain and source at their junctions, unit/V.
    junction_gate : float64[measures, 2, transistors], by the gate at those junctions, unit/V.
    charge : float64[measures, pairs], by a capacitance between two columns, unit/F.
    conductance : float64[measures, pairs], by a conductance between two columns, unit/S.
    direct : float64[measures], `- sum m (G v + i)`, in the measure's unit.
    """

    by_drain: F64
    by_gate: F64
    by_source: F64
    current: F64
    early: F64
    junction: F64
    junction_own: F64
    junction_gate: F64
    charge: F64
    conductance: F64
    direct: F64


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
    """

    voltage: F64
    moved: F64
    sums: Sums
    taps: tuple[tuple[int, Tap], ...] = ()
    timing: F64 = _NONE
    given: F64 = _NONE


class _Room(NamedTuple):
    """Working memory of one run; matrix: float64[unknowns, unknowns]."""

    work: Work
    matrix: F64
    section: Section


def no_sums(k: Kernel, measures: int, ends: Ends) -> Sums:
    """Return the sums of some measures over no step; ends: of resistors, and of what has a capacitance."""
    m, t = measures, k.transistors.sign.size
    a, b, c, d, e, f = (np.zeros((m, t)) for _ in range(6))
    own, gate = np.zeros((m, 2, t)), np.zeros((m, 2, t))
    conductance, charge = (np.zeros((m, pairs.shape[1])) for pairs in ends)
    return Sums(a, b, c, d, e, f, own, gate, charge, conductance, np.zeros(m))


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
    room = _Room(allocate(k), np.zeros((n, n)), new_section(k))
    if not _backwards(k, way, moved, timing, held, room, sums):
        return None
    if not np.isfinite(moved).all():
        return None
    _pairs(way.voltage, way.share, moved, ends[1], ends[0], np.zeros(k.columns), sums)
    return Adjoint(way.voltage, moved, sums, timing=timing)


def contracted(k: Kernel, voltage: F64, moved: F64) -> F64:
    """Return `- sum m R` of each measure with the direct currents of a kernel, float64[measures].

    k: a kernel of the same pattern; voltage: float64[rows, columns], V, with its own sources' values.
    """
    found = np.zeros(moved.shape[0])
    _contract(k, voltage, moved, allocate(k), found)
    return found


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
def _backwards(k: Kernel, way: Way, moved: F64, owed: F64, held: Bools, room: _Room, s: Sums) -> bool:
    w, section, voltage, share = room.work, room.section, way.voltage, way.share
    unused = w.rate[: k.unknowns]
    for row in range(voltage.shape[0] - 1, 0, -1):
        drive(k, way, row, section, w)
        set_base(k, share[row, 0], w)
        evaluate(k, voltage[row], w)
        fill_jacobian(k, w)
        unused[:] = 0.0
        factor_and_solve(k.factor, w.jacobian, unused)
        own = lay(k, way, row, section)
        through = _across(k, section, w) if own else 0.0
        for m in range(moved.shape[0]):
            _owe(k, share, row, moved[m])
            _solve_transposed(k, w.jacobian, moved[m, row])
            shift(own and abs(through) > OWN, through, row, way, moved[m, row], owed[m], section)
            _sum_up(k, voltage[row], moved[m, row], w, m, s)
    set_base(k, 0.0, w)
    evaluate(k, voltage[0], w)
    fill_jacobian(k, w)
    for m in range(moved.shape[0]):
        _owe(k, share, 0, moved[m])
        _write_transposed(k, held, w, room.matrix)
        for i in range(k.unknowns):
            moved[m, 0, i] = 0.0 if held[i] else moved[m, 0, i]
        if not solve_dense(room.matrix, moved[m, 0]):
            return False
        _sum_up(k, voltage[0], moved[m, 0], w, m, s)
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
def _pairs(voltage: F64, share: F64, moved: F64, capacitors: I64, resistors: I64, rate: F64, s: Sums) -> None:
    """Sum over the rows of the difference of m across each pair, times that of the rate or of the voltage."""
    for row in range(voltage.shape[0]):
        for c in range(voltage.shape[1]):
            rate[c] = share[row, 0] * voltage[row, c]
            if row > 0:
                rate[c] += share[row, 1] * voltage[row - 1, c]
            if row > 1:
                rate[c] += share[row, 2] * voltage[row - 2, c]
        for m in range(moved.shape[0]):
            for q in range(capacitors.shape[1]):
                a, b = capacitors[0, q], capacitors[1, q]
                s.charge[m, q] -= apart(moved[m, row], a, b) * (rate[a] - rate[b])
            for q in range(resistors.shape[1]):
                a, b = resistors[0, q], resistors[1, q]
                s.conductance[m, q] -= apart(moved[m, row], a, b) * (voltage[row, a] - voltage[row, b])


@compiled()
def _sum_up(k: Kernel, v: F64, own: F64, w: Work, m: int, s: Sums) -> None:
    """Add what the transistors do at a row to the sums of a measure; w: as evaluated there; own: its m."""
    terminal = k.transistors.terminal
    for i in range(k.unknowns):
        s.direct[m] -= own[i] * w.residual[i]
    for i in range(k.transistors.sign.size):
        channel = apart(own, terminal[0, i], terminal[2, i])
        if channel != 0.0:
            add_channel(k, v, w, i, channel, m, s)
        if k.transistors.leaks:
            for side in range(2):
                across = apart(own, terminal[2 * side, i], terminal[3, i])
                add_junction(w, i, side, across, m, s)


@compiled(forceinline=True)
def add_channel(k: Kernel, v: F64, w: Work, i: int, channel: float, m: int, s: Sums) -> None:
    """Add what the channel of transistor i does to the sums of measure m; channel: m across it."""
    t, x = k.transistors, w.transistor
    s.by_drain[m, i] -= channel * x.conductance[0, i]
    s.by_gate[m, i] -= channel * x.conductance[1, i]
    s.by_source[m, i] -= channel * x.conductance[2, i]
    s.current[m, i] -= channel * x.current[i]
    # E is 1 + rest; ln of the Early voltage moves the rest alone
    rest = t.early[i] * abs(v[t.terminal[0, i]] - v[t.terminal[2, i]])
    if t.reduces:
        rest /= 1.0 + t.early_rise[i] * (x.value[i] + x.value[t.sign.size + i])
    s.early[m, i] -= channel * x.current[i] * rest / (1.0 + rest)


@compiled(forceinline=True)
def add_junction(w: Work, i: int, side: int, across: float, m: int, s: Sums) -> None:
    """Add what the junction at drain, 0, or source, 1, of transistor i does; across: m across it."""
    x = w.transistor
    s.junction[m, i] -= across * x.junction[side, i]
    s.junction_own[m, side, i] -= across * x.junction_conductance[side, i]
    s.junction_gate[m, side, i] -= across * x.junction_conductance[2 + side, i]


@compiled()
def _contract(k: Kernel, voltage: F64, moved: F64, w: Work, out: F64) -> None:
    for row in range(voltage.shape[0]):
        evaluate(k, voltage[row], w)
        for m in range(moved.shape[0]):
            total = 0.0
            for i in range(k.unknowns):
                total += moved[m, row, i] * w.residual[i]
            out[m] -= total


@compiled()
def add_rows(k: Kernel, voltage: F64, moved: F64, w: Work, s: Sums) -> None:
    """Add what the transistors do at rows, float64[rows, columns], V, to the sums of measures."""
    for row in range(voltage.shape[0]):
        evaluate(k, voltage[row], w)
        for m in range(moved.shape[0]):
            _sum_up(k, voltage[row], moved[m, row], w, m, s)
