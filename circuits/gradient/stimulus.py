"""What sources and stimuli move measures by, from an adjoint run.

A parameter of a testbench moves the corners of its sources: their values, and their times, with which the
steps at them move (`circuits.gradient.section`). Between corners a source has another value at the same time.
So with T_k what a measure has by the time of the step at a corner, and D_k by the sources' values at a step,

    dM/dp = sum over corners of T_k dt_k/dp + sum over steps of D_k ds_k/dp
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.devices.source import Polyline, polyline
from circuits.gradient.backwards import Adjoint
from circuits.gradient.flow import slope_residual
from circuits.gradient.parameters import Rows
from circuits.gradient.way import SAME_TIME, Way, nearest
from circuits.lowering.kernel import Kernel, Machine
from circuits.solver.newton import Work, allocate, evaluate
from circuits.testbench import Testbench

NUDGE = 1e-5  # V, and of the largest current, by which a source's value is moved; ours
LEAST = 1e-12  # A, of a current source that gives nothing; ours


class Step(NamedTuple):
    """A parameter's label, its SI unit, and how far it is moved in it."""

    label: str
    unit: str
    size: float


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """A parameter of a testbench.

    step : which it is, and how far it is moved.
    more, less : the testbench's sources that far further and back, as polylines.
    """

    step: Step
    more: tuple[Polyline, ...]
    less: tuple[Polyline, ...]


def own_moves(machine: Machine) -> list[Move]:
    """Return value and delay of each source of a testbench: `source.NAME.value`, `source.NAME.time`."""
    found = []
    for number, source in enumerate(machine.testbench.sources):
        time, value = machine.polylines[number]
        voltage = source.quantity == "voltage"
        step = NUDGE * (1.0 if voltage else max(float(np.abs(value).max()), LEAST))
        one, none, label = np.ones(time.size), np.zeros(time.size), f"source.{source.name}"
        found.append(
            _own(machine, number, (none, one), Step(f"{label}.value", "V" if voltage else "A", step))
        )
        if time.size > 1 and np.ptp(value) > 0.0:
            nudge = 1e-3 * float(np.diff(time).min())
            found.append(_own(machine, number, (one, none), Step(f"{label}.time", "s", nudge)))
    return found


def move_between(machine: Machine, step: Step, more: Testbench, less: Testbench) -> Move | None:
    """Return the parameter that moves a machine's testbench to two others.

    None where it moves none of its sources, or more than these.
    """
    bench = machine.testbench
    if any(replace(other, sources=bench.sources) != bench for other in (more, less)):
        return None
    given = len(bench.sources)
    if not len(more.sources) == len(less.sources) == given:
        return None
    ends = [
        (*(polyline(s.name, s.waveform) for s in other.sources), *machine.polylines[given:])
        for other in (more, less)
    ]
    pairs = zip(*ends, strict=True)
    same = all(a[0].size == b[0].size and (np.array(a) == np.array(b)).all() for a, b in pairs)
    return None if same else Move(step, *ends)


def _own(machine: Machine, number: int, by: tuple[F64, F64], step: Step) -> Move:
    """A parameter of one source, whose corners move by `by` with it: times and values."""

    def moved(sign: float) -> tuple[Polyline, ...]:
        lines = list(machine.polylines)
        time, value = lines[number]
        lines[number] = time + sign * step.size * by[0], value + sign * step.size * by[1]
        return tuple(lines)

    return Move(step, moved(1.0), moved(-1.0))


def rows_by_moves(machine: Machine, way: Way, found: Adjoint, moves: Sequence[Move]) -> list[Rows]:
    """Return what parameters of a testbench move measures by; not those that add or take corners away."""
    known = [
        (move.step, moved) for move in moves if (moved := _sources_moved(machine, way, move)) is not None
    ]
    if not known:
        return []
    wanted = np.flatnonzero(np.any([by_value.any(axis=1) for _, (_, by_value) in known], axis=0))
    by_sources = np.zeros(found.given.shape)
    _by_sources(machine.kernel, way.voltage, wanted, found.moved, allocate(machine.kernel), by_sources)
    rows = []
    for step, moved in known:
        by = _by(machine, way, found, by_sources, moved)
        rows.append(Rows([step.label], step.unit, np.zeros(1), by[:, None]))
    return rows


