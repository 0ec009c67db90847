"""What can be measured of a run and differentiated: its value, and its slopes by the voltages of the run.

A measure reads the parabola through the last points of the step that it falls into, as the solver does for
spikes. Its slopes are those of that parabola, so that they belong to the value that is told.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, final

import numpy as np

from circuits.arrays import F64, I64
from circuits.lowering.kernel import on_die
from circuits.lowering.supply import spike_levels
from circuits.silicon.die import Die
from circuits.solver.adjoint.way import Way
from circuits.solver.transient import Result

_STEP = 1e-6  # V and us, by which a measured number's slopes are found; ours
_SMALL = 1e-6  # V, of a swing that has no edge; ours
_FAST = 0.01  # of an integral's time, within which its edge is over; ours
_BISECTIONS = 60
MOST_POINTS = 64  # pieces of a waveform, above which a number is one of the whole run; ours


Slopes = tuple[tuple[int, int, float], ...]  # (row, column, slope) each


class Reading(NamedTuple):
    """A measure of a run.

    value : its value in SI units, NaN where it is not defined.
    slopes : its derivative by voltages: (row, column, slope) each, in its unit a V.
    note : why it has no value, or where it is not smooth; empty else.
    check : of an extreme, the slopes of what its two neighbours differ by, who should agree on it.
    moves : of an extreme, the slopes of what the edge before it moves its neighbours by; of an integral, of
        what its last fast edge alone moves it by.
    """

    value: float
    slopes: Slopes
    note: str = ""
    check: Slopes = ()
    moves: Slopes = ()


class Measure(ABC):
    """A number that a run is measured by."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Its name, as `spike_time(spike,0)`."""

    @property
    @abstractmethod
    def unit(self) -> str:
        """Its SI unit."""

    @abstractmethod
    def read(self, result: Result, way: Way) -> Reading:
        """Read it from a run and its way."""


@final
@dataclass(frozen=True, slots=True)
class SpikeTime(Measure):
    """Time at which a watched port rises through its threshold, s.

    Attributes
    ----------
    port : str
        Label of the port, as `spike` or `line[4]`.
    number : int
        Which of its spikes, from 0.
    """

    port: str
    number: int = 0

    unit = "s"

    @property
    def name(self) -> str:
        """Its name."""
        return f"spike_time({self.port},{self.number})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the time of the spike, and how near its peak comes to the threshold."""
        machine = result.machine
        labels = [machine.names[n] for w in machine.testbench.watch for n in machine.flat.port_nodes(w)]
        times = result.spikes.get(self.port, np.zeros(0))
        column = machine.column_of(self.port)
        level = float(spike_levels(machine)[0, labels.index(self.port)]) if self.port in labels else np.nan
        if self.number >= times.size:
            peak = float(way.voltage[:, column].max())
            why = f"{times.size} spikes; {self.port} comes to {peak:.4g} V, the threshold is {level:.4g} V"
            return Reading(np.nan, (), why)
        return _crossing(way, column, float(times[self.number]))


@final
@dataclass(frozen=True, slots=True)
class Crossing(Measure):
    """Time at which a node passes a voltage, s.

    Attributes
    ----------
    node : str
        Path of the node.
    level : float
        The voltage, V.
    rising : bool
        Whether it rises through it, or falls.
    number : int
        Which of the crossings in that direction, from 0.
    """

    node: str
    level: float
    rising: bool = True
    number: int = 0

    unit = "s"

    @property
    def name(self) -> str:
        """Its name."""
        return f"{'rise' if self.rising else 'fall'}({self.node},{self.level:g}V,{self.number})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the time of the crossing."""
        column = result.machine.column_of(self.node)
        y = (way.voltage[:, column] - self.level) * (1.0 if self.rising else -1.0)
        rows = np.flatnonzero((y[1:] >= 0.0) & (y[:-1] < 0.0)) + 1
        if self.number >= rows.size:
            return Reading(np.nan, (), f"{rows.size} crossings; the nearest is {np.abs(y).min():.3g} V off")
        return _passed(way, int(rows[self.number]), column, self.level)


@final
@dataclass(frozen=True, slots=True)
class Voltage(Measure):
    """Voltage of a node, V, at a time or in the state in which a run begins.

    Attributes
    ----------
    node : str
        Path of the node.
    at : float or None
        Time, s; None for the beginning, which is the operating point unless the testbench says otherwise.
    """

    node: str
    at: float | None = None

    unit = "V"

    @property
    def name(self) -> str:
        """Its name."""
        return f"voltage({self.node}{'' if self.at is None else f',{self.at:g}s'})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the voltage."""
        column = result.machine.column_of(self.node)
        if self.at is None:
            return Reading(float(way.voltage[0, column]), ((0, column, 1.0),))
        if not 0.0 <= self.at <= way.time[-1]:
            return Reading(np.nan, (), f"{self.at:g} s, the run ends at {way.time[-1]:g} s")
        row = max(int(np.searchsorted(way.time, self.at)), 1)
        return Reading(_at(way, row, column, self.at), _slopes(way, row, column, self.at, 1.0))


