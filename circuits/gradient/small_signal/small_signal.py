"""Gradients of measures of small signals, from one operating point and transposed equations.

A transfer H solves `Y u = 0` at the unknown nodes, with Y = G + j w C over all columns, u the voltages, and
1 at the source that moves. It is `H = s^T u`, with s 1 at a node, and of a current what the voltages do to
it (`circuits.gradient.small_signal.spectrum`). With the transposed equations `Y^T lambda = c s`, a measure
that reads H with the weight c (`circuits.gradient.small_signal.transfer`) moves by

    dM = Re(c dH) = Re(c ds^T u) - Re(lambda^T dY u)

What G moves by is that of the devices' currents i at the point v, along u:

    dG u = (di(v + h u) - di(v - h u)) / 2 h

and so the real and the imaginary part of u each give two rows, at v + h u and v - h u, with the multipliers
`+- lambda / 2 h`: what the devices do at such rows is summed as at the steps of a transient
(`circuits.gradient.backwards`). What s moves by is that of the current which is read, at the same rows, with
the weights `+- c / 2 h`. The operating point moves too. It has a row more, at v, with the multipliers m of
its own transposed equations,

    J(v)^T m = sum over the rows of the slopes of what is read there - J(v_r)^T m_r

Source: Director and Rohrer, "The generalized adjoint network and network sensitivities" (1969).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.arrays import C128, F64, I64, T
from circuits.compiled import compiled
from circuits.devices.source import Polyline
from circuits.errors import ParameterError, SolverError
from circuits.gradient.backwards import Adjoint, Tap, add_rows
from circuits.gradient.flow import gather, sloped
from circuits.gradient.gradient import SAFE, Gradients
from circuits.gradient.parameters import Rows, rows_of
from circuits.gradient.small_signal.spectrum import Moves, Spectrum
from circuits.gradient.small_signal.transfer import Edge, Part, Reading, SmallSignal
from circuits.gradient.stimulus import Move
from circuits.gradient.sums import Ends, Sums, ends_of, no_sums
from circuits.lowering.kernel import Kernel, Machine
from circuits.solver.newton import Work, allocate, evaluate, fill_jacobian
from circuits.solver.operating_point import OperatingPoint, linearised, operating_point
from circuits.solver.outcome import Outcome
from circuits.solver.transient import Result, Steps
from circuits.units import format_quantity

BEND = 5e-4  # of the voltage over which a law bends, how far rows are moved along u; ours
SEEN = 1e-9
"""Share of the largest transfer to a device that bends, below which a transfer has no gradient; ours."""
MATTERS = 1e-3  # share of what a measure reads most of, below which a transfer is of no consequence; ours
RESOLVED = 1e-8
"""Share of a transfer, below which 1 % of what moves it is not resolved; ours."""
_FAR = 0.01  # V, most that they are moved


class _Asked(NamedTuple):
    """A reading, or an edge of one, with what moves."""

    parts: tuple[Part, ...]
    measure: SmallSignal


def small_signal_gradients(
    machine: Machine, measures: Sequence[SmallSignal], *, moves: Sequence[Move] = ()
) -> Gradients:
    """Return the gradients of some measures of small signals.

    Parameters
    ----------
    machine
        Lowered testbench on its silicon.
    measures
        What is measured.
    moves
        Parameters of the testbench that have a derivative too, as `own_moves` of its sources.

    Raises
    ------
    ParameterError
        There is no measure, or a frequency is not above 0.
    UnknownNameError
        No such node or source.
    SolverError
        There is no operating point, or the equations are singular at a frequency.
    """
    if not measures:
        raise ParameterError(f"{machine.testbench.title}: no measure, must be at least one")
    point = operating_point(machine)
    spectrum = Spectrum(point)
    read = [_seen(spectrum, each, each.read(spectrum)) for each in measures]
    asked = [_Asked(found.parts, each) for found, each in zip(read, measures, strict=True)]
    edges = [(k, edge) for k, found in enumerate(read) for edge in found.edges]
    asked += [_Asked(edge.parts, measures[k]) for k, edge in edges]
    solved = _solved(spectrum, asked)
    rows = [*rows_of(machine, solved), *_rows_by_moves(machine, solved, moves)]
    by = np.concatenate([each.by for each in rows], axis=1)
    sigma = np.concatenate([each.sigma * each.varies for each in rows])
    spread = np.sqrt(((by * sigma) ** 2).sum(axis=1))
    by[[k for k, found in enumerate(read) if not found.parts]] = np.nan
    notes = _notes(point, read, edges, spread)
    return _gradients(point, measures, read, notes, rows, by[: len(read)])


def _seen(spectrum: Spectrum, measure: SmallSignal, found: Reading) -> Reading:
    """A reading, without what it reads where devices that bend move by far more than what is read.

    Rows at `v +- h u` are rounded to what v is, so that what is far below the largest u is lost in them.
    """
    largest = [_largest(spectrum, measure.moves, part) for part in found.parts]
    sizes = [abs(spectrum.read(measure.moves, part.frequency, part.probe)) for part in found.parts]
    counts = [abs(part.weight) * own for part, own in zip(found.parts, sizes, strict=True)]
    for own, most, count in zip(sizes, largest, counts, strict=True):
        if count > MATTERS * max(counts) and own < SEEN * most:
            why = f"a transfer {own / most:.1g} of the largest at a device, whose gradient is not resolved"
            return Reading(found.value, (), found.unit, why)
    return found


def _largest(spectrum: Spectrum, moves: Moves, part: Part) -> float:
    """The largest transfer to a device that bends; for a current, what of it that would be at its own."""
    k, own = spectrum.point.machine.kernel, np.abs(spectrum.at(moves, part.frequency))
    ends = np.concatenate(
        [t.ravel() for t in (k.transistors.terminal, k.diodes.terminal, k.amplifier_terminal)]
    )
    most = float(own[ends].max(initial=0.0))
    if isinstance(part.probe, int):
        return most
    own[ends] = most
    return float(np.abs(spectrum.drawn(part.probe).at(part.frequency)) @ own)


def _notes(
    point: OperatingPoint, read: Sequence[Reading], edges: Sequence[tuple[int, Edge]], spread: F64
) -> tuple[str, ...]:
    """What is to be said of each measure; spread: of the measures, and of what brings them to each edge."""
    told = [[found.note] if found.note else [] for found in read]
    for own, found, one in zip(told, read, spread.tolist(), strict=False):
        if 0.0 < one < RESOLVED * found.scale:
            moved = format_quantity(one, found.unit)
            own.append(f"moves by {moved} over dies, which is less than is resolved")
    for (k, edge), one in zip(edges, spread[len(read) :].tolist(), strict=True):
        away = edge.margin / one if one > 0.0 else np.inf
        if away < SAFE:
            told[k].append(f"{edge.what} {away:.2g} sigma away")
    if not point.stable:
        for own in told:
            own.append("the operating point is not stable")
    return tuple("; ".join(own) for own in told)


def _gradients(
    point: OperatingPoint,
    measures: Sequence[SmallSignal],
    read: Sequence[Reading],
    notes: tuple[str, ...],
    rows: Sequence[Rows],
    by: F64,
) -> Gradients:
    machine = point.machine
    names = [(label, each.unit) for each in rows for label in each.labels]
    result = Result(
        machine, Outcome.DONE, np.zeros(1), point.voltage[machine.column][None, :], machine.names, {},
        Steps(0, 0, 0), point,
    )  # fmt: skip
    return Gradients(
        tuple(each.name for each in measures), tuple(found.unit for found in read),
        np.array([found.value for found in read]), notes, tuple(n for n, _ in names),
        tuple(u for _, u in names), np.concatenate([each.sigma * each.varies for each in rows]), by, result,
    )  # fmt: skip


def _solved(spectrum: Spectrum, asked: Sequence[_Asked]) -> Adjoint:
    """The transposed equations of what is asked for, as rows of an adjoint run."""
    machine = spectrum.point.machine
    k, v = machine.kernel, spectrum.point.voltage
    ends = ends_of(machine)
    sums, (across, capacitors) = no_sums(k, len(asked), ends), ends
    places = list(dict.fromkeys((a.measure.moves, p.frequency) for a in asked for p in a.parts))
    read = _Read(spectrum, ends, sums, 1 + 4 * len(places))
    rows: list[F64] = []
    moved: list[F64] = []
    for moves, frequency in places:
        u = spectrum.at(moves, frequency)
        steps = [_step(k, along) for along in (u.real, u.imag)]
        solved = np.zeros((len(asked), k.columns), dtype=complex)  # 0 at what sources fix
        for m, each in enumerate(asked):
            if each.measure.moves == moves:
                parts = [part for part in each.parts if part.frequency == frequency]
                solved[m, : k.unknowns] = _backwards(spectrum, frequency, parts)
                for part in parts:
                    read.add(m, part, u, len(rows), steps)
        sums.charge[:] += 2.0 * np.pi * frequency * (_apart(solved, capacitors) * _apart(u, capacitors)).imag
        sums.conductance[:] -= (_apart(solved, across) * _apart(u, across)).real
        for along, own, step in zip((u.real, u.imag), (solved.real, -solved.imag), steps, strict=True):
            rows += [v + step * along, v - step * along]
            moved += [own[:, : k.unknowns] / (2.0 * step), own[:, : k.unknowns] / (-2.0 * step)]
    voltage = np.array([*rows, v])
    every, slopes = np.zeros((len(asked), len(voltage), k.unknowns)), read.slopes(voltage, len(asked))
    if moved:
        every[:, :-1] = np.stack(moved, axis=1)
    _end(machine, voltage, every, slopes[:, :, : k.unknowns].sum(axis=1))
    sums.conductance[:] -= _apart(_over(every[:, -1], k), across) * _apart(v, across)
    add_rows(k, voltage, every, sums)
    given = slopes[:, :, k.unknowns : k.columns - 1]
    return Adjoint(voltage, every, sums, taps=tuple(read.taps()), given=given)


class _Read:
    """What measures read of currents, at the rows of an adjoint run.

    weights : float64[rows] of a measure and a current.
    """

    def __init__(self, spectrum: Spectrum, ends: Ends, sums: Sums, rows: int) -> None:
        self.spectrum, self.ends, self.sums, self.rows = spectrum, ends, sums, rows
        self.weights: dict[tuple[int, str], F64] = {}

    def add(self, m: int, part: Part, u: C128, row: int, steps: Sequence[float]) -> None:
        """Add a part of measure m, whose voltages u have four rows from `row` on, two a step."""
        if isinstance(part.probe, int):
            return
        weight, flow = part.weight, self.spectrum.drawn(part.probe).flow
        own = self.weights.setdefault((m, part.probe), np.zeros(self.rows))
        for at, by, step in zip((row, row + 2), (weight.real, -weight.imag), steps, strict=True):
            own[at] += by / (2.0 * step)
            own[at + 1] -= by / (2.0 * step)
        drops, charged = (weight * _apart(u, pairs) for pairs in self.ends)
        self.sums.conductance[m] += flow.resistors * drops.real
        self.sums.charge[m] -= 2.0 * np.pi * part.frequency * flow.pairs * charged.imag

    def slopes(self, voltage: F64, measures: int) -> F64:
        """Add what devices do to the sums; returns the slopes by voltages, float64[measures, rows, columns].

        voltage: of the rows, float64[rows, columns], V.
        """
        kernel = self.spectrum.point.machine.kernel
        found = np.zeros((measures, *voltage.shape))
        for (m, name), own in self.weights.items():
            gather(kernel, voltage, own, self.spectrum.drawn(name).flow, m, found[m], self.sums)
        return found

    def taps(self) -> Iterator[tuple[int, Tap]]:
        """What is read, as an adjoint run has it."""
        none = np.zeros(self.rows)
        for (m, name), own in self.weights.items():
            yield m, Tap(name, own, none, none)


def _rows_by_moves(machine: Machine, found: Adjoint, moves: Sequence[Move]) -> list[Rows]:
    """What parameters of a testbench move measures by, as of a run, by what its sources give at rest."""
    rows = []
    for move in moves:
        lines = list(zip(machine.polylines, move.more, move.less, strict=True))
        if all(own[0].size == more[0].size == less[0].size for own, more, less in lines):
            by = np.array([_at_rest(*line) for line in lines]) / move.step.size
            by[[k for k, direct in enumerate(machine.direct) if direct is not None]] = 0.0
            rows.append(
                Rows([move.step.label], move.step.unit, np.zeros(1), _by_sources(machine, found, by)[:, None])
            )
    return rows


def _at_rest(own: Polyline, more: Polyline, less: Polyline) -> float:
    """What a step moves the value of a source at rest by; where it bends there, what a later one does."""
    here, above, below = (float(np.interp(0.0, *line)) for line in (own, more, less))
    middle = 0.5 * (above - below)
    return middle if abs(above - here - middle) <= BEND * abs(middle) else above - here


def _by_sources(machine: Machine, found: Adjoint, by: F64) -> F64:
    """What sources whose values move by `by` move the measures by, float64[measures]."""
    k = machine.kernel
    if not by.any():
        return np.zeros(found.moved.shape[0])
    slopes = sloped(k, found.voltage, found.moved)[:, k.unknowns : k.columns - 1]
    return np.asarray((slopes + found.given.sum(axis=1)) @ by)


def _backwards(spectrum: Spectrum, frequency: float, parts: Sequence[Part]) -> C128:
    """Solution of the transposed equations for what is read at a frequency, complex128[unknowns]."""
    weights = np.zeros(spectrum.point.machine.kernel.unknowns, dtype=complex)
    for part in parts:
        if not isinstance(part.probe, int):
            weights += part.weight * spectrum.drawn(part.probe).at(frequency)[: weights.size]
        elif part.probe < weights.size:
            weights[part.probe] += part.weight
    return spectrum.backwards(frequency, weights) if weights.any() else weights


def _apart(values: NDArray[T], pairs: I64) -> NDArray[T]:
    """Differences across pairs of columns."""
    found: NDArray[T] = np.subtract(values[..., pairs[0]], values[..., pairs[1]])
    return found


def _over(moved: F64, k: Kernel) -> F64:
    """Multipliers over all columns, 0 at those that sources fix."""
    return np.concatenate([moved, np.zeros((moved.shape[0], k.columns - k.unknowns))], axis=1)


def _step(k: Kernel, along: F64) -> float:
    """How far to go along u so that no law bends."""
    t, d, a = (x.astype(np.int64) for x in (k.transistors.terminal, k.diodes.terminal, k.amplifier_terminal))
    ends = np.abs(along[np.concatenate([t.ravel(), d.ravel()])]).max(initial=0.0)
    inputs = np.abs(along[a[0]] - along[a[1]]) * k.amplifier_value[0]
    supplies = np.abs(along[a[3:5].ravel()]).max(initial=0.0)
    bent = max(float(ends) / _LAW, float(inputs.max(initial=0.0)), float(supplies))
    most = float(np.abs(along[k.charges : k.columns]).max(initial=0.0))
    if most == 0.0:
        return 1.0
    return min(BEND / bent, _FAR / most) if bent > 0.0 else _FAR / most


_LAW = 0.05  # V, over which a transistor or a diode bends, 2 U_T


def _end(machine: Machine, voltage: F64, moved: F64, right: F64) -> None:
    """Fill in the last row, the operating point's, from the others; right: slopes of what is read there."""
    k, w = machine.kernel, allocate(machine.kernel)
    matrix = np.zeros((k.unknowns, k.unknowns))
    _bend(k, voltage, moved, w, right)
    linearised(k, voltage[-1], w, matrix)
    scale = np.maximum(np.abs(matrix).max(axis=1, initial=0.0), 1e-300)
    try:
        moved[:, -1] = (np.linalg.solve((matrix / scale[:, None]).T, right.T) / scale[:, None]).T
    except np.linalg.LinAlgError:
        raise SolverError(
            f"{machine.testbench.title}: singular at its operating point; look for a node that floats"
        ) from None


@compiled()
def _bend(k: Kernel, voltage: F64, moved: F64, w: Work, out: F64) -> None:
    """Add `- sum J(v_r)^T m_r` over the rows but the last; of devices that bend alone, others cancel."""
    f, jacobian = k.factor, w.jacobian
    for p in range(w.base.size):
        w.base[p] = 0.0
    for row in range(voltage.shape[0] - 1):
        evaluate(k, voltage[row], w)
        fill_jacobian(k, w)
        for m in range(moved.shape[0]):
            own = moved[m, row]
            for i in range(k.unknowns):
                out[m, i] -= jacobian[f.diagonal[i]] * own[i]
                for p in range(f.lower_start[i], f.lower_start[i + 1]):
                    out[m, i] -= jacobian[f.lower[p]] * own[f.lower_row[p]]
                for p in range(f.upper_start[i], f.upper_start[i + 1]):
                    out[m, f.upper_column[p]] -= jacobian[f.upper[p]] * own[i]
