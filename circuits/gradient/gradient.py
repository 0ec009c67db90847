"""Gradients of measures by all devices and parameters of a testbench on its silicon.

    found = gradients_of(machine, (SpikeTime("spike"), Voltage("v_mem", 5e-3)))

runs the testbench once, and once backwards (`circuits.gradient.backwards`). What they are by is told in
`circuits.gradient.parameters`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError, SolverError
from circuits.gradient.backwards import Adjoint, Tap, backwards
from circuits.gradient.measure import Current, Measure, Voltage
from circuits.gradient.parameters import VOLT, rows_of
from circuits.gradient.reading import Reading
from circuits.gradient.stimulus import Move, rows_by_moves
from circuits.gradient.sums import ends_of, no_sums
from circuits.gradient.tap import Into, add_taps
from circuits.gradient.way import Way, way_of
from circuits.lowering.kernel import Machine
from circuits.solver.beginning import beginning, held_voltages
from circuits.solver.outcome import Outcome
from circuits.solver.transient import Result, Steps, simulate

GRADIENT_RTOL = 1e-8
"""Local error of a step, relative to the larger of |v| and 1 V, at which what edges move is resolved; ours.

At 5e-7 what a pulse's length does to a plastic synapse's weight is 23 % off, at 1e-8 1.3 %.
"""
SAFE = 3.0  # sigma: a peak that is nearer to what makes it another measure is told of; ours
RESOLVED = 200.0  # times the tolerance in V, above which 1 % of what a voltage moves by is resolved; ours


@dataclass(frozen=True, slots=True, eq=False)
class Gradients:
    """Gradients of some measures of a testbench.

    Attributes
    ----------
    measures, units : tuple of str
        Name and SI unit of each measure.
    values : array
        Their values, float64[measures], in SI units; NaN where one is not defined.
    notes : tuple of str
        Why a measure has no value, or where it is not smooth; empty else.
    labels, of_units : tuple of str
        Label of each parameter, and its SI unit, empty for a relative one.
    sigma : array
        Standard deviation of each parameter over dies, float64[parameters]; 0 for what no die draws, and for
        mismatch or process where the silicon's dies have none of it.
    by : array
        Derivative of each measure by each parameter, float64[measures, parameters], in SI units.
    result : Result or None
        The run that was measured; None where none was.
    error : array
        How far each measure's gradients at ten times the tolerance differ, times the sigma of what is moved,
        as a share of its spread, float64[measures]; empty, or NaN, where they were not found.
    """

    measures: tuple[str, ...]
    units: tuple[str, ...]
    values: F64
    notes: tuple[str, ...]
    labels: tuple[str, ...]
    of_units: tuple[str, ...]
    sigma: F64
    by: F64 = field(repr=False)
    result: Result | None = field(repr=False)
    error: F64 = field(default_factory=lambda: np.zeros(0), repr=False)

    @property
    def spread(self) -> F64:
        """Standard deviation of each measure over dies in the linear theory, float64[measures].

        Of components of variation it has those of single capacitors alone.
        """
        moved = np.where(self.sigma > 0.0, self.by, 0.0) * self.sigma
        return np.asarray(np.sqrt((moved**2).sum(axis=1)))


def gradients_of(
    machine: Machine, measures: Sequence[Measure], *, rtol: float = GRADIENT_RTOL, moves: Sequence[Move] = ()
) -> Gradients:
    """Return the gradients of some measures.

    Parameters
    ----------
    machine
        Lowered testbench on its silicon.
    measures
        What is measured.
    rtol
        Local error of a step of the transient, relative to the larger of |v| and 1 V.
    moves
        Parameters of the testbench that have a derivative too, as `own_moves` of its sources.

    Raises
    ------
    ParameterError
        There is no measure.
    SolverError
        The solver gives up, or the way backwards is singular.
    """
    if not measures:
        raise ParameterError(f"{machine.testbench.title}: no measure, must be at least one")
    result = _run(machine, measures, rtol)
    way = way_of(result)
    read = [each.read(result, way) for each in measures]
    every = [*read, *(near.reading for found in read for near in found.near)]
    way = _until(way, every)
    asked = [k for k, each in enumerate(every) if each.slopes or each.taps or each.whole]
    run = _solved(machine, way, [every[k] for k in asked])
    solved = [*rows_of(machine, run), *rows_by_moves(machine, way, run, moves)]
    by = np.full((len(every), sum(len(rows.labels) for rows in solved)), np.nan)
    by[asked] = np.concatenate([rows.by for rows in solved], axis=1)
    sigma = np.concatenate([rows.sigma for rows in solved])
    spread = np.sqrt(((by * sigma) ** 2).sum(axis=1))
    small = np.array([m.unit == "V" for m in measures]) & (spread[: len(read)] > 0.0)
    small &= spread[: len(read)] < RESOLVED * rtol
    kicked = _kicked(machine, way)
    notes = tuple(note or kicked for note in _notes(read, spread, small, result))
    sigma = np.concatenate([rows.sigma * rows.varies for rows in solved])
    names = [(label, rows.unit) for rows in solved for label in rows.labels]
    return Gradients(
        tuple(m.name for m in measures), tuple(m.unit for m in measures),
        np.array([r.value for r in read]), notes, tuple(n for n, _ in names), tuple(u for _, u in names),
        sigma, by[: len(read)], result,
    )  # fmt: skip


def _run(machine: Machine, measures: Sequence[Measure], rtol: float) -> Result:
    """The testbench's run; of its beginning alone where nothing else is measured."""
    if any(not isinstance(m, Voltage | Current) or m.at is not None for m in measures):
        return simulate(machine, rtol=rtol)
    begun = beginning(machine)
    first = begun.voltage[machine.column][None, :]
    return Result(
        machine,
        Outcome.DONE,
        np.zeros(1),
        first,
        machine.names,
        {},
        Steps(0, 0, 0),
        begun.point,
        begun.disturbance,
    )


