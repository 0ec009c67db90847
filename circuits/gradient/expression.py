"""Gradients of measures that are expressions: of what they read of waveforms, by the chain rule.

An expression F of readings x - an energy, an integral, a root mean square, an extreme, a value at a time, a
crossing, each of one waveform (`circuits.gradient.measure`) - moves by

    dF = sum over j of dF/dx_j dx_j

with dF/dx_j from the expression itself, as a central difference of the readings. So currents count too, and
the whole of a run. A reading may stand in another one: a crossing as an end of a window, a largest value as a
level. Then x_j moves by those before it too, an integral from t_i by Leibniz' rule:

    dx_j = (dx_j with its window and level held) + sum over i < j of dx_j/dx_i dx_i

with dx_j/dx_i from the reading itself, by what it was asked with (`circuits.gradient.reading`). An
expression that reads waveforms otherwise, as the largest value of a product, is a number of the run's
voltages (`circuits.gradient.measure.Measured`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, final

import numpy as np

from circuits.arrays import F64
from circuits.gradient.measure import (
    Crossing,
    Current,
    Energy,
    Extreme,
    Integral,
    Measure,
    Measured,
    Voltage,
    span_text,
)
from circuits.gradient.reading import Near, Reading
from circuits.gradient.tap import squared, unit_of
from circuits.gradient.way import Way
from circuits.measure.current import current_in
from circuits.measure.function import LAST, Arguments
from circuits.measure.grammar import parse
from circuits.measure.measure import Measure as Text
from circuits.measure.scope import Record, TransientRecord
from circuits.measure.signal import Direction, Signal, crossings
from circuits.solver.transient import Result

_STEP = 1e-6  # relative, of a reading; ours
_FINER = 1e-2  # of that, by which the end of a window is moved; ours
_WHOLE = 1e-6  # within which a window moves with what it stands at; ours


@final
@dataclass(frozen=True, slots=True)
class Expression(Measure):
    """A number of a run that an expression tells.

    Attributes
    ----------
    text : Measure
        The expression (`circuits.measure.measure`).
    """

    text: Text

    @property
    def name(self) -> str:
        """Its name."""
        return self.text.name

    @property
    def unit(self) -> str:
        """Its unit."""
        return self.text.unit

    def value(self, result: Result) -> tuple[float, str]:
        """Return the number alone."""
        found = self.text.of(TransientRecord(result))
        return (np.nan, found.reason) if found.reason else (found.value, "")

    def read(self, result: Result, way: Way) -> Reading:
        """Read the number, and what its readings depend on."""
        record = _Calls(TransientRecord(result))
        found = self.text.of(record)
        if found.reason:
            return Reading(np.nan, (), found.reason)
        parts = None if record.others else self._parts(record, found.value, result, way)
        if parts is None:
            plain = Measured(self.name, lambda other: self.text.of(TransientRecord(other)).value, self.unit)
            near = (each for measure in record.calls_of for each in measure.read(result, way).near)
            own = plain.read(result, way)
            return own._replace(near=(*own.near, *near))
        return _sum(parts, found.value, way)

    def _parts(
        self, record: _Calls, value: float, result: Result, way: Way
    ) -> list[tuple[float, Reading]] | None:
        """Slopes by what the expression reads, and readings; None where it reads others as one moves."""
        count, measures = len(record.calls), record.calls_of
        read = [measure.read(result, way) for measure in measures]
        near = [(k, each) for k, own in enumerate(read) for each in own.near]
        # what each moves by with those before it: the readings, and what is near them
        every = [*enumerate(read), *((k, each.reading) for k, each in near)]
        by, through = np.zeros(count), np.zeros((len(every), count))
        for number, (measure, own) in enumerate(record.calls):
            size = _STEP * max(abs(own), abs(value) * _STEP, 1e-30)
            more, less = self._moved(record, number, size)
            by[number] = (more.value - less.value) / (2.0 * size)
            if more.record.calls_of == less.record.calls_of == measures:
                continue
            if measure.unit == "s":
                size *= _FINER  # edges are short beside the time since the beginning
                more, less = self._moved(record, number, size)
            if not (_alike(more.record, record) and _alike(less.record, record)):
                return None
            ends = list(zip(more.record.calls_of, less.record.calls_of, strict=True))
            through[:, number] = [_through(each, *ends[k], 2.0 * size) for k, each in every]
        for later in range(count - 1, 0, -1):
            by += by[later] * through[later]
            through[count:] += through[count:, later, None] * through[later]
        if not np.isfinite(by).all():
            return None
        return list(zip(by.tolist(), _with_near(read, near, through[count:], way), strict=True))

    def _moved(self, record: _Calls, number: int, size: float) -> tuple[_Moved, _Moved]:
        """The expression with a call's value that far further and back."""
        value, ends = record.calls[number][1], []
        for own in (value + size, value - size):
            there = record.with_value(number, own)
            ends.append(_Moved(self.text.of(there).value, there))
        return ends[0], ends[1]


