"""What can be measured of a run and differentiated: its value, and its slopes by the voltages of the run.

Where a measure takes a node, `i(NAME)` is the current of a device or source (`circuits.measure.current`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError, unknown_name
from circuits.gradient.reading import (
    TIE,
    Near,
    Passage,
    Reading,
    crossing,
    nears_of,
    passed,
    read_at,
    top_of,
    uneven,
)
from circuits.gradient.tap import (
    Course,
    at_ends,
    at_rows,
    course_of,
    current_at,
    current_at_beginning,
    parts_between,
    through,
    unit_of,
)
from circuits.gradient.way import Way, way_of
from circuits.lowering.kernel import Machine, on_die
from circuits.lowering.supply import spike_levels
from circuits.measure.current import current_in
from circuits.silicon.die import Die
from circuits.solver.transient import Result

_STEP = 1e-6  # V and us, by which a measured number's slopes are found; ours
_EVEN, _SMALLER = 0.01, 5  # how even both ways are, and how often a step is made a tenth until then; ours
_NEAREST = 3  # events beside spikes that a number of a run is told of; ours
MOST_POINTS = 64  # pieces of a waveform, above which a number is one of the whole run; ours


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

    def value(self, result: Result) -> tuple[float, str]:
        """Return its value alone, NaN where it is not defined, and why."""
        found = self.read(result, way_of(result))
        return found.value, found.note


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
        """Read the time of the spike, and how near its peak comes to the threshold.

        Raises `ParameterError` for a node whose spikes are not watched.
        """
        machine = result.machine
        column, levels = machine.column_of(self.port), _levels(machine)
        if self.port not in levels:
            known = ", ".join(levels) or "none is"
            raise ParameterError(
                f"{self.name}: {self.port}, must be a port whose spikes are watched: {known};"
                f" rise({self.port},V,0) is of any node"
            )
        times, level = result.spikes.get(self.port, np.zeros(0)), levels[self.port]
        if self.number >= times.size:
            peak = float(way.voltage[:, column].max())
            why = f"{times.size} spikes; {self.port} comes to {peak:.4g} V, the threshold is {level:.4g} V"
            return Reading(np.nan, (), why)
        return _spike(machine, way, column, level, (self.number, float(times[self.number])))


def _levels(machine: Machine) -> dict[str, float]:
    """Threshold of each port whose spikes are watched, V, by its label."""
    labels = [machine.names[n] for w in machine.testbench.watch for n in machine.flat.port_nodes(w)]
    return dict(zip(labels, spike_levels(machine)[0].tolist(), strict=True))


def _spike(machine: Machine, way: Way, column: int, level: float, spike: tuple[int, float]) -> Reading:
    """Read a spike, of which the number and time are known, with what would bring or take it."""
    number, time = spike
    row = max(int(np.searchsorted(way.time, time)), 1)
    near = nears_of(
        Passage(way, column, level, 1.0, row, machine), f"spike {number}", "V from the threshold", arms=True
    )
    return crossing(way, column, time)._replace(near=near)


@final
@dataclass(frozen=True, slots=True)
class Crossing(Measure):
    """Time at which a node passes a voltage, or a current a level, s.

    Attributes
    ----------
    node : str
        Path of the node, or i(NAME).
    level : float
        The voltage, V, or the current, A.
    rising : bool
        Whether it rises through it, or falls.
    number : int
        Which of the crossings in that direction, from 0.
    begin, end : float
        Times between which it has to be, s, as far as it is told what comes near it.
    last : bool
        Whether it is counted from the end.
    """

    node: str
    level: float
    rising: bool = True
    number: int = 0
    begin: float = 0.0
    end: float = np.inf
    last: bool = False

    unit = "s"

    @property
    def name(self) -> str:
        """Its name."""
        level = f"{self.level:g}{unit_of(self.node)}"
        return f"{'rise' if self.rising else 'fall'}({self.node},{level},{self.number})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the time of the crossing."""
        course, sign = course_of(result, way, self.node), 1.0 if self.rising else -1.0
        y = (course.values - self.level) * sign
        rows = np.flatnonzero((y[1:] >= 0.0) & (y[:-1] < 0.0)) + 1
        if self.number >= rows.size:
            off = f"the nearest is {np.abs(y).min():.3g} {unit_of(self.node)} off"
            return Reading(np.nan, (), f"{rows.size} crossings; {off}")
        machine = result.machine if course.name is None else None
        passages = [
            Passage(course.way, course.column, self.level, sign, row, machine) for row in rows.tolist()
        ]
        found = self._passed(passages[self.number])
        own = nears_of(
            passages[self.number], f"crossing {self.number}", f"{unit_of(self.node)} from the level"
        )
        return course.told(found._replace(near=(*own, *self._near_ends(passages, found))))

    def _passed(self, passage: Passage) -> Reading:
        return passed(passage.way, passage.row, passage.column, self.level)

    def _near_ends(self, passages: Sequence[Passage], found: Reading) -> Iterator[Near]:
        """Crossings that come into the window, or leave it, both of which may move."""
        begins, ends = (found._replace(own=(*found.own, (end, -1.0))) for end in ("begin", "end"))
        if self.begin > 0.0:
            yield Near(begins, found.value - self.begin, "it leaves the window", "s after it begins")
        if self.end < np.inf:
            yield Near(ends, self.end - found.value, "it leaves the window", "s before it ends")
        beside = self.number + (1 if self.last else -1)
        if 0 <= beside < len(passages):
            other, what = self._passed(passages[beside]), "another crossing comes into the window"
            begins, ends = (other._replace(own=(*other.own, (end, -1.0))) for end in ("begin", "end"))
            if other.value < self.begin:
                yield Near(begins, self.begin - other.value, what, "s before it begins")
            elif other.value > self.end:
                yield Near(ends, other.value - self.end, what, "s after it ends")


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
        return read_at(way, row, column, self.at)


