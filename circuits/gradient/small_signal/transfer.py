"""What can be measured of small signals and differentiated: its value, and its slopes by transfers.

A measure M reads the transfers H from what moves to nodes, or to currents of devices and sources, at some
frequencies. What it reads of each is a weight c, with which

    dM = Re(sum of c dH)

A crossing of the frequency axis is solved for exactly, by no grid: where a function F(f, H) is 0, f moves by
`- dF / (dF/df)`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, final

import numpy as np

from circuits.arrays import C128, F64, Bools
from circuits.catalogue import later
from circuits.errors import ParameterError
from circuits.gradient.reading import uneven
from circuits.gradient.small_signal.spectrum import Moves, Probe, Spectrum
from circuits.measure.current import current_in
from circuits.solver.small_signal import source_column

optimise = later("scipy.optimize")

LOWEST, HIGHEST = 1.0, 1e9  # Hz, between which a crossing is looked for
PER_DECADE = 20  # as dense as an analysis of small signals
MOST_READ = 256  # transfers, above which a number is one of the whole spectrum; ours
_STEP = 1e-6  # relative, by which slopes of a number are found; ours
_DECIBELS = 20.0 / math.log(10.0)
_BELOW = math.sqrt(0.5)


class Part(NamedTuple):
    """What a measure reads: a transfer's frequency, Hz, to what it goes, and its weight."""

    frequency: float
    probe: Probe
    weight: complex


class Edge(NamedTuple):
    """Where a measure is not smooth: how far it is, in a unit of its own, what moves it there, and words."""

    margin: float
    parts: tuple[Part, ...]
    what: str


class Reading(NamedTuple):
    """A measure of small signals.

    value : its value in SI units, NaN where it is not defined.
    parts : what it reads of transfers.
    unit : its SI unit.
    note : why it has no value or no gradient; empty else.
    edges : where it is not smooth.
    scale : what moves it by as much as its transfers are large, in its unit.
    """

    value: float
    parts: tuple[Part, ...]
    unit: str
    note: str = ""
    edges: tuple[Edge, ...] = ()
    scale: float = 0.0


class SmallSignal(ABC):
    """A number that small signals about an operating point are measured by."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Its name, as `mag(v_out,v_plus,1000Hz)`."""

    @property
    @abstractmethod
    def moves(self) -> Moves:
        """What moves: names of sources, and by how much, V or A."""

    @abstractmethod
    def read(self, spectrum: Spectrum) -> Reading:
        """Read it from small signals."""


@final
@dataclass(frozen=True, slots=True)
class Transfer(SmallSignal):
    """Transfer from a source to a node or a current at a frequency: its size, in decibels, or its phase.

    Attributes
    ----------
    kind : str
        `mag`, `db` (20 log10 of the size) or `phase` (degrees, above -180 and up to 180).
    node : str
        Path of the node, or i(NAME).
    source : str
        Name of the source that moves.
    frequency : float
        Hz.
    """

    kind: Literal["mag", "db", "phase"]
    node: str
    source: str
    frequency: float

    @property
    def name(self) -> str:
        """Its name."""
        return f"{self.kind}({self.node},{self.source},{self.frequency:g}Hz)"

    @property
    def moves(self) -> Moves:
        """What moves."""
        return ((self.source, 1.0),)

    def read(self, spectrum: Spectrum) -> Reading:
        """Read the transfer; raises `ParameterError` for a frequency that is not above 0."""
        _check(self.name, self.frequency)
        probe = spectrum.probe(self.node)
        h = spectrum.read(self.moves, self.frequency, probe)
        unit = {"mag": _unit(spectrum, self.source, self.node), "db": "dB", "phase": "deg"}[self.kind]
        if h == 0.0:
            value, none = (0.0, "no gradient") if self.kind == "mag" else (np.nan, f"no {_NONE[self.kind]}")
            why = f"nothing of {self.source} comes to {self.node}: a transfer of 0 has {none}"
            return Reading(value, (), unit, why)
        if self.kind == "phase":
            return self._turned(h, probe)
        value, scale = (abs(h), abs(h)) if self.kind == "mag" else (_DECIBELS * math.log(abs(h)), _DECIBELS)
        return Reading(value, (Part(self.frequency, probe, scale / h),), unit, scale=scale)

    def _turned(self, h: complex, probe: Probe) -> Reading:
        """The phase, and how far it is from where it jumps."""
        value = math.degrees(math.atan2(h.imag, h.real))
        value = 180.0 if value == -180.0 else value
        scale = math.degrees(1.0)
        parts = (Part(self.frequency, probe, -1j * scale / h),)
        edge = Edge(180.0 - abs(value), parts, "it jumps by 360 deg")
        return Reading(value, parts, "deg", edges=(edge,), scale=scale)


