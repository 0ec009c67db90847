"""Small signals about an operating point, from `(G + j 2 pi f C) v = -(G_s + j 2 pi f C_s) s`.

G are the devices' exact conductances at the point and C their capacitances, both with a row for every node
that no source fixes. One source moves by s; its column of the vector of voltages gives G_s and C_s. The
matrices are those of the transient's Jacobian, with the columns of the sources kept.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import C128, F64, I64
from circuits.catalogue import later
from circuits.devices.transistor import TransistorWork, drain_currents, transistor_work
from circuits.errors import ParameterError, SolverError, unknown_name
from circuits.lowering.kernel import Kernel, Rows
from circuits.solver.newton import Work, allocate, evaluate
from circuits.solver.operating_point import OperatingPoint

if TYPE_CHECKING:
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import SuperLU

linalg, sparse = later("scipy.sparse.linalg"), later("scipy.sparse")

MOST_POINTS = 100_000


@dataclass(frozen=True, slots=True)
class Linear:
    """A circuit linearised at an operating point: `G v + C dv/dt = i`.

    point: the operating point. conductance: G, [unknown nodes, all columns], S. charge: C, [unknown nodes,
    all columns], F.
    """

    point: OperatingPoint
    conductance: csc_array = field(repr=False)
    charge: csc_array = field(repr=False)

    def admittances(self, frequency: F64) -> Iterator[SuperLU]:
        """Yield the factored matrix `G + j 2 pi f C` at each frequency, [unknown nodes, unknown nodes], S.

        Parameters
        ----------
        frequency
            Frequencies, float64[F], Hz.

        Raises
        ------
        SolverError
            The matrix is singular at a frequency, as where a node floats.
        """
        n = self.conductance.shape[0]
        g, c = self.conductance[:, :n].astype(complex), self.charge[:, :n].astype(complex)
        for f in frequency.tolist():
            try:
                yield linalg.splu((g + 2j * np.pi * f * c).tocsc())
            except RuntimeError as error:
                title = self.point.machine.testbench.title
                raise SolverError(f"{title}: singular at {f:g} Hz; look for a node that floats") from error


@dataclass(frozen=True, slots=True)
class Response:
    """Transfer from a source to nodes over frequency.

    source: its name. unit: of the transfer: V/V from a source of voltage, V/A from one of
    current. nodes: paths of the nodes, in the order of `transfer`. frequency: frequencies, float64[F], Hz.
    transfer: transfer to each node, complex128[F, nodes], V/V or V/A.
    """

    source: str
    unit: str
    nodes: tuple[str, ...]
    frequency: F64
    transfer: C128 = field(repr=False)


def linearise(point: OperatingPoint) -> Linear:
    """Conductances and capacitances of a circuit at an operating point."""
    k = point.machine.kernel
    return Linear(point, _conductance(k, point.voltage), _matrix(k, *_entries(k.charge)))


def ac(point: OperatingPoint, source: str, frequency: F64, nodes: Sequence[str] | None = None) -> Response:
    """Transfer from a source to nodes over frequency.

    Parameters
    ----------
    point
        Operating point, whose machine names sources (a bias port's included) and nodes.
    source
        Which source moves; the others stay.
    frequency
        float64[F], Hz.
    nodes
        Node paths; all but ground unless given.

    Raises
    ------
    UnknownNameError
        No such source or node.
    SolverError
        The circuit has no answer at a frequency.
    """
    machine = point.machine
    k = machine.kernel
    moved = source_column(point, source)
    names = tuple(machine.names[1:] if nodes is None else nodes)
    columns = [machine.column_of(n) for n in names]
    linear = linearise(point)
    drive_g, drive_c = (m[:, [moved]].toarray()[:, 0] for m in (linear.conductance, linear.charge))
    full = np.zeros((frequency.size, k.columns), dtype=complex)
    for row, f, factors in zip(full, frequency, linear.admittances(frequency), strict=True):
        row[: k.unknowns] = factors.solve(-(drive_g + 2j * np.pi * f * drive_c))
    quantity = machine.source_quantities[moved - k.unknowns]
    if quantity == "voltage":
        full[:, moved] = 1.0
    return Response(source, "V/V" if quantity == "voltage" else "V/A", names, frequency, full[:, columns])


def source_column(point: OperatingPoint, source: str) -> int:
    """Position of a source in the vector of voltages; raises `UnknownNameError` where there is none."""
    machine = point.machine
    if source not in machine.source_names:
        raise unknown_name(f"{machine.testbench.title} source", source, machine.source_names)
    return machine.kernel.unknowns + machine.source_names.index(source)


def frequency_grid(low: float, high: float, per_decade: int) -> F64:
    """Frequencies from `low` to `high` (Hz) with equal ratios, both ends included, float64[F], Hz.

    Parameters
    ----------
    low, high
        The first and the last frequency, Hz.
    per_decade
        Number of frequencies in each decade, at least 1.

    Raises
    ------
    ParameterError
        The frequencies do not rise from above 0, or there are too few or too many of them.
    """
    if not 0.0 < low <= high < np.inf:
        raise ParameterError(f"frequency: {low:g} to {high:g} Hz, must rise from above 0; as 1 Hz to 1 MHz")
    if per_decade < 1:
        raise ParameterError(f"points: {per_decade} a decade, must be at least 1; 20 are usual")
    count = 1 + int(np.ceil(per_decade * np.log10(high / low) - 1e-9))
    if count > MOST_POINTS:
        raise ParameterError(f"points: {count} frequencies, must be at most {MOST_POINTS}; take fewer")
    grid = np.geomspace(low, high, count)
    return np.asarray(grid)


def transistors_at(point: OperatingPoint) -> TransistorWork:
    """Currents, conductances and channel states of all transistors at an operating point."""
    a = point.machine.kernel.transistors
    w = transistor_work(a.sign.size)
    drain_currents(a, point.voltage, w)
    return w


def _conductance(k: Kernel, v: F64) -> csc_array:
    """dI/dv at every unknown node by every column, S."""
    w = allocate(k)
    evaluate(k, v, w)
    t, g = k.transistors.terminal.astype(np.int64), w.transistor.conductance
    drain, gate, source, bulk = t
    parts = [_entries(k.conductance)]
    for row, sign in ((drain, 1.0), (source, -1.0)):
        for column, slope in ((drain, g[0]), (gate, g[1]), (source, g[2]), (bulk, -g.sum(axis=0))):
            parts.append((row, column, sign * slope))
    if k.transistors.leaks:
        own, by_gate = w.transistor.junction_conductance[:2], w.transistor.junction_conductance[2:]
        for end, a, b in zip((drain, source), own, by_gate, strict=True):
            for column, slope in ((end, a), (gate, b), (bulk, -a - b)):
                parts += [(end, column, slope), (bulk, column, -slope)]
    amplifier = k.amplifier_terminal.astype(np.int64)
    for i in (2, 3, 4):
        parts += [(amplifier[i], amplifier[j], w.amplifier_slope[i, j]) for j in range(5)]
    parts += _diode_parts(k, w)
    return _matrix(k, *(np.concatenate(part) for part in zip(*parts, strict=True)))


def _diode_parts(k: Kernel, w: Work) -> Iterator[tuple[I64, I64, F64]]:
    """Conductances of diodes, and what their charges follow by."""
    ends, own = k.diodes.terminal.astype(np.int64), k.diodes.charge.astype(np.int64)
    stores = own >= 0
    for column, sign in zip(ends, (1.0, -1.0), strict=True):
        for row, back in zip(ends, (1.0, -1.0), strict=True):
            yield row, column, sign * back * w.diode_slope[0]
        yield own[stores], column[stores], -sign * w.diode_slope[1, stores]


def _entries(rows: Rows) -> tuple[I64, I64, F64]:
    """Row, column and value of every entry."""
    index = np.repeat(np.arange(rows.start.size - 1), np.diff(rows.start))
    return index, rows.column.astype(np.int64), rows.value


def _matrix(k: Kernel, rows: I64, columns: I64, values: F64) -> csc_array:
    """Matrix of the rows that are unknown nodes."""
    keep = rows < k.unknowns
    return sparse.csc_array((values[keep], (rows[keep], columns[keep])), shape=(k.unknowns, k.columns))