@final
@dataclass(frozen=True, slots=True)
class Extreme(Measure):
    """Highest or lowest voltage of a node, V, or current, A, between two times.

    Attributes
    ----------
    node : str
        Path of the node, or i(NAME).
    highest : bool
        Whether it is the highest.
    begin, end : float
        The times, s.
    rivals : bool
        Whether it is told how near another extreme comes.
    """

    node: str
    highest: bool = True
    begin: float = 0.0
    end: float = np.inf
    rivals: bool = True

    @property
    def unit(self) -> str:
        """Its unit."""
        return unit_of(self.node)

    @property
    def name(self) -> str:
        """Its name."""
        return f"{'maximum' if self.highest else 'minimum'}({self.node}{span_text(self.begin, self.end)})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the extreme at its step or at the ends, and name another one that is nearly as high."""
        course, sign = course_of(result, way, self.node), 1.0 if self.highest else -1.0
        rows = np.flatnonzero((way.time >= self.begin) & (way.time <= self.end))
        if not rows.size:
            return Reading(np.nan, (), "no step between these times")
        y = sign * course.values[rows]
        best = int(np.argmax(y))
        tie, least = (TIE, _SAME) if course.name is None else (TIE * abs(y[best]), _SAME * abs(y[best]))
        peaks = (np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] > y[2:])) + 1).tolist()
        far = [
            p
            for p in dict.fromkeys((0, *peaks, y.size - 1))
            if y[min(p, best) : max(p, best) + 1].min() < y[p] - least and p != best
        ]
        other = max(far, key=lambda p: float(y[p]), default=best)
        gap = float(y[best] - y[other]) if far else np.inf
        note = f"a tie: another extreme is {gap:.3g} {self.unit} from it" if gap < tie else ""
        found = self._highest(course, int(rows[best]))
        near = (
            (self._near(course, int(rows[best]), int(rows[other])),)
            if self.rivals and tie <= gap < np.inf
            else ()
        )
        return course.told(found._replace(note=note, near=near))

    def _highest(self, course: Course, row: int) -> Reading:
        """The extreme at its step, or at an end of the window that is beyond it."""
        way, sign, value = course.way, 1.0 if self.highest else -1.0, course.values[row]
        for name, end in (("begin", self.begin), ("end", self.end)):
            if way.time[0] < end < way.time[-1]:
                there = read_at(way, int(np.searchsorted(way.time, end)), course.column, end)
                if sign * there.value >= sign * value:
                    return there._replace(own=tuple((name, slope) for _, slope in there.own))
        return top_of(way, row, course.column)

    def _near(self, course: Course, row: int, other: int) -> Near:
        """How far another extreme is from it, in the frame of the steps."""
        apart = float(course.values[row] - course.values[other])
        slopes = (row, course.column, 1.0), (other, course.column, -1.0)
        what = f"another extreme is the {'highest' if self.highest else 'lowest'}"
        return Near(Reading(apart, slopes), abs(apart), what, f"{self.unit} from it")


