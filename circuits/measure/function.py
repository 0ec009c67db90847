"""The functions of a measure: what each takes, its unit, and how it is found in a run.

A window `from`, `to` is in the unit of the axis and lies within the run; without one the whole run counts.
What never occurs in a run raises `Absent`, whose text is the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from circuits.arrays import F64
from circuits.lowering.supply import REARM
from circuits.measure.scope import Record
from circuits.measure.signal import Direction, Signal, crossings, extreme, integral, slope_at, value_at
from circuits.measure.unit import DECIBEL, DEGREE, PLAIN, Unit, value_text

Kind = Literal["signal", "number", "word", "node", "source"]
Of = Literal["axis", "signal", "any", "plain"]  # unit that a number must have
Result = Literal["number", "signal"]
LAST = "last"
DIRECTIONS = ("rise", "fall", "either")
_WORDS = {"rise": "rise", "fall": "fall", "either": "pass"}
_ROUNDING = 1e-9  # share of a run by which a window may lie outside it


class Absent(Exception):  # noqa: N818 - no error: what is measured does not occur
    """What is measured does not occur in a run; the text says what."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a function: its name and kind, its unit, words that may stand for it, if it may miss."""

    name: str
    kind: Kind
    of: Of = "any"
    words: tuple[str, ...] = ()
    optional: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Arguments:
    """Arguments of a call in a run.

    Attributes
    ----------
    record : the run.
    axis : unit of its axis.
    values : a `Signal`, a number, a word or a name for each parameter that is given.
    texts : what the user wrote for each of them.
    unit : unit of the first argument.
    """

    record: Record
    axis: Unit
    values: Mapping[str, Any]
    texts: Mapping[str, str]
    unit: Unit

    @property
    def signal(self) -> Signal:
        """The first argument."""
        found: Signal = self.values["signal"]
        return found

    @property
    def label(self) -> str:
        """Text of the first argument."""
        return next(iter(self.texts.values()))

    def number(self, name: str, usual: float) -> float:
        """A number, `usual` where it is not given."""
        return float(self.values.get(name, usual))

    def place(self, name: str, usual: float) -> float:
        """A place of the axis, as the record's axis has it; raises `Absent` outside the run."""
        low, high = float(self.record.axis[0]), float(self.record.axis[-1])
        if name not in self.values:
            return usual
        found = self.record.sign * float(self.values[name])
        room = _ROUNDING * (high - low)
        if not low - room <= found <= high + room:
            ends = sorted(self.record.sign * end for end in (low, high))
            shown = " to ".join(value_text(end, self.axis) for end in ends)
            at = value_text(float(self.values[name]), self.axis)
            raise Absent(f"{name} {at} is outside the run, {shown}")
        return min(max(found, low), high)

    @property
    def window(self) -> tuple[float, float]:
        """Ends of the window, the lower first."""
        ends = float(self.record.axis[0]), float(self.record.axis[-1])
        names = ("from", "to") if self.record.sign > 0.0 else ("to", "from")
        low, high = (self.place(name, end) for name, end in zip(names, ends, strict=True))
        if low > high and self.record.sign < 0.0:
            low, high = high, low
        if low > high or ("from" in self.values and "to" in self.values and low == high):
            shown = (value_text(self.record.sign * end, self.axis) for end in (low, high))
            raise Absent("window from {} to {} is empty".format(*shown))
        return low, high

    def level(self, signal: Signal) -> float:
        """The level that is given, else the middle of the signal's swing in the window."""
        if "level" in self.values:
            return float(self.values["level"])
        return 0.5 * sum(extreme(signal, *self.window, sign)[1] for sign in (1.0, -1.0))


@dataclass(frozen=True, slots=True)
class Function:
    """A function of a measure.

    Attributes
    ----------
    parameters : in the order in which they may stand without their names.
    unit : gives the unit of the result, by those of the first argument and of the axis.
    find : finds it in a run; raises `Absent`.
    summary : a line about it.
    result : what it gives.
    """

    parameters: tuple[Parameter, ...]
    unit: Callable[[Unit, Unit], Unit]
    find: Callable[[Arguments], Any]
    summary: str
    result: Result = "number"


def _cross(a: Arguments) -> float:
    direction: Direction = a.values.get("direction", "either")
    level, low, high = a.number("level", 0.0), *a.window
    found = crossings(a.signal, level, direction, low, high)
    asked = a.values.get("n", 1.0)
    n = found.size if asked == LAST else int(asked)
    if not 1 <= n <= found.size:
        often = f" {n} times, but {found.size}" if found.size else ""
        raise Absent(f"{a.label} does not {_WORDS[direction]} through {value_text(level, a.unit)}{often}")
    return a.record.sign * float(found[n - 1])


