"""What runs of one circuit side by side are made of: its structure, the numbers of each run, working memory.

The structure (`Wiring`) is that of the solver's kernel, but for the stamps, which are sorted by what they add
to, so that a row of the residual and an entry of the Jacobian are each summed up in one go. Runs differ in
their numbers (`Jobs`): coefficients of transistors, capacitances, conductances, sources, thresholds, and
where they begin. The numbers of the runs that are on the way stand in the lanes of `Team`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I32, I64, U32, Bools
from circuits.devices.transistor import TransistorArrays
from circuits.lowering.factor import Factor
from circuits.lowering.kernel import Machine, Rows, Sources, pack_sources
from circuits.lowering.supply import spike_levels
from circuits.solver.integrate import source_values
from circuits.vectors.vector import WIDTH, rows


class Term(NamedTuple):
    """Which coefficient of a transistor stands where: each has a row a transistor (`TransistorArrays`)."""

    specific_current: int = 0
    inverse_2ut: int = 1
    v_t0: int = 2
    kappa: int = 3
    gamma: int = 4
    surface_potential: int = 5
    early: int = 6
    early_rise: int = 7
    reduction: int = 8
    leakage: int = 9
    induced: int = 10
    induced_from: int = 11
    induced_per_volt: int = 12
    lift: int = 13  # 2 phi_F + gamma sqrt(2 phi_F) - V_T0, V
    spread: int = 14  # 2 U_T^2, V^2


class Row(NamedTuple):
    """Which row of `Team.control` has what of each lane."""

    a: int = 0  # the derivative of a step is `a v + b0 v_n + b1 v_n-1`, 1/s
    b0: int = 1
    b1: int = 2
    devices: int = 3  # 0 where the Jacobian is that of the charges alone, else 1
    largest_move: int = 4  # V, of a node in an iteration; 0 keeps all voltages
    steps: int = 5  # 1 in a lane that makes steps
    begins: int = 6  # 1 where a step is to begin
    accepted: int = 7  # 1 where a step was accepted
    step: int = 8  # s
    inverse_step: int = 9
    next_step: int = 10  # s
    time_new: int = 11  # s, end of the step
    at_bend: int = 12  # 1 where the step ends on a breakpoint
    bend: int = 13  # s, the next breakpoint
    began: int = 14  # s, the last breakpoint
    time0: int = 15  # s, of the last three points
    time1: int = 16
    time2: int = 17
    points: int = 18  # valid ones since the last restart
    share: int = 19  # of the distance to the prediction that is the step's error
    iteration: int = 20  # of the step
    update: int = 21  # the largest, over the larger of |v| and 1 V
    error: int = 22
    broken: int = 23  # 1 where an update is no number
    curvature: int = 24  # V
    steps_done: int = 25
    steps_rejected: int = 26
    iterations: int = 27
    pull: int = 28  # S, a conductance from each node to where a rest state is looked for
    tries: int = 29  # at a rest state, so far


TERM, ROW = Term(), Row()

IDLE, RESTING, CHECKING, RESTARTING, STEPPING = range(5)
"""What a lane is doing."""
WAITING, RUNNING, DONE, FAILED = range(4)
"""What has become of a run."""


class Sums(NamedTuple):
    """What is added to each of some totals: terms start[i] to start[i + 1], each a source and a sign."""

    start: I32
    source: U32
    sign: F64


class Wiring(NamedTuple):
    """A circuit's structure, which all its runs share."""

    unknowns: int
    columns: int
    terminal: I32  # [4, transistors]
    polarity: F64  # [transistors] +1 nFET, -1 pFET
    body_effect: bool
    effects: bool  # whether there is an Early effect, or the mobility falls
    leaks: bool
    induces: bool
    charge: Rows  # without its values
    conductance: Rows  # without its values
    charge_at: I32  # [entries] which capacitance stands there, -1 for none
    conductance_at: I32  # [entries]
    currents: Sums  # a row of the residual each
    slopes: Sums  # an entry of the Jacobian each
    factor: Factor
    dynamic: Bools
    moving: I64  # [moving] sources that are not constant
    watch: I64  # [watched] columns
    recorded: I64  # [recorded] columns


class Jobs(NamedTuple):
    """The numbers of each run. Equal lines of sources are kept once: `line` says which are a run's."""

    coefficient: F64  # [jobs, terms, transistors]
    charge: F64  # [jobs, capacitances], F
    conductance: F64  # [jobs, conductances], S
    level: F64  # [jobs, 2, watched], V, as of `spike_levels`
    curvature: F64  # [jobs], V
    start: F64  # [jobs, columns], V, where it begins, or where its rest state is looked for
    line: I64  # [jobs]
    line_start: I64  # [lines, sources + 1]
    line_time: F64  # s
    line_value: F64
    stop: float  # s
    rtol: float
    most: float  # steps
    resting: bool  # whether rest states are looked for, instead of runs
    recording: bool  # whether points are recorded