_SAME = 1e-9  # V, or of a current, by which a waveform goes back between two extremes; ours


@final
@dataclass(frozen=True, slots=True)
class Integral(Measure):
    """Integral of a node's voltage, V s, or of a current, C, between two times.

    Attributes
    ----------
    node : str
        Path of the node, or i(NAME).
    begin, end : float
        The times, s; the end is that of the run unless given.
    """

    node: str
    begin: float = 0.0
    end: float = np.inf

    @property
    def unit(self) -> str:
        """Its unit."""
        return "V s" if current_in(self.node) is None else "C"

    @property
    def name(self) -> str:
        """Its name."""
        return f"integral({self.node}{span_text(self.begin, self.end)})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the integral of straight lines between the steps; what is stored counts at the ends."""
        begin, end = self.begin, min(self.end, float(way.time[-1]))
        if not begin < end:
            return Reading(np.nan, (), f"{begin:g} s to {end:g} s, must be rising times of the run")
        if (current := current_in(self.node)) is not None:
            return through(result.machine, way, current, (begin, end))
        column, part = result.machine.column_of(self.node), parts_between(way, begin, end)
        y, weight = way.voltage[:, column], at_rows(part.before, part.after)
        along = part.along(y[:-1], y[1:], np.zeros(part.share.size))
        own = at_ends(way, (begin, end), y[:-1], y[1:])
        return Reading(float(weight @ y), (), whole=((column, weight),), along=along, own=own)


@final
@dataclass(frozen=True, slots=True)
class Energy(Measure):
    """Energy that a source of voltage delivers between two times, J.

    Attributes
    ----------
    source : str
        Its name.
    begin, end : float
        The times, s; the end is that of the run unless given.
    """

    source: str
    begin: float = 0.0
    end: float = np.inf

    unit = "J"

    @property
    def name(self) -> str:
        """Its name."""
        return f"energy({self.source}{span_text(self.begin, self.end)})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the energy; raises `UnknownNameError` for what is no source of voltage."""
        machine = result.machine
        kinds = zip(machine.source_names, machine.source_quantities, strict=True)
        known = [name for name, kind in kinds if kind == "voltage"]
        if self.source not in known:
            raise unknown_name(f"{machine.flat.circuit.name} source of voltage", self.source, known)
        begin, end = self.begin, min(self.end, float(way.time[-1]))
        if not begin < end:
            return Reading(np.nan, (), f"{begin:g} s to {end:g} s, must be rising times of the run")
        column = machine.kernel.unknowns + machine.source_names.index(self.source)
        return through(machine, way, self.source, (begin, end), column)


@final
@dataclass(frozen=True, slots=True)
class Current(Measure):
    """Current of a device or source, A, at a time or in the state in which a run begins.

    Attributes
    ----------
    of : str
        Path of the device, or name of the source.
    at : float or None
        Time, s; None for the beginning, where no charge flows.
    """

    of: str
    at: float | None = None

    unit = "A"

    @property
    def name(self) -> str:
        """Its name."""
        return f"current({self.of}{'' if self.at is None else f',{self.at:g}s'})"

    def read(self, result: Result, way: Way) -> Reading:
        """Read the current."""
        if self.at is None:
            return current_at_beginning(result.machine, way, self.of)
        if not 0.0 <= self.at <= way.time[-1]:
            return Reading(np.nan, (), f"{self.at:g} s, the run ends at {way.time[-1]:g} s")
        return current_at(result.machine, way, self.of, self.at)