def _with_near(
    read: Sequence[Reading], near: Sequence[tuple[int, Near]], through: F64, way: Way
) -> list[Reading]:
    """Readings with what is near them, which moves with others too: `through`, float64[near, readings]."""
    plain = [own._replace(near=()) for own in read]
    own: list[tuple[Near, ...]] = [()] * len(plain)
    for (k, each), by in zip(near, through, strict=True):
        parts = [(1.0, each.reading), *zip(by.tolist(), plain, strict=True)]
        own[k] += (each._replace(reading=_sum([part for part in parts if part[0]], 0.0, way)),)
    return [found._replace(near=each) for found, each in zip(plain, own, strict=True)]


class _Moved(NamedTuple):
    """An expression's value where one of what it reads is another, and what was read."""

    value: float
    record: _Calls


def _alike(a: _Calls, b: _Calls) -> bool:
    """Whether the same is read, but for numbers: at other times, or by another level."""
    if len(a.calls) != len(b.calls):
        return False
    return all(_kind(one) == _kind(other) for one, other in zip(a.calls_of, b.calls_of, strict=True))


def _through(found: Reading, more: Measure, less: Measure, apart: float) -> float:
    """What a reading moves by with another one, which is so far apart at `more` and `less`."""
    total = 0.0
    for name, slope in found.own:
        ends = getattr(more, name), getattr(less, name)
        by = (ends[0] - ends[1]) / apart if ends[0] != ends[1] else 0.0
        # a time that goes with another goes all the way, without what is rounded
        total += slope * (round(by) if abs(by - round(by)) < _WHOLE else by)
    return total


def _kind(measure: Measure) -> tuple[Any, ...]:
    """What a measure is without its numbers."""
    own: Any = measure
    values = (getattr(own, each.name) for each in fields(own))
    return type(measure), *(value for value in values if not isinstance(value, float))


@final
@dataclass(frozen=True, slots=True)
class _RootMeanSquare(Measure):
    """Root of the mean square of a node's voltage, V, or of `i(NAME)`, A, between two times, s."""

    node: str
    begin: float
    end: float

    @property
    def name(self) -> str:
        """Its name."""
        return f"rms({self.node}{span_text(self.begin, self.end)})"

    @property
    def unit(self) -> str:
        """Its unit."""
        return unit_of(self.node)

    def read(self, result: Result, way: Way) -> Reading:
        """Read it; `d rms = d(integral of the square) / (2 rms T)`."""
        begin, end = self.begin, min(self.end, float(way.time[-1]))
        found = squared(result, way, self.node, (begin, end))
        value = float(np.sqrt(found.value / (end - begin)))
        if not value:
            return Reading(0.0, (), f"{self.name} is 0, from where it can but rise")
        by = 1.0 / (2.0 * value * (end - begin))
        ends = {"begin": value**2, "end": -(value**2)}
        own = tuple((name, by * (slope + ends[name])) for name, slope in found.own)
        return _sum([(by, found)], value, way)._replace(own=own)


class _Calls(Record):
    """A run of which is remembered what functions read of its waveforms.

    calls : each measure that a function is, and its value. others : functions that are none.
    """

    def __init__(self, record: TransientRecord, given: Mapping[int, float] | None = None) -> None:
        self.record, self.given = record, {} if given is None else given
        self.calls: list[tuple[Measure, float]] = []
        self.others: list[str] = []

    def with_value(self, number: int, value: float) -> _Calls:
        """The same with another value of a call, and those of the others as they are."""
        kept = {k: own for k, (_, own) in enumerate(self.calls)}
        return _Calls(self.record, {**kept, number: value})

    @property
    def calls_of(self) -> list[Measure]:
        """The measures of the calls."""
        return [measure for measure, _ in self.calls]

    @property
    def axis(self) -> F64:
        """Points of the run."""
        return self.record.axis

    def voltage(self, node: str) -> Signal:
        """Waveform of a node, V."""
        return self.record.voltage(node)

    def current(self, device: str) -> Signal:
        """Current of a device or source, A."""
        return self.record.current(device)

    def energy(self, source: str) -> Signal:
        """Energy that a source has delivered until each point, J."""
        return self.record.energy(source)

    def spikes(self, node: str) -> F64:
        """Times of the spikes at a watched node, s."""
        return self.record.spikes(node)

    def call(self, name: str, given: Arguments, found: Any) -> Any:
        """Remember a call, and give its value, or another that is asked for."""
        if isinstance(found, Signal) or not _reads(given):
            return found
        measure, scale = _measure(name, given, found)
        if measure is None:
            self.others.append(name)
            return found
        number = len(self.calls)
        own = self.given.get(number, float(found) / scale)
        self.calls.append((measure, own))
        return own * scale