class Team(NamedTuple):
    """Working memory of one thread; each row has a number a lane."""

    v: F64  # [columns], V, and those of the last three points
    v0: F64
    v1: F64
    v2: F64
    guess: F64
    slope: F64  # [columns] derivative at the last restart, V/s
    rate: F64  # [columns]
    extra: F64  # [columns] derivative that a restart gives the sources, V/s
    coefficient: F64  # [terms * transistors]
    charge: F64
    conductance: F64
    current: F64  # [3 transistors] channels, then junctions of drains and of sources
    device_slope: F64  # [7 transistors] as of `circuits.solver.newton`
    jacobian: F64
    residual: F64
    base: F64  # [moving] value of a source where its segment began, V or A
    drift: F64  # [moving] its slope there
    level: F64  # [2 watched]
    extent: F64  # [2 watched] lowest and highest voltage of the watched nodes, V
    armed: F64  # [watched] 1 or 0
    control: F64  # [rows of `Row`]
    cursor: I64  # [moving, WIDTH]
    doing: I64  # [WIDTH]
    job: I64  # [WIDTH]
    block: I64  # [WIDTH] where its points go; -1 for nowhere yet
    queue: I64  # [2] the next run, and how many there are


class Found(NamedTuple):
    """What runs leave: how each ended, and room for what they record, which they take block by block."""

    state: I64  # [jobs]
    rest: F64  # [jobs, columns], V
    jacobian: F64  # [jobs, entries], S, at rest
    steps: F64  # [jobs, 3] steps accepted, rejected, iterations
    extent: F64  # [jobs, 2, watched] lowest and highest voltage of the watched nodes, V
    point: F64  # [blocks, points, 1 + recorded] time (s) and voltages (V)
    filled: I64  # [blocks]
    owner: I64  # [blocks] job
    spike_time: F64  # [spikes], s
    spike_index: I64  # [spikes]
    spike_job: I64  # [spikes]
    used: I64  # [2] blocks, spikes


def wiring(machine: Machine, recorded: I64, watch: I64, moving: I64) -> Wiring:
    """The structure of a machine's circuit; arrays as of `Wiring`."""
    k = machine.kernel
    t, s = k.transistors, k.stamps
    dead = _dead(t)
    return Wiring(
        k.unknowns, k.columns, t.terminal, t.sign, t.body_effect, bool(t.reduces or t.early.any()), t.leaks,
        t.induces, k.charge, k.conductance, _at(k.charge, k.factor.entries),
        _at(k.conductance, k.factor.entries), _sums(s.row, s.current, s.current_sign, dead[0], k.unknowns),
        _sums(s.entry, s.slope, s.slope_sign, dead[1], k.factor.entries), k.factor, k.dynamic,
        moving, watch, recorded,
    )  # fmt: skip


def moving_of(machines: Sequence[Machine]) -> I64:
    """Sources that are not constant in all machines of one structure."""
    sets = {id(m.polylines): m.polylines for m in machines}.values()
    count = len(machines[0].polylines)
    moving = [q for q in range(count) if any(lines[q][0].size > 1 for lines in sets)]
    return np.array(moving, dtype=np.int64)


def _at(matrix: Rows, entries: int) -> I32:
    """Which value of a matrix stands at each entry of the Jacobian, -1 for none."""
    found = np.full(entries, -1, dtype=np.int32)
    inside = np.flatnonzero(matrix.entry >= 0)
    found[matrix.entry[inside]] = inside
    return found


def _dead(t: TransistorArrays) -> tuple[I64, I64]:
    """Which currents and slopes are always 0: of junctions that have no voltage across them."""
    n = t.sign.size
    both = [side * n + np.flatnonzero(t.terminal[2 * side] == t.terminal[3]) for side in range(2)]
    junctions = np.concatenate(both)
    return n + junctions, np.concatenate([3 * n + junctions, 5 * n + junctions])


def _sums(target: U32, source: U32, sign: F64, dead: I64, count: int) -> Sums:
    """Terms sorted by what they add to, without those that are always 0."""
    order = np.argsort(target, kind="stable")
    order = order[~np.isin(source[order], dead)]
    start = np.searchsorted(target[order], np.arange(count + 1)).astype(np.int32)
    return Sums(start, source[order], sign[order])


