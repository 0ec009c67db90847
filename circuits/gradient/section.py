"""Steps of an adjoint run that move with the state, so that an edge is told in its own time.

A deviation moves an edge. With the times of the steps as they were, what it moves the voltages by within the
edge is its rate times the shift, orders of magnitude more than what outlasts it, and small errors of the one
are large ones of the other: of what moves the fourth spike of a neuron 22 % were lost. So the time t_k of a
step moves too, by as much as keeps what is left across the way that the voltages take,

    r . dv_k = 0,        r = the rates dv/dt at step k of the nodes with capacitance

and the run is differentiated by its voltages and by these times. With m as of
`circuits.gradient.backwards` and J the matrix of step k, that condition adds a number u a step,

    J^T m_k = l_k - u r,     u so that     m_k^T dR_k/dt_k = g_k

l_k and g_k: what the measure and later steps have by v_k and t_k. The rate at step k is that of the parabola
p_k through its points, which a knot that moves by dt_j bends by `-p_k'(t_j) dt_j` there, so that

    dR_k/dt_j = C (d_jk p_k'' - share_kj p_k'(t_j)) + what the sources' movement adds

As the sum of these over a step's points is 0 where sources stand still, so `m^T C dv/dt`, which a circuit
without a clock conserves, is conserved by these equations too, whatever the tolerance.

A step in which nothing moves by `SEEN`, or whose state follows from its currents alone rather than from the
step before, shifts as the one before it. At the bends of sources times are those of the sources, and where
sources move too, unless nodes are faster than these: what a source makes comes when the source does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.gradient.way import Way
from circuits.lowering.kernel import Kernel
from circuits.solver.newton import Work

SEEN = 1e-4  # V in a step, from which on rates are more than errors of the step; ours
OWN = 0.1  # share of a state that is kept from the step before, from which on its own time is known; ours


class Section(NamedTuple):
    """Working memory of one run.

    across : float64[unknowns], r / r^2.
    solved : float64[unknowns], what J^T makes of it.
    moves : float64[3, unknowns], residual at a step by the times of its points, newest first.
    driven : float64[unknowns], A/s, what sources add to that by the currents.
    rate : float64[columns], V/s, of the line from the row before.
    bend : float64[columns], V/s^2, of the step's parabola.
    probe : float64[columns], V/s, of the sources.
    """

    across: F64
    solved: F64
    moves: F64
    driven: F64
    rate: F64
    bend: F64
    probe: F64


def new_section(k: Kernel) -> Section:
    """Working memory for a kernel."""
    across, solved, driven = (np.zeros(k.unknowns) for _ in range(3))
    rate, bend, probe = (np.zeros(k.columns) for _ in range(3))
    return Section(across, solved, np.zeros((3, k.unknowns)), driven, rate, bend, probe)


@compiled()
def drive(k: Kernel, way: Way, row: int, s: Section, w: Work) -> None:
    """Fill in how fast direct currents change at a row as sources move.

    w: as evaluated there; its currents become 0.
    """
    s.driven[:] = 0.0
    if not way.free[row] or way.fastest[row] == 0.0:
        return
    s.probe[:] = 0.0
    for q in range(way.drive.shape[1]):
        s.probe[k.unknowns + q] = way.drive[row, q]
    _rates(k, s.probe, w)
    for i in range(k.unknowns):
        for p in range(k.conductance.start[i], k.conductance.start[i + 1]):
            s.driven[i] += k.conductance.value[p] * s.probe[k.conductance.column[p]]
    for p in range(k.stamps.row.size):
        s.driven[k.stamps.row[p]] += k.stamps.current_sign[p] * w.current[k.stamps.current[p]]
    w.current[:] = 0.0


@compiled()
def _rates(k: Kernel, rate: F64, w: Work) -> None:
    """Write into the currents of all devices how fast they change; rate: of the voltages, V/s."""
    t, x = k.transistors.terminal, w.transistor
    for i in range(t.shape[1]):
        bulk = rate[t[3, i]]
        by_gate = rate[t[1, i]] - bulk
        drain, source = rate[t[0, i]] - bulk, rate[t[2, i]] - bulk
        g, own = x.conductance, x.junction_conductance
        x.current[i] = g[0, i] * drain + g[1, i] * by_gate + g[2, i] * source
        x.junction[0, i] = own[0, i] * drain + own[2, i] * by_gate
        x.junction[1, i] = own[1, i] * source + own[3, i] * by_gate
    for j in range(k.amplifier_terminal.shape[1]):
        for i in range(5):
            w.amplifier_current[i, j] = 0.0
            for c in range(5):
                w.amplifier_current[i, j] += w.amplifier_slope[i, c, j] * rate[k.amplifier_terminal[c, j]]
    for d in range(k.diodes.saturation.size):
        across = rate[k.diodes.terminal[0, d]] - rate[k.diodes.terminal[1, d]]
        for part in range(2):
            w.diode_current[part, d] = w.diode_slope[part, d] * across


@compiled()
def lay(k: Kernel, way: Way, row: int, s: Section) -> bool:
    """Fill in what the times of a row's points move, and r; returns whether its own time may follow from r.

    `drive` was at the row.
    """
    h, share = way.time[row] - way.time[row - 1], way.share[row]
    before = way.time[row - 1] - way.time[row - 2] if way.order[row] == 2 else 0.0
    _fill_parabola(k, way, row, h, before, s)
    for i in range(k.unknowns):
        by_rate, by_bend = 0.0, 0.0
        for p in range(k.charge.start[i], k.charge.start[i + 1]):
            c = k.charge.column[p]
            if c < k.unknowns:
                by_rate += k.charge.value[p] * s.rate[c]
                by_bend += k.charge.value[p] * s.bend[c]
        s.moves[0, i] = by_bend - share[0] * (by_rate + 0.5 * h * by_bend) + s.driven[i]
        s.moves[1, i] = -share[1] * (by_rate - 0.5 * h * by_bend)
        s.moves[2, i] = -share[2] * (by_rate - (0.5 * h + before) * by_bend)
    moving = way.fastest[row] + way.fastest[row - 1]
    if moving + way.fastest[max(row - 2, 0)] > 0.0:
        _add_sources(k, way, row, (0.5 * h, -0.5 * h, -0.5 * h - before), s)
    return way.free[row] and _lay_across(k, way, row, h, s)


@compiled()
def _fill_parabola(k: Kernel, way: Way, row: int, h: float, before: float, s: Section) -> None:
    """Fill in rates and bends; h, before: lengths of the step and of the one before it, s, 0 of none."""
    for c in range(k.columns):
        s.rate[c], s.bend[c] = (way.voltage[row, c] - way.voltage[row - 1, c]) / h, 0.0
        if before > 0.0:
            rate = (way.voltage[row - 1, c] - way.voltage[row - 2, c]) / before
            s.bend[c] = 2.0 * (s.rate[c] - rate) / (h + before)


@compiled()
def _add_sources(k: Kernel, way: Way, row: int, after: tuple[float, float, float], s: Section) -> None:
    """Add what sources move by capacitances; after: times of the points after the middle of the step, s."""
    for i in range(k.unknowns):
        for p in range(k.charge.start[i], k.charge.start[i + 1]):
            c = k.charge.column[p]
            if k.unknowns <= c < k.columns - 1:
                s.moves[0, i] += k.charge.value[p] * s.bend[c]
                for j in range(3 if way.order[row] == 2 else 2):
                    rate = s.rate[c] + after[j] * s.bend[c] - way.drive[row - j, c - k.unknowns]
                    s.moves[j, i] -= k.charge.value[p] * way.share[row, j] * rate


@compiled()
def _lay_across(k: Kernel, way: Way, row: int, h: float, s: Section) -> bool:
    """Fill in r; returns whether it is known, and runs away from sources."""
    total, fastest = 0.0, 0.0
    for i in range(k.unknowns):
        s.across[i] = 0.0
        if k.dynamic[i] and i >= k.charges:  # charges are of another unit
            s.across[i] = s.rate[i] + 0.5 * h * s.bend[i]
            total += s.across[i] ** 2
            fastest = max(fastest, abs(s.across[i]))
    if fastest * h <= SEEN or fastest <= way.fastest[row]:
        return False
    for i in range(k.unknowns):
        s.across[i] /= total
    return True


@compiled()
def shift(own: bool, through: float, row: int, way: Way, moved: F64, owed: F64, s: Section) -> None:  # noqa: FBT001 - as the row is
    """Let the time of a row move, of one measure.

    own: whether it follows from r; through: `solved . moves`. moved: m at the row, float64[unknowns]; owed:
    of the measure by the times, float64[rows], to which what the row has by those before it is added; it
    becomes what the whole run has by the times that stay where the testbench says, and 0 elsewhere.
    """
    by_time = 0.0
    for i in range(moved.size):
        by_time += moved[i] * s.moves[0, i]
    if own:
        by = (by_time - owed[row]) / through
        for i in range(moved.size):
            moved[i] -= by * s.solved[i]
        owed[row] = 0.0
    elif way.free[row] and way.fastest[row] == 0.0:
        owed[row - 1] += owed[row] - by_time
        owed[row] = 0.0
    else:
        owed[row] -= by_time
    for j in range(1, 3 if way.order[row] == 2 else 2):
        for i in range(moved.size):
            owed[row - j] -= moved[i] * s.moves[j, i]