def _sources_moved(machine: Machine, way: Way, move: Move) -> tuple[F64, F64] | None:
    """dt/dp of the rows, float64[rows], and ds/dp of the sources there, float64[rows, sources].

    None where a source has another number of corners.
    """
    time = way.time
    by_time, by_value = np.zeros(time.size), np.zeros((time.size, len(machine.polylines)))
    corners = []
    for q, (own, more, less) in enumerate(zip(machine.polylines, move.more, move.less, strict=True)):
        if not own[0].size == more[0].size == less[0].size:
            return None
        dt, du = (0.5 * (a - b) / move.step.size for a, b in zip(more, less, strict=True))
        by_value[:, q] = 0.5 * (np.interp(time, *more) - np.interp(time, *less)) / move.step.size
        if machine.sampled[q] or not (dt.any() or du.any()):
            continue
        at, corner = _at_corners(way, own[0])
        # on its way from corner to corner its steps go with both
        here = way.free & (way.drive[:, q] != 0.0)
        by_time[here] = np.interp(time[here], own[0], dt)
        by_time[at] = np.where(dt[corner] != 0.0, dt[corner], by_time[at])
        corners.append((q, at, dt[corner], du[corner]))
    # a source without a corner there has another value where the row goes
    by_value += np.where(way.free[:, None], 0.0, way.drive * by_time[:, None])
    for q, at, dt, du in corners:
        by_value[at, q] = du + way.drive[at, q] * (by_time[at] - dt)
    by_time[[0, -1]] = 0.0
    return by_time, by_value


def _at_corners(way: Way, corner: F64) -> tuple[I64, I64]:
    """Rows at corners of a source, and their numbers; not the first and the last row, whose times stay."""
    near = nearest(corner, way.time)
    rows = np.flatnonzero((np.abs(corner[near] - way.time) <= SAME_TIME) & ~way.free)
    rows = rows[(rows > 0) & (rows < way.time.size - 1)]
    return rows, near[rows]


def _by(machine: Machine, way: Way, found: Adjoint, by_sources: F64, moved: tuple[F64, F64]) -> F64:
    """What sources that move so move the measures by, float64[measures]."""
    by_time, by_value = moved
    # at corners without what sources do as they go on beyond
    beyond = (found.given * way.drive).sum(axis=2) + _charged(machine, way, found.moved, way.drive)
    by = (found.timing - np.where(way.free, 0.0, beyond)) @ by_time
    by += ((found.given + by_sources) * by_value).sum(axis=(1, 2))
    return np.asarray(by + _charged(machine, way, found.moved, by_value).sum(axis=1))


def _charged(machine: Machine, way: Way, moved: F64, by_value: F64) -> F64:
    """What sources do through what stores charge, float64[measures, rows]: by their values at each row."""
    k = machine.kernel
    charge = np.zeros((k.unknowns, by_value.shape[1]))
    row_of = np.repeat(np.arange(k.unknowns), np.diff(k.charge.start))
    outside = (k.charge.column >= k.unknowns) & (k.charge.column < k.columns - 1)
    np.add.at(charge, (row_of[outside], k.charge.column[outside] - k.unknowns), k.charge.value[outside])
    pulled = moved @ charge  # [measures, rows, sources]
    found = np.zeros(moved.shape[:2])
    for j in range(3):
        last = way.time.size - j
        found[:, :last] -= way.share[j:, j] * (pulled[:, j:] * by_value[:last]).sum(axis=2)
    return found


@compiled()
def _by_sources(k: Kernel, voltage: F64, wanted: I64, moved: F64, w: Work, out: F64) -> None:
    """Fill in what sources do without charge by their values.

    wanted: rows, int64. out: float64[measures, rows, sources].
    """
    slopes = w.rate
    for row in wanted:
        evaluate(k, voltage[row], w)
        for m in range(moved.shape[0]):
            slopes[:] = 0.0
            slope_residual(k, moved[m, row], w, slopes)
            for q in range(out.shape[2]):
                out[m, row, q] = slopes[k.unknowns + q]