def jobs_of(
    machines: Sequence[Machine],
    starts: Sequence[F64],
    rtol: float = 1.0,
    most: float = np.inf,
    *,
    resting: bool = False,
) -> Jobs:
    """The numbers of machines of one structure.

    starts: voltages of each machine's unknown nodes, float64[columns], V; its sources have their own at 0 s.
    The rest as of `Jobs`.
    """
    lines: dict[int, int] = {}
    packed: list[Sources] = []
    for machine in machines:
        if id(machine.polylines) not in lines:
            lines[id(machine.polylines)] = len(packed)
            packed.append(pack_sources(machine.polylines, machine.sampled))
    offset = np.cumsum([0, *(s.time.size for s in packed[:-1])])
    first, n = machines[0], machines[0].kernel.unknowns
    sources = {key: source_voltages(m)[n:] for key, m in {id(m.polylines): m for m in machines}.items()}
    start = np.stack(starts)
    start[:, n:] = [sources[id(m.polylines)] for m in machines]
    levels = [spike_levels(m) for m in (machines if len(packed) > 1 else machines[:1])]
    return Jobs(
        _coefficients([m.kernel.transistors for m in machines]),
        np.stack([m.kernel.charge.value for m in machines]),
        np.stack([m.kernel.conductance.value for m in machines]),
        np.broadcast_to(levels, (len(machines), *levels[0].shape)).copy(),
        np.array([m.kernel.curvature for m in machines]),
        start,
        np.array([lines[id(m.polylines)] for m in machines], dtype=np.int64),
        np.stack([s.start + o for s, o in zip(packed, offset, strict=True)]),
        np.concatenate([s.time for s in packed]),
        np.concatenate([s.value for s in packed]),
        float(first.testbench.stop), float(rtol), float(most), resting, not resting,
    )  # fmt: skip


def _coefficients(tables: Sequence[TransistorArrays]) -> F64:
    """Coefficients of all transistors, float64[tables, terms, transistors]."""
    found = np.empty((len(tables), len(TERM), tables[0].sign.size))
    for row, name in enumerate(Term._fields[: TERM.lift]):
        each = [getattr(t, name) for t in tables]
        found[:, row] = each[0] if all(x is each[0] for x in each) else each
    phi, gamma = found[:, TERM.surface_potential], found[:, TERM.gamma]
    found[:, TERM.lift] = phi + gamma * np.sqrt(phi) - found[:, TERM.v_t0]
    found[:, TERM.spread] = 0.5 / found[:, TERM.inverse_2ut] ** 2
    return found


def source_voltages(machine: Machine) -> F64:
    """The vector of voltages with the sources' values at 0 s, and 0 V at all unknown nodes."""
    k, sources = machine.kernel, machine.sources()
    v = np.zeros(k.columns)
    source_values(sources, sources.start[:-1].copy(), 0.0, v, k.unknowns)
    return v


def new_team(w: Wiring, count: int) -> Team:
    """Working memory for `count` runs."""
    transistors = w.polarity.size
    sizes = [w.columns] * 8
    sizes += [len(TERM) * transistors, w.charge.column.size, w.conductance.column.size]
    sizes += [3 * transistors, 7 * transistors, w.factor.entries, w.unknowns, w.moving.size, w.moving.size]
    sizes += [2 * w.watch.size, 2 * w.watch.size, w.watch.size, len(ROW)]
    nothing = np.full((2, WIDTH), -1, dtype=np.int64)
    whole = [np.zeros((w.moving.size, WIDTH), np.int64), np.full(WIDTH, IDLE, dtype=np.int64), *nothing]
    return Team._make([*map(rows, sizes), *whole, np.array([0, count], dtype=np.int64)])


def new_found(w: Wiring, count: int, blocks: int, points: int) -> Found:
    """Room for what `count` runs leave, with `blocks` blocks of points to record."""
    spikes = max(4096, 2 * WIDTH * w.watch.size)
    return Found(
        np.full(count, WAITING, dtype=np.int64), np.zeros((count, w.columns)),
        np.zeros((count, w.factor.entries)), np.zeros((count, 3)), np.zeros((count, 2, w.watch.size)),
        np.empty((blocks, points, 1 + w.recorded.size)), np.zeros(blocks, np.int64),
        np.zeros(blocks, np.int64), np.zeros(spikes), np.zeros(spikes, np.int64), np.zeros(spikes, np.int64),
        np.zeros(2, np.int64),
    )  # fmt: skip


def dense(w: Wiring, jacobian: F64) -> F64:
    """Matrices, float64[jobs, unknowns, unknowns], of the entries of the Jacobian, float64[jobs, entries]."""
    f, n = w.factor, w.unknowns
    pivots = np.arange(n)
    row = np.concatenate([pivots, f.lower_row, np.repeat(pivots, np.diff(f.upper_start))])
    column = np.concatenate([pivots, np.repeat(pivots, np.diff(f.lower_start)), f.upper_column])
    found = np.zeros((len(jacobian), n, n))
    found[:, row, column] = jacobian[:, np.concatenate([f.diagonal, f.lower, f.upper])]
    return found


def structure_of(machine: Machine) -> tuple[object, ...]:
    """What machines whose runs go together have in common: nodes, sources, pattern, terms of the law."""
    k = machine.kernel
    t = k.transistors
    flags = (k.unknowns, k.columns, t.body_effect, t.reduces, t.leaks, t.induces, bool(t.early.any()))
    arrays = (
        t.terminal, t.sign, k.charge.start, k.charge.column, k.conductance.start, k.conductance.column,
        k.stamps.row, k.dynamic,
    )  # fmt: skip
    return (
        *flags,
        *(a.tobytes() for a in arrays),
        machine.names,
        machine.testbench.watch,
        machine.testbench.stop,
    )
