"""Gradients of measures that are expressions: of what they read of waveforms, by the chain rule.

An expression F of readings x - an energy, an integral, a root mean square, an extreme, a value at a time, a
crossing, each of one waveform (`circuits.gradient.measure`) - moves by

    dF = sum over j of dF/dx_j dx_j

with dF/dx_j from the expression itself, as a central difference of the readings. So currents count too, and
the whole of a run. An expression that reads waveforms otherwise, as the largest value of a product, is a
number of the run's voltages (`circuits.gradient.measure.Measured`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from circuits.arrays import F64
from circuits.gradient.measure import Crossing, Current, Energy, Extreme, Integral, Measure, Measured, Voltage
from circuits.gradient.reading import Reading
from circuits.gradient.tap import squared, unit_of
from circuits.gradient.way import Way
from circuits.measure.current import current_in
from circuits.measure.function import Arguments
from circuits.measure.grammar import parse
from circuits.measure.measure import Measure as Text
from circuits.measure.scope import Record, TransientRecord
from circuits.measure.signal import Signal
from circuits.solver.transient import Result

_STEP = 1e-6  # relative, of a reading; ours


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

    def read(self, result: Result, way: Way) -> Reading:
        """Read the number, and what its readings depend on."""
        record = _Calls(TransientRecord(result))
        found = self.text.of(record)
        if found.reason:
            return Reading(np.nan, (), found.reason)
        parts = None if record.others else self._parts(record, found.value)
        if parts is None:
            plain = Measured(self.name, lambda other: self.text.of(TransientRecord(other)).value, self.unit)
            return plain.read(result, way)
        return _sum([(by, each.read(result, way)) for each, by in parts], found.value, way)

    def _parts(self, record: _Calls, value: float) -> list[tuple[Measure, float]] | None:
        """What the expression reads, and its slope by each; None where a reading depends on another."""
        first, parts = list(record.calls), []
        for number, (measure, own) in enumerate(first):
            size, ends = _STEP * max(abs(own), abs(value) * _STEP, 1e-30), []
            for sign in (1.0, -1.0):
                moved = record.with_value(number, own + sign * size)
                ends.append(self.text.of(moved).value)
                if [each for each, _ in moved.calls] != [each for each, _ in first]:
                    return None
            parts.append((measure, (ends[0] - ends[1]) / (2.0 * size)))
        return parts


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
        return f"rms({self.node})"

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
        return _sum([(1.0 / (2.0 * value * (end - begin)), found)], value, way)


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
        measure, scale = _measure(name, given)
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


def _measure(name: str, given: Arguments) -> tuple[Measure | None, float]:
    """The measure that a function is, and by what its value is more; None where it is none."""
    low, high = given.window
    span = _span(given)
    if name == "energy":
        return Energy(str(given.values["source"]), *span), 1.0
    node = _node(given.label)
    if node is None or (given.values.keys() - _TAKEN.get(name, frozenset())):
        return None, 1.0
    return _of_node(name, node, given, span), 1.0 / (high - low) if name == "mean" else 1.0


_WINDOW = frozenset({"signal", "from", "to"})
_TAKEN: Mapping[str, frozenset[str]] = {
    **dict.fromkeys(("max", "min", "integral", "mean", "rms"), _WINDOW),
    "value": frozenset({"signal", "at"}),
    "cross": frozenset({"signal", "level", "direction", "n"}),
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


def _of_node(name: str, node: str, given: Arguments, span: tuple[float, float]) -> Measure | None:
    """The measure that a function of one waveform is."""
    if name in {"max", "min"}:
        return Extreme(node, name == "max", *span)
    if name in {"integral", "mean"}:
        return Integral(node, *span)
    if name == "rms":
        return _RootMeanSquare(node, *span)
    if name == "value":
        at, current = float(given.values["at"]), current_in(node)
        return Voltage(node, at) if current is None else Current(current, at)
    direction, number = given.values.get("direction"), given.values.get("n", 1.0)
    if direction not in {"rise", "fall"} or isinstance(number, str):
        return None
    return Crossing(node, float(given.values["level"]), direction == "rise", int(number) - 1)


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
    )