def _notes(
    read: Sequence[Reading],
    spread: F64,
    small: Bools,
    result: Result,
) -> tuple[str, ...]:
    """What is to be said of each measure; spread: of the measures and of what is near them."""
    at, notes = len(read), []
    for k, found in enumerate(read):
        told = [found.note] if found.note else []
        if small[k]:
            told.append(f"moves by {spread[k]:.2g} V over dies, which is less than the run resolves")
        if not told and result.disturbance is not None:
            told.append(f"{result.disturbance}, which is held")
        for near in found.near:
            away = near.margin / spread[at] if spread[at] > 0.0 else np.inf
            if away < SAFE:
                told.append(f"{near.what} {away:.2g} sigma away, {near.margin:.3g} {near.limit}")
            at += 1
        notes.append("; ".join(dict.fromkeys(told)))
    return tuple(notes)


def _kicked(machine: Machine, way: Way) -> str:
    """What is left out of a run with uic in which sources, by capacitances, move nodes before it begins."""
    if machine.testbench.begin != "uic":
        return ""
    before = np.zeros(machine.kernel.columns)
    for node, voltage in machine.testbench.initial.items():
        before[machine.column_of(node)] = voltage
    first, last = machine.kernel.charges, machine.kernel.unknowns
    apart = np.where(machine.kernel.dynamic, way.voltage[0, :last] - before[:last], 0.0)[first:]
    worst = int(np.argmax(np.abs(apart))) if apart.size else 0
    if not apart.size or abs(apart[worst]) <= VOLT:
        return ""
    node = machine.names[int(np.flatnonzero(machine.column == first + worst)[0])]
    return f"uic: sources move {node} by {apart[worst]:.3g} V as it begins, of which the gradient has nothing"


def _until(way: Way, read: Sequence[Reading]) -> Way:
    """The way up to the last point that is measured."""
    rows = [row for found in read for row, _, _ in found.slopes]
    weights = [weight for found in read for tap in found.taps for weight in tap[1:]]
    weights += [weight for found in read for _, weight in found.whole]
    rows += [int(row) for weight in weights for row in np.flatnonzero(weight)[-1:]]
    end = 1 + max(rows, default=0)
    return Way(
        way.time[:end], way.voltage[:end], way.share[:end], way.order[:end], way.drive[:end],
        way.fastest[:end], way.free[:end],
    )  # fmt: skip


def _solved(machine: Machine, way: Way, read: Sequence[Reading]) -> Adjoint:
    """The adjoint run of some readings."""
    k, rows, ends = machine.kernel, way.time.size, ends_of(machine)
    last, sums = k.columns - 1, no_sums(k, len(read), ends)  # the last is ground
    slopes, given = (np.zeros((len(read), rows, n)) for n in (k.unknowns, last - k.unknowns))
    timing = np.zeros((len(read), rows))
    for m, each in enumerate(read):
        _lay_out(each, slopes[m], given[m], timing[m])
    beside = given.sum(axis=1)
    taps = tuple(
        (m, Tap(tap.name, *(part[:rows] for part in tap[1:])))
        for m, each in enumerate(read)
        for tap in each.taps
    )
    if taps:
        into = Into(np.zeros((len(read), rows, k.columns)), timing, sums)
        add_taps(machine, way, taps, ends, into)
        slopes += into.slopes[:, :, : k.unknowns]
        given += into.slopes[:, :, k.unknowns : last]
    # sources move with the time alone
    timing += (given * way.drive).sum(axis=2)
    solved = backwards(k, way, slopes, timing, _held(machine), ends, sums)
    if solved is None:
        title = machine.testbench.title
        raise SolverError(f"{title}: singular at its beginning; look for a node that floats")
    return solved._replace(taps=taps, given=given, beside=beside)


def _lay_out(found: Reading, slopes: F64, given: F64, timing: F64) -> None:
    """Write the slopes of a reading: by unknowns and by sources, float64[rows, n], and by times."""
    rows, unknowns = slopes.shape
    last = unknowns + given.shape[1]
    for row, slope in found.timing:
        timing[row] += slope
    if found.along is not None:
        timing += found.along[:rows]
    every: list[tuple[int | slice, int, float | F64]] = [*found.slopes]
    every += [(slice(None), column, weight[:rows]) for column, weight in found.whole]
    for at, column, by in every:
        if column < unknowns:
            slopes[at, column] += by
        elif column < last:
            given[at, column - unknowns] += by


def _held(machine: Machine) -> Bools:
    """Which unknowns are held at the beginning."""
    held = np.zeros(machine.kernel.unknowns, dtype=np.bool_)
    bench = machine.testbench
    if bench.begin == "uic":
        held[machine.kernel.charges :] = True  # charges follow the voltages that are held
        return held
    for node in held_voltages(bench, machine.flat, machine.silicon):
        held[machine.column_of(node)] = True
    return held