@final
@dataclass(frozen=True, slots=True)
class Extreme(Measure):
    """Highest or lowest voltage of a node between two times, V.

    Attributes
    ----------
    node : str
        Path of the node.
    highest : bool
        Whether it is the highest.
    begin, end : float
        The times, s.
    """

    node: str
    highest: bool = True
    begin: float = 0.0
    end: float = np.inf

    unit = "V"

    @property
    def name(self) -> str:
        """Its name."""
        return f"{'maximum' if self.highest else 'minimum'}({self.node})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the extreme at its step, and name another one that is nearly as high."""
        column, sign = result.machine.column_of(self.node), 1.0 if self.highest else -1.0
        rows = np.flatnonzero((way.time >= self.begin) & (way.time <= self.end))
        if not rows.size:
            return Reading(np.nan, (), "no step between these times")
        y = sign * way.voltage[rows, column]
        best = int(np.argmax(y))
        peaks = (np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] > y[2:])) + 1).tolist()
        far = [p for p in peaks if y[min(p, best) : max(p, best) + 1].min() < y[p] - 1e-9 and p != best]
        other = max((float(y[p]) for p in far), default=-np.inf)
        gap = float(y[best]) - other
        near = gap < _TIE
        note = f"a tie: another extreme is {gap:.3g} V from it" if near else ""
        return top_of(way, int(rows[best]), column, note)


_TIE = 1e-3  # V, within which two extremes are one as far as a designer is concerned; ours


@final
@dataclass(frozen=True, slots=True)
class Integral(Measure):
    """Integral of a node's voltage between two times, V s.

    Attributes
    ----------
    node : str
        Path of the node.
    begin, end : float
        The times, s; the end is that of the run unless given.
    """

    node: str
    begin: float = 0.0
    end: float = np.inf

    unit = "V s"

    @property
    def name(self) -> str:
        """Its name."""
        return f"integral({self.node})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the integral of straight lines between the steps."""
        column, end = result.machine.column_of(self.node), min(self.end, float(way.time[-1]))
        if not self.begin < end:
            return Reading(np.nan, (), f"{self.begin:g} s to {end:g} s, must be rising times of the run")
        left, right = np.clip(way.time[:-1], self.begin, end), np.clip(way.time[1:], self.begin, end)
        h = np.diff(way.time)
        later = (0.5 * (left + right) - way.time[:-1]) / h * (right - left)
        weight = np.zeros(way.time.size)
        weight[1:] += later
        weight[:-1] += (right - left) - later
        rows = np.flatnonzero(weight)
        value = float(weight @ way.voltage[:, column])
        slopes = tuple((int(r), column, float(weight[r])) for r in rows)
        return Reading(value, slopes, moves=_last_edge(way, rows, column))


@final
@dataclass(frozen=True, slots=True)
class Measured(Measure):
    """A number that a function takes from a run, as those that a block's testbench measures.

    Its slopes are found by moving the run's spikes and voltages, of which a number of the kind reads few. A
    number that depends on the devices beside them, as a current does, has other slopes too, which are not
    known here: it has none.

    Attributes
    ----------
    label : str
        Its name.
    of : callable
        Takes a `Result`, and gives the number, or None where it is not defined.
    si : str
        Its SI unit.
    """

    label: str
    of: Callable[[Result], float | None]
    si: str = ""

    @property
    def name(self) -> str:
        """Its name."""
        return self.label

    @property
    def unit(self) -> str:
        """Its unit."""
        return self.si

    def read(self, result: Result, way: Way) -> Reading:
        """Read the number, and find what of the run it depends on."""
        value = self.of(result)
        if value is None or not np.isfinite(value):
            return Reading(np.nan, (), "not defined in this run")
        if self.of(elsewhere(result)) != value:
            return Reading(
                float(value),
                (),
                "reads devices beside the run's voltages, as a current does; ask dies instead",
            )
        return _Search(self, result, way, float(value)).reading()


def elsewhere(result: Result) -> Result:
    """The voltages of a run as if another die had made them, and a warmer one."""
    machine = result.machine
    silicon, die = machine.silicon, machine.silicon.die
    warm = replace(silicon, temperature_c=silicon.temperature_c + 1.0)
    other = Die(number=1 + (die.number or 0), variation=die.variation)
    return replace(result, machine=on_die(replace(machine, silicon=warm), other))