def _extreme(sign: float, part: int) -> Callable[[Arguments], float]:
    def find(a: Arguments) -> float:
        found = extreme(a.signal, *a.window, sign)[part]
        return found if part else a.record.sign * found

    return find


def _swing(a: Arguments) -> float:
    window = a.window
    return extreme(a.signal, *window, 1.0)[1] - extreme(a.signal, *window, -1.0)[1]


def _integral(a: Arguments) -> float:
    return a.record.sign * integral(a.signal, *a.window)


def _mean(a: Arguments) -> float:
    low, high = a.window
    return integral(a.signal, low, high) / _length(low, high)


def _rms(a: Arguments) -> float:
    low, high = a.window
    return float(np.sqrt(max(integral(a.signal, low, high, power=2), 0.0) / _length(low, high)))


def _length(low: float, high: float) -> float:
    if not high > low:
        raise Absent("the run has one point only")
    return high - low


def _value(a: Arguments) -> float:
    return value_at(a.signal, a.place("at", a.signal.ends[1]))


def _slope(a: Arguments) -> float:
    if "at" in a.values:
        return a.record.sign * slope_at(a.signal, a.place("at", 0.0))
    low, high = a.window
    difference = value_at(a.signal, high) - value_at(a.signal, low)
    return a.record.sign * difference / _length(low, high)


def _rises(a: Arguments) -> tuple[float, F64]:
    """Level, and the rises through it, at least two."""
    level = a.level(a.signal)
    found = crossings(a.signal, level, "rise", *a.window)
    if found.size < 2:
        times = ("never", "once")[found.size]
        raise Absent(f"{a.label} has no whole period: it rises through {value_text(level, a.unit)} {times}")
    return level, found


def _period(a: Arguments) -> float:
    _, rises = _rises(a)
    return float(rises[-1] - rises[0]) / (rises.size - 1)


def _duty(a: Arguments) -> float:
    level, rises = _rises(a)
    first, last = float(rises[0]), float(rises[-1])
    falls = crossings(a.signal, level, "fall", first, last)
    return float((falls - rises[: falls.size]).sum()) / (last - first)


def _spikes(a: Arguments) -> float:
    low, high = a.window
    if "level" not in a.values:
        found = a.record.spikes(a.values["signal"])
        return float(((found >= low) & (found <= high)).sum())
    level, signal = a.number("level", 0.0), a.record.voltage(a.values["signal"])
    count, armed_from = 0, low
    for at in crossings(signal, level, "rise", low, high):
        rearm = level - (1.0 - REARM) * abs(level)
        if not count or extreme(signal, armed_from, float(at), -1.0)[1] < rearm:
            count, armed_from = count + 1, float(at)
    return float(count)


def _energy(a: Arguments) -> float:
    course = a.record.energy(a.values["source"])
    low, high = a.window
    return value_at(course, high) - value_at(course, low)


def _each(
    function: Callable[[Any], Any], what: str, rule: Callable[[Any], Any]
) -> Callable[[Arguments], Any]:
    """A function of a number, or of a signal point by point, where `rule` holds."""

    def find(a: Arguments) -> Any:
        given = next(iter(a.values.values()))
        values = given.value if isinstance(given, Signal) else given
        if not np.all(rule(values)):
            raise Absent(f"{a.label} is {what}")
        with np.errstate(over="ignore", divide="ignore"):
            found = function(values)
        return given.with_value(np.asarray(found)) if isinstance(given, Signal) else float(found)

    return find


def _anything(_: Any) -> bool:
    return True


def _of_two(best: Callable[[float, float], float]) -> Callable[[Arguments], float]:
    return lambda a: float(best(a.values["a"], a.values["b"]))


def _same(first: Unit, axis: Unit) -> Unit:
    return first


def _axis(first: Unit, axis: Unit) -> Unit:
    return axis


def _always(unit: Unit) -> Callable[[Unit, Unit], Unit]:
    return lambda *_: unit


_plain, _decibel, _degree = _always(PLAIN), _always(DECIBEL), _always(DEGREE)

_SIGNAL = Parameter("signal", "signal", optional=False)
_WINDOW = (Parameter("from", "number", "axis"), Parameter("to", "number", "axis"))
_LEVEL = Parameter("level", "number", "signal")
_NEEDED = Parameter("level", "number", "signal", optional=False)
_DIRECTION = Parameter("direction", "word", words=DIRECTIONS)
_NTH = Parameter("n", "number", "plain", words=(LAST,))
_PAIR = (Parameter("a", "number", optional=False), Parameter("b", "number", "signal", optional=False))