_NONE = {"db": "decibels", "phase": "phase"}


@final
@dataclass(frozen=True, slots=True)
class Corner(SmallSignal):
    """Lowest frequency at which the size of a transfer has fallen to a level, Hz.

    Attributes
    ----------
    node : str
        Path of the node, or i(NAME).
    source : str
        Name of the source that moves.
    level : float or None
        The level, in the transfer's unit; None for 3 dB below what it is at the first frequency, 1 over the
        root of 2.
    low, high : float
        The frequencies between which it is looked for, Hz.
    """

    node: str
    source: str
    level: float | None = None
    low: float = LOWEST
    high: float = HIGHEST

    @property
    def name(self) -> str:
        """Its name."""
        usual = (self.low, self.high) == (LOWEST, HIGHEST)
        span = "" if usual else f",{self.low:g}Hz,{self.high:g}Hz"
        return f"{'bandwidth' if self.level is None else 'unity_gain'}({self.node},{self.source}{span})"

    @property
    def moves(self) -> Moves:
        """What moves."""
        return ((self.source, 1.0),)

    def read(self, spectrum: Spectrum) -> Reading:
        """Find the frequency; raises `ParameterError` unless the frequencies rise from above 0."""
        _check(self.name, self.low)
        if not self.low < self.high < np.inf:
            raise ParameterError(f"{self.name}: {self.low:g} to {self.high:g} Hz, must be rising frequencies")
        probe = spectrum.probe(self.node)
        count = 1 + math.ceil(PER_DECADE * math.log10(self.high / self.low))
        grid, sizes, level = np.geomspace(self.low, self.high, count), np.zeros(0), np.nan
        for begin in range(0, count, PER_DECADE):
            part = grid[begin : begin + PER_DECADE]
            sizes = np.append(sizes, np.abs(spectrum.transfers(self.moves, part, [probe])[:, 0]))
            level = float(sizes[0]) * _BELOW if self.level is None else self.level
            if (sizes <= level).any():  # of 0 too
                break
        why = self._missing(grid, sizes, level)
        if why:
            return Reading(np.nan, (), "Hz", why)
        k = int(np.argmax(sizes <= level))
        return self._found(spectrum, probe, level, grid[: k + 1], sizes[: k + 1])

    def _missing(self, grid: F64, sizes: F64, level: float) -> str:
        """Why there is no such frequency; empty where there is one."""
        if sizes[0] == 0.0:
            return f"nothing of {self.source} comes to {self.node} at {self.low:g} Hz"
        if sizes[0] <= level:
            return f"begins with {sizes[0]:.4g} at {self.low:g} Hz, which is not above {level:.4g}"
        if not (sizes <= level).any():
            least = int(np.argmin(sizes))
            return f"never falls to {level:.4g}; it is lowest at {grid[least]:.3g} Hz, {sizes[least]:.4g}"
        return ""

    def _found(self, spectrum: Spectrum, probe: Probe, level: float, grid: F64, sizes: F64) -> Reading:
        """The frequency between the last two of a grid; sizes: what the transfer has on it."""

        def over(log_frequency: float) -> float:
            found = spectrum.read(self.moves, math.exp(log_frequency), probe)
            return math.log(abs(found) / level)

        ends = np.log(grid[-2:])
        at = math.exp(optimise.brentq(over, *ends, xtol=1e-13, rtol=1e-14))
        h, along = (f(self.moves, at, probe) for f in (spectrum.read, spectrum.slope))
        slope = (along / h).real
        first = spectrum.read(self.moves, self.low, probe)
        start = () if self.level is not None else (Part(self.low, probe, 1.0 / first),)
        moved = tuple(p._replace(weight=p.weight / slope) for p in start)
        edges = []
        dips = np.flatnonzero((sizes[1:-1] < sizes[:-2]) & (sizes[1:-1] <= sizes[2:])) + 1
        if dips.size:
            low = float(grid[dips[np.argmin(sizes[dips])]])
            there = spectrum.read(self.moves, low, probe)
            parts = (Part(low, probe, 1.0 / there), *(p._replace(weight=-p.weight) for p in start))
            edges.append(Edge(math.log(abs(there) / level), parts, f"it jumps to {low:.3g} Hz"))
        parts = (Part(at, probe, -1.0 / (h * slope)), *moved)
        return Reading(at, parts, "Hz", edges=tuple(edges), scale=at)


Taken = tuple[float, str]  # a number in its unit, NaN where it is not defined, and the reason then