class _Search:
    """Looks for the spikes and voltages of a run that a number depends on."""

    def __init__(self, measure: Measured, result: Result, way: Way, value: float) -> None:
        self.measure, self.result, self.way, self.value = measure, result, way, value
        self.kept = np.concatenate([[0], np.flatnonzero(np.diff(result.time) > 0.0) + 1])
        self.found: dict[tuple[int, int], float] = {}

    def reading(self) -> Reading:
        """The number with its slopes."""
        for port, times in self.result.spikes.items():
            column = self.result.machine.column_of(port)
            for k, time in enumerate(times):
                slope = self._by_spike(port, k)
                for row, c, by in _crossing(self.way, column, float(time)).slopes if slope else ():
                    self.found[row, c] = self.found.get((row, c), 0.0) + slope * by
        sign = np.random.default_rng(0).choice([-1.0, 1.0], self.result.voltage.shape[0])  # of no consequence
        for node in range(len(self.result.nodes)):
            pending = [(0, self.result.voltage.shape[0])]
            while pending:
                low, high = pending.pop(0)
                if self._moved(node, slice(low, high), sign[low:high]) == self.value:
                    continue
                if len(pending) + len(self.found) > MOST_POINTS:
                    return Reading(self.value, (), "depends on the whole run, must be of few points of it")
                if high - low == 1:
                    self._note(node, low)
                else:
                    middle = (low + high) // 2
                    pending += [(low, middle), (middle, high)]
        if self._reads_times(sign):
            why = (
                "reads the time of a step, which no voltage there moves, as that of a peak; ask dies instead"
            )
            return Reading(self.value, (), why)
        return self._told()

    def _reads_times(self, sign: F64) -> bool:
        """Whether it depends on the time of a sample of whose voltages it does not: of the solver's steps."""
        known, time = {row for row, _ in self.found}, self.result.time
        step = 1e-3 * float(np.diff(time[self.kept]).min(initial=np.inf))
        pending = [(1, time.size - 1)]  # the ends are those of the testbench
        while pending:
            low, high = pending.pop(0)
            moved = time.copy()
            moved[low:high] += step * sign[low:high]
            if self._value(self._with(time=moved)) == self.value:
                continue
            if high - low > 1:
                middle = (low + high) // 2
                pending += [(low, middle), (middle, high)]
            elif int(np.searchsorted(self.kept, low)) not in known:
                return True
        return False

    def _told(self) -> Reading:
        """What was found; a lone extreme is read as one."""
        slopes: list[tuple[int, int, float]] = []
        check: list[tuple[int, int, float]] = []
        moves: list[tuple[int, int, float]] = []
        for (row, column), by in self.found.items():
            if {(row - 1, column), (row + 1, column)} & set(self.found):
                slopes.append((row, column, by))
                continue
            top = top_of(self.way, row, column)
            slopes += [(r, c, by * w) for r, c, w in top.slopes]
            check += [(r, c, by * w) for r, c, w in top.check]
            moves += [(r, c, by * w) for r, c, w in top.moves]
        return Reading(self.value, tuple(slopes), "", tuple(check), tuple(moves))

    def _note(self, node: int, sample: int) -> None:
        one = slice(sample, sample + 1)
        up, down = (self._moved(node, one, np.array([s])) for s in (1.0, -1.0))
        row = int(np.searchsorted(self.kept, sample))
        column = self.result.machine.column_of(self.result.nodes[node])
        self.found[row, column] = self.found.get((row, column), 0.0) + (up - down) / (2.0 * _STEP)

    def _by_spike(self, port: str, k: int) -> float:
        step = 1e-6 * _STEP
        ends = []
        for sign in (1.0, -1.0):
            times = self.result.spikes[port].copy()
            times[k] += sign * step
            ends.append(self._value(self._with(spikes={**self.result.spikes, port: times})))
        return (ends[0] - ends[1]) / (2.0 * step)

    def _moved(self, node: int, rows: slice, sign: F64) -> float:
        voltage = self.result.voltage.copy()
        voltage[rows, node] += _STEP * sign
        return self._value(self._with(voltage=voltage))

    def _value(self, result: Result) -> float:
        found = self.measure.of(result)
        return np.nan if found is None else float(found)

    def _with(self, **changed: object) -> Result:
        own = {f: getattr(self.result, f) for f in Result.__dataclass_fields__}
        return Result(**{**own, **changed})


def _last_edge(way: Way, rows: I64, column: int) -> Slopes:
    """What the last fast edge of a column within some rows moves the integral over these by; none without."""
    y = way.voltage[rows, column]
    swing, level = float(np.ptp(y)), 0.5 * float(y.max() + y.min())
    passed = np.flatnonzero((y[1:] > level) != (y[:-1] > level)) + 1
    if swing < _SMALL or not passed.size:
        return ()
    row = int(rows[passed[-1]])
    step = way.time[row] - way.time[row - 1]
    rate = float(np.abs(way.voltage[row, column] - way.voltage[row - 1, column]) / step)
    if swing > _FAST * rate * float(way.time[rows[-1]] - way.time[rows[0]]):
        return ()
    return tuple((r, c, swing * by) for r, c, by in _passed(way, row, column, level).slopes)