def _reads(given: Arguments) -> bool:
    """Whether a function reads a waveform of the run; the number of spikes moves with nothing."""
    first = next(iter(given.values.values()))
    return isinstance(first, Signal) or "source" in given.values


def _measure(name: str, given: Arguments, found: Any) -> tuple[Measure | None, float]:
    """The measure that a function is, and by what its value is more; None where it is none."""
    low, high = given.window
    span = _span(given)
    if name == "energy":
        return Energy(str(given.values["source"]), *span), 1.0
    node = _node(given.label)
    if node is None or (given.values.keys() - _TAKEN.get(name, frozenset())):
        return None, 1.0
    if name == "cross":
        return _crossing(node, given, float(found)), 1.0
    return _of_node(name, node, given, span), 1.0 / (high - low) if name == "mean" else 1.0


_WINDOW = frozenset({"signal", "from", "to"})
_TAKEN: Mapping[str, frozenset[str]] = {
    **dict.fromkeys(("max", "min", "integral", "mean", "rms"), _WINDOW),
    "value": frozenset({"signal", "at"}),
    "cross": frozenset({"signal", "level", "direction", "n", "from", "to"}),
}
"""What functions that are measures may be given."""


def _span(given: Arguments) -> tuple[float, float]:
    """The window as measures have it: from 0, and to the end of the run, where it is the whole."""
    low, high = given.window
    first, last = float(given.record.axis[0]), float(given.record.axis[-1])
    return low if low > first else 0.0, high if high < last else np.inf


def _node(label: str) -> str | None:
    """The one node, or `i(NAME)`, that a text is; None of another."""
    tree: Any = parse(label).children[-1]
    names = [str(token) for token in tree.children if getattr(token, "type", "") in {"NODE", "NAME"}]
    if tree.data not in {"name", "voltage", "current"} or len(names) != 1:
        return None
    return f"i({names[0]})" if tree.data == "current" else names[0]


def _crossing(node: str, given: Arguments, place: float) -> Measure | None:
    """The crossing at a place, by its number in the whole run: how it was asked for moves nothing."""
    level, signal = float(given.values["level"]), given.signal
    directions: tuple[Direction, ...] = ("rise", "fall")
    for direction in directions:
        (at,) = np.nonzero(crossings(signal, level, direction, *signal.ends) == place)
        if at.size == 1:
            last = given.values.get("n") == LAST
            return Crossing(node, level, direction == "rise", int(at[0]), *_span(given), last)
    return None


def _of_node(name: str, node: str, given: Arguments, span: tuple[float, float]) -> Measure | None:
    """The measure that a function of one waveform is."""
    if name in {"max", "min"}:
        return Extreme(node, name == "max", *span)
    if name in {"integral", "mean"}:
        return Integral(node, *span)
    if name == "rms":
        return _RootMeanSquare(node, *span)
    at, current = float(given.values["at"]), current_in(node)
    return Voltage(node, at) if current is None else Current(current, at)


def _sum(parts: Sequence[tuple[float, Reading]], value: float, way: Way) -> Reading:
    """Weighted sum of readings as one; not of those without a value."""
    notes = dict.fromkeys(part.note for _, part in parts if part.note)
    if any(not np.isfinite(part.value) for _, part in parts):
        return Reading(value, (), "; ".join(notes))
    along = np.zeros(way.time.size)
    for by, part in parts:
        if part.along is not None:
            along += by * part.along
    return Reading(
        value,
        tuple((row, column, by * slope) for by, part in parts for row, column, slope in part.slopes),
        "; ".join(notes),
        tuple((row, by * slope) for by, part in parts for row, slope in part.timing),
        tuple(
            tap._replace(conducted=by * tap.conducted, rate=by * tap.rate, stored=by * tap.stored)
            for by, part in parts
            for tap in part.taps
        ),
        tuple((column, by * weight) for by, part in parts for column, weight in part.whole),
        along,
        near=tuple(near for _, part in parts for near in part.near),
    )