@final
@dataclass(frozen=True, slots=True)
class OfSpectrum(SmallSignal):
    """A number that a function takes from transfers on a grid of frequencies, as a deck's measures.

    Its slopes are found by moving the transfers one by one. The grid is part of such a measure: a crossing
    lies on the straight line between two of its points.

    Attributes
    ----------
    label : str
        Its name.
    moved : tuple of (str, complex)
        What moves: names of sources, and by how much, V or A.
    nodes : tuple of str
        Nodes and i(NAME) whose transfers it may read.
    frequency : tuple of float
        The grid, Hz.
    of : callable
        Takes frequencies, float64[F], Hz, and transfers by node, complex128[F], and gives the number.
    si : str
        Its SI unit.
    """

    label: str
    moved: Moves
    nodes: tuple[str, ...]
    frequency: tuple[float, ...] = field(repr=False)
    of: Callable[[F64, Mapping[str, C128]], Taken]
    si: str = ""

    @property
    def name(self) -> str:
        """Its name."""
        return self.label

    @property
    def moves(self) -> Moves:
        """What moves."""
        return self.moved

    def read(self, spectrum: Spectrum) -> Reading:
        """Read the number, and find what of the transfers it depends on."""
        probes = [spectrum.probe(node) for node in self.nodes]
        grid = np.array(self.frequency)
        transfer = spectrum.transfers(self.moved, grid, probes)
        value, why = self._value(grid, transfer)
        if not np.isfinite(value):
            return Reading(np.nan, (), self.si, why or "not defined at these frequencies")
        found = self._read_places(grid, transfer, value)
        if len(found) > MOST_READ:
            return Reading(value, (), self.si, "depends on the whole spectrum, must be of few points of it")
        if self._reads_grid(grid, transfer, value, {row for row, _ in found}):
            return Reading(
                value, (), self.si, "reads the frequency of a point, which nothing moves on a grid"
            )
        if not found:
            return Reading(value, (), self.si, "reads no transfer, as where it is an end of the grid")
        parts = tuple(
            Part(float(grid[row]), probes[node], self._weight(grid, transfer, (row, node)))
            for row, node in found
        )
        return Reading(value, parts, self.si, scale=abs(value))

    def _value(self, grid: F64, transfer: C128) -> Taken:
        return self.of(grid, dict(zip(self.nodes, np.ascontiguousarray(transfer.T), strict=True)))

    def _read_places(self, grid: F64, transfer: C128, value: float) -> list[tuple[int, int]]:
        """Rows and nodes of the transfers that the number depends on, found by halving."""
        turn = 1.0 + _STEP * (1.0 + 1j) * uneven(transfer.shape[0])
        found: list[tuple[int, int]] = []
        for node in range(len(self.nodes)):
            pending = [(0, transfer.shape[0])]
            while pending and len(found) <= MOST_READ:
                low, high = pending.pop(0)
                moved = transfer.copy()
                moved[low:high, node] *= turn[low:high]
                if self._value(grid, moved)[0] == value:
                    continue
                if high - low == 1:
                    found.append((low, node))
                else:
                    middle = (low + high) // 2
                    pending += [(low, middle), (middle, high)]
        return found

    def _reads_grid(self, grid: F64, transfer: C128, value: float, known: set[int]) -> bool:
        """Whether it depends on a frequency of the grid of which it reads no transfer; its ends are given."""
        free: Bools = np.array([0 < row < grid.size - 1 and row not in known for row in range(grid.size)])
        moved = grid * np.where(free, 1.0 + _STEP, 1.0)
        return self._value(moved, transfer)[0] != value

    def _weight(self, grid: F64, transfer: C128, place: tuple[int, int]) -> complex:
        """Slopes by the real and the imaginary part of a transfer, as one weight."""
        step, slopes = _STEP * abs(transfer[place]), []
        if step == 0.0:
            return 0.0
        for way in (1.0, 1j):
            ends = []
            for sign in (1.0, -1.0):
                moved = transfer.copy()
                moved[place] += sign * step * way
                ends.append(self._value(grid, moved)[0])
            slopes.append((ends[0] - ends[1]) / (2.0 * step))
        return complex(slopes[0], -slopes[1])


def _unit(spectrum: Spectrum, source: str, node: str) -> str:
    """Unit of a transfer: V/V and A/A have none, a voltage by a current Ohm, and the other way round S."""
    point = spectrum.point
    number = source_column(point, source) - point.machine.kernel.unknowns
    if point.machine.source_quantities[number] == "voltage":
        return "" if current_in(node) is None else "S"
    return "Ohm" if current_in(node) is None else ""


def _check(name: str, frequency: float) -> None:
    if not 0.0 < frequency < np.inf:
        raise ParameterError(f"{name}: {frequency:g} Hz, must be a frequency above 0; as 1kHz")