def top_of(way: Way, row: int, column: int, note: str = "") -> Reading:
    """An extreme at a row, in the frame that moves with the edge before it.

    At an extreme a shift in time does nothing. What is left of the slope at the row is taken out, times what
    the edge moves by. Where edges are too fast for that, its neighbours do not agree on what is left.
    """
    value, alone = float(way.voltage[row, column]), ((row, column, 1.0),)
    edge = _edge_before(way, row, column)
    if edge is None:
        return Reading(value, alone, note)
    before, own, after = (moving(way, k, column, edge) for k in (row - 1, row, row + 1))
    near = slice(row - 1, row + 2)
    steepest = float(np.abs(np.diff(way.voltage[near, column]) / np.diff(way.time[near])).max())
    moves = tuple((r, c, steepest * by) for r, c, by in edge.slopes)
    return Reading(value, own, note, (*after, *((r, c, -by) for r, c, by in before)), moves)


def _edge_before(way: Way, row: int, column: int) -> Reading | None:
    """When the edge before an extreme passes its middle; None where there is no edge, or no extreme."""
    if not 1 < row < way.time.size - 2:
        return None
    y = way.voltage[row - 1 : row + 2, column]
    sign = 1.0 if y[1] > y[0] else -1.0
    before, top = sign * way.voltage[:row, column], sign * float(y[1])
    low = float(before.min())
    under = np.flatnonzero(before < 0.5 * (low + top))
    if sign * (y[1] - y[2]) < 0.0 or top - low < _SMALL or not under.size:
        return None
    return _passed(way, int(under[-1]) + 1, column, sign * 0.5 * (low + top))


def moving(way: Way, row: int, column: int, edge: Reading) -> Slopes:
    """Slopes of the voltage at a row that moves with an edge, whose time was read."""
    t, y = way.time[row - 1 : row + 2], way.voltage[row - 1 : row + 2, column]
    first, second = (y[1] - y[0]) / (t[1] - t[0]), (y[2] - y[1]) / (t[2] - t[1])
    rate = float((first * (t[2] - t[1]) + second * (t[1] - t[0])) / (t[2] - t[0]))
    return ((row, column, 1.0), *((r, c, rate * by) for r, c, by in edge.slopes))


def _passed(way: Way, row: int, column: int, level: float) -> Reading:
    """Time at which a column passes a level within a step, s."""
    low, high = way.time[row - 1], way.time[row]
    falls = way.voltage[row, column] < way.voltage[row - 1, column]
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        before = (_at(way, row, column, middle) > level) == falls
        low, high = (middle, high) if before else (low, middle)
    return _crossing(way, column, float(high), row)


def _nodes(way: Way, row: int) -> list[int]:
    """Rows of the points that the parabola of a step goes through."""
    return [row, row - 1] + ([row - 2] if way.order[row] == 2 else [])


def _weights(way: Way, row: int, time: float) -> tuple[list[int], F64, F64]:
    """Rows of a step's parabola, their weights at a time (s), and those of its slope, 1/s."""
    rows = _nodes(way, row)
    t = way.time[rows]
    own, slope = np.ones(len(rows)), np.zeros(len(rows))
    for i in range(len(rows)):
        others = [t[j] for j in range(len(rows)) if j != i]
        scale = np.prod([t[i] - s for s in others])
        own[i] = np.prod([time - s for s in others]) / scale
        slope[i] = (1.0 if len(others) == 1 else 2.0 * time - others[0] - others[1]) / scale
    return rows, own, slope


def _at(way: Way, row: int, column: int, time: float) -> float:
    rows, own, _ = _weights(way, row, time)
    return float(own @ way.voltage[rows, column])


def _slopes(way: Way, row: int, column: int, time: float, scale: float) -> Slopes:
    rows, own, _ = _weights(way, row, time)
    return tuple((r, column, scale * float(w)) for r, w in zip(rows, own, strict=True))


def _crossing(way: Way, column: int, time: float, row: int | None = None) -> Reading:
    """A time at which a column passes a level, in the step to a row: it moves by `-dv / slope`."""
    row = max(int(np.searchsorted(way.time, time - 1e-15)), 1) if row is None else row
    rows, _, slope = _weights(way, row, time)
    rate = float(slope @ way.voltage[rows, column])
    return Reading(time, _slopes(way, row, column, time, -1.0 / rate))