def _over(find: Callable[[Arguments], Any], unit: Callable[[Unit, Unit], Unit], summary: str) -> Function:
    """A function of a waveform over a window."""
    return Function((_SIGNAL, *_WINDOW), unit, find, summary)


def _pointwise(
    function: Callable[[Any], Any],
    unit: Callable[[Unit, Unit], Unit],
    summary: str,
    what: str = "",
    rule: Callable[[Any], Any] = _anything,
    of: Of = "any",
) -> tuple[Function, Function]:
    """A function of a waveform, point by point, and of a number."""
    find = _each(function, what, rule)
    pair = (Parameter("signal", "signal", of, optional=False), Parameter("a", "number", of, optional=False))
    results: tuple[Result, Result] = ("signal", "number")
    waveform, number = (
        Function((each,), unit, find, summary, result) for each, result in zip(pair, results, strict=True)
    )
    return waveform, number


def _root(first: Unit, axis: Unit) -> Unit:
    found = first.root()
    if found is None:
        raise ValueError(f"the square root of a number in {first} has no unit")
    return found


def _integrated(first: Unit, axis: Unit) -> Unit:
    return first * axis


def _per_axis(first: Unit, axis: Unit) -> Unit:
    return first / axis


def _positive(x: Any) -> Any:
    return np.abs(x) > 0.0 if np.iscomplexobj(x) else np.asarray(x) > 0.0


FUNCTIONS: dict[str, tuple[Function, ...]] = {  # several where the first argument decides
    "cross": (
        Function((_SIGNAL, _NEEDED, _DIRECTION, _NTH, *_WINDOW), _axis, _cross, "n-th crossing of a level"),
    ),
    "max": (
        _over(_extreme(1.0, 1), _same, "largest value"),
        Function(_PAIR, _same, _of_two(max), "larger of two numbers"),
    ),
    "min": (
        _over(_extreme(-1.0, 1), _same, "smallest value"),
        Function(_PAIR, _same, _of_two(min), "smaller of two numbers"),
    ),
    "max_at": (_over(_extreme(1.0, 0), _axis, "where the largest value is"),),
    "min_at": (_over(_extreme(-1.0, 0), _axis, "where the smallest value is"),),
    "swing": (_over(_swing, _same, "largest less smallest value"),),
    "mean": (_over(_mean, _same, "integral over the window's length"),),
    "rms": (_over(_rms, _same, "root of the mean square"),),
    "integral": (_over(_integral, _integrated, "integral along the axis"),),
    "value": (
        Function(
            (_SIGNAL, Parameter("at", "number", "axis", optional=False)), _same, _value, "value at a place"
        ),
    ),
    "slope": (
        Function(
            (_SIGNAL, Parameter("at", "number", "axis"), *_WINDOW), _per_axis, _slope,
            "derivative at a place, or mean slope of the window",
        ),
    ),
    "period": (
        Function((_SIGNAL, _LEVEL, *_WINDOW), _axis, _period, "mean time between rises through the level"),
    ),
    "duty": (
        Function((_SIGNAL, _LEVEL, *_WINDOW), _plain, _duty, "share of whole periods above the level"),
    ),
    "spikes": (
        Function(
            (Parameter("signal", "node", optional=False), _LEVEL, *_WINDOW), _plain, _spikes,
            "number of spikes of a node",
        ),
    ),
    "energy": (
        Function(
            (Parameter("source", "source", optional=False), *_WINDOW), _same, _energy,
            "energy that a source of voltage delivers",
        ),
    ),
    "abs": _pointwise(np.abs, _same, "size"),
    "sqrt": _pointwise(np.sqrt, _root, "square root", "below 0", lambda x: np.asarray(x) >= 0.0),
    "ln": _pointwise(np.log, _plain, "natural logarithm", "not above 0", _positive, "plain"),
    "log10": _pointwise(np.log10, _plain, "decimal logarithm", "not above 0", _positive, "plain"),
    "exp": _pointwise(np.exp, _plain, "exponential", of="plain"),
    "mag": _pointwise(np.abs, _same, "magnitude of a transfer")[:1],
    "db": _pointwise(lambda x: 20.0 * np.log10(np.abs(x)), _decibel, "20 log10 of the size", "0", _positive),
    "phase": _pointwise(
        lambda x: np.degrees(np.unwrap(np.angle(np.atleast_1d(x)))), _degree, "phase of a transfer"
    )[:1],
}  # fmt: skip
TAKES_TRANSFERS = frozenset({"mag", "db", "phase"})