def span_text(begin: float, end: float) -> str:
    """Return the times between which something is measured, as its name tells them."""
    return "" if begin == 0.0 and end == np.inf else f",{begin:g}s,{end:g}s"


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

    def value(self, result: Result) -> tuple[float, str]:
        """Return the number alone."""
        value = self.of(result)
        defined = value is not None and np.isfinite(value)
        return (float(value), "") if defined and value is not None else (np.nan, "not defined in this run")

    def read(self, result: Result, way: Way) -> Reading:
        """Read the number, and find what of the run it depends on."""
        value, why = self.value(result)
        if why:
            return Reading(np.nan, (), why)
        if self.of(elsewhere(result)) != value:
            return Reading(
                value,
                (),
                "reads devices beside the run's voltages, as a current does; take current(NAME,TIME),"
                " integral(i(NAME)) or energy(SOURCE), or ask dies",
            )
        return _Search(self, result, way, value).reading()


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
        self.spikes: list[tuple[float, Reading]] = []

    def reading(self) -> Reading:
        """The number with its slopes."""
        machine = self.result.machine
        levels = _levels(machine)
        for port, times in self.result.spikes.items():
            column = machine.column_of(port)
            for k, time in enumerate(times.tolist()):
                slope = self._by_spike(port, k)
                if slope:
                    found = _spike(machine, self.way, column, levels[port], (k, time))
                    self.spikes.append((slope, found))
        sign = uneven(self.result.voltage.shape[0])
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
        parts, rows = list(self.spikes), {row: self._by_time(row) for row, _ in self.found}
        for (row, column), by in self.found.items():
            if rows[row] or {(row - 1, column), (row + 1, column)} & set(self.found):
                parts.append((by, Reading(0.0, ((row, column, 1.0),))))
            else:
                parts.append((by, top_of(self.way, row, column)))
        slopes = tuple((row, column, by * slope) for by, own in parts for row, column, slope in own.slopes)
        timing = tuple((row, by * slope) for by, own in parts for row, slope in own.timing)
        return Reading(self.value, slopes, timing=(*timing, *rows.items()), near=self._nearest())

    def _nearest(self) -> tuple[Near, ...]:
        """What is nearest to change the spikes that it reads: few, since each costs a run backwards."""
        every = sorted(
            (near for _, spike in self.spikes for near in spike.near), key=lambda near: near.margin
        )
        return tuple({near.reading.slopes: near for near in reversed(every)}.values())[-_NEAREST:]

    def _by_time(self, row: int) -> float:
        """Slope by the time of a row; 0 at the ends, whose times are those of the testbench."""
        if not 0 < row < self.way.time.size - 1:
            return 0.0
        sample, ends = self.kept[row], []
        step = 1e-3 * float(np.diff(self.way.time[row - 1 : row + 2]).min())
        for sign in (1.0, -1.0):
            moved = self.result.time.copy()
            moved[sample] += sign * step
            ends.append(self._value(self._with(time=moved)))
        return (ends[0] - ends[1]) / (2.0 * step)

    def _note(self, node: int, sample: int) -> None:
        """Remember a sample's slope; an extreme takes the next sample for one that is raised above it."""
        one, step, smaller, rise, fall = slice(sample, sample + 1), 10.0 * _STEP, 0, 1.0, 0.0
        while abs(rise - fall) > _EVEN * max(abs(rise), abs(fall)) and smaller < _SMALLER:
            step, smaller = 0.1 * step, smaller + 1
            up, down = (self._moved(node, one, np.array([s]), step) for s in (1.0, -1.0))
            rise, fall = up - self.value, self.value - down
        row = int(np.searchsorted(self.kept, sample))
        column = self.result.machine.column_of(self.result.nodes[node])
        if rise + fall != 0.0:
            self.found[row, column] = self.found.get((row, column), 0.0) + (rise + fall) / (2.0 * step)

    def _by_spike(self, port: str, k: int) -> float:
        step = 1e-6 * _STEP
        ends = []
        for sign in (1.0, -1.0):
            times = self.result.spikes[port].copy()
            times[k] += sign * step
            ends.append(self._value(self._with(spikes={**self.result.spikes, port: times})))
        return (ends[0] - ends[1]) / (2.0 * step)

    def _moved(self, node: int, rows: slice, sign: F64, step: float = _STEP) -> float:
        voltage = self.result.voltage.copy()
        voltage[rows, node] += step * sign
        return self._value(self._with(voltage=voltage))

    def _value(self, result: Result) -> float:
        found = self.measure.of(result)
        return np.nan if found is None else float(found)

    def _with(self, **changed: object) -> Result:
        own = {f: getattr(self.result, f) for f in Result.__dataclass_fields__}
        return Result(**{**own, **changed})
