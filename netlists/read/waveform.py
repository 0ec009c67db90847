"""The source cards of a netlist and the waveforms that they become.

    Vname n+ n- [[DC] value] [AC ...] [PULSE(low high delay rise fall width period [count])]
                                      [PWL(t v t v ...)] [SIN(offset amplitude frequency delay damping phase)]

Of a pulse, a rise or fall of 0 is the step of `.tran` and a width or period of 0 its stop time, as in SPICE.
A sine is sampled 200 times a period, joined by straight lines: the error is at most 1.3e-4 of its amplitude.
EXP, SFFM, AM and noise are refused.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from circuits.devices.source import Constant, PiecewiseLinear, Pulse, Sampled, Waveform, polyline
from circuits.errors import ParameterError
from netlists.read.card import Card, shown
from netlists.read.expression.scope import Scope
from netlists.read.limits import DEFAULT_LIMITS
from netlists.read.note import Notes

_SAMPLES = 200  # a period of a sine
_SMALL_SIGNALS = {"ac", "distof1", "distof2"}
_OF_NGSPICE = {  # waveforms that ngspice has beside, and options of PWL
    "exp", "sffm", "am", "trnoise", "trrandom", "external", "portnum", "file", "r", "td",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Span:
    """Step and stop time of the transient analysis, s, None where there is none; vertices that are left."""

    step: float | None = None
    stop: float | None = None
    vertices: int = DEFAULT_LIMITS.vertices


class Given(NamedTuple):
    """A source's `waveform`, and its `direct` value without time where that is another, V or A."""

    waveform: Waveform
    direct: float | None = None

    def negated(self) -> Given:
        """The same seen from the other end."""
        return Given(negated(self.waveform), None if self.direct is None else -self.direct)


def read_waveform(card: Card, words: list[str], scope: Scope, span: Span, notes: Notes) -> Given:
    """What a source gives from the words behind its nodes; raises `DataError` for what it cannot be."""
    name = shown(card.words()[0])
    direct, shape, values = _parts(card, words, scope, notes)
    if shape is None:
        if direct is None:
            notes.add("source without a value, which is 0", card.place)
        return Given(Constant(direct or 0.0))
    try:
        waveform = _SHAPES[shape](card, values, span, span.vertices, notes)
        time, value = polyline(name, waveform)
    except ParameterError as error:
        raise card.foreign(str(error)) from None
    first = float(np.interp(0.0, time, value))
    if direct is not None and isinstance(waveform, Constant):
        return Given(Constant(direct))
    return Given(waveform, None if direct == first else direct)


def small_signal(card: Card, words: list[str], scope: Scope) -> complex:
    """The AC value of a source from the words behind its nodes, V or A: `AC [magnitude [degrees]]`."""
    words = [w for w in words if w not in {"(", ")", "="}]
    if "ac" not in words:
        return 0.0
    first = words.index("ac") + 1
    numbers = [scope.number(card, "ac", w) for w in words[first : _behind_numbers(words, first)]]
    if len(numbers) > 2:
        raise card.error(f"ac: {len(numbers)} numbers, must be 0 to 2; write AC MAGNITUDE DEGREES")
    size, degrees = (*numbers, *(1.0, 0.0)[len(numbers) :])
    return cmath.rect(size, math.radians(degrees)) if degrees else complex(size)


def negated(waveform: Waveform) -> Waveform:
    """The waveform seen from its other end."""
    match waveform:
        case Constant(value):
            return Constant(-value)
        case Pulse(low, high, starts, width, rise, fall):
            return Pulse(-low, -high, starts, width, rise, fall)
        case PiecewiseLinear(time, value):
            return PiecewiseLinear(time, tuple(-v for v in value))
        case Sampled(start, rate, samples):
            return Sampled(start, rate, -samples)
    raise TypeError(f"{type(waveform).__name__}: no waveform of a netlist")


def vertex_count(waveform: Waveform) -> int:
    """Vertices of a waveform, or its samples."""
    match waveform:
        case Pulse(starts=starts):
            return 4 * len(starts)
        case PiecewiseLinear(time=time):
            return len(time)
        case Sampled(value=value):
            return int(value.size)
    return 1


def _parts(
    card: Card, words: list[str], scope: Scope, notes: Notes
) -> tuple[float | None, str | None, list[float]]:
    """Direct value, the waveform's word and its numbers; brackets mean nothing, as in ngspice."""
    direct: float | None = None
    shape, values, k = None, [], 0
    words = [w for w in words if w not in {"(", ")", "="}]
    while k < len(words):
        word = "sin" if words[k] == "sine" else words[k]
        if word in _SHAPES and shape is None:
            shape, end = word, _behind_waveform(words, k + 1)
            values = [scope.number(card, "waveform", w) for w in words[k + 1 : end]]
            k = end
        elif word in _OF_NGSPICE:
            raise card.foreign(f"{word}: not supported; write PULSE, PWL or SIN")
        elif word in _SMALL_SIGNALS:
            notes.add("AC value of a source", card.place)
            k = _behind_numbers(words, k + 1)
        elif word == "dc":
            k += 1
        elif direct is None:
            direct = scope.number(card, "value", word)
            k += 1
        else:
            raise card.error(f"{shown(word)}: after the value; write DC, PULSE, PWL or SIN")
    return direct, shape, values


def _behind_numbers(words: list[str], k: int) -> int:
    while k < len(words) and words[k][0] in "+-.0123456789{'":
        k += 1
    return k


def _behind_waveform(words: list[str], k: int) -> int:
    while k < len(words) and words[k] not in {*_SMALL_SIGNALS, *_OF_NGSPICE, "dc"}:
        k += 1
    return k


def _pulse(card: Card, values: list[float], span: Span, most: int, notes: Notes) -> Waveform:
    if not 2 <= len(values) <= 8:
        raise card.error(f"pulse: {len(values)} numbers, must be 2 to 8; write PULSE(low high delay ...)")
    low, high, delay, rise, fall, width, period, count = values + [0.0] * (8 - len(values))
    rise, fall = (x or _needed(card, "rise or fall", span.step) for x in (rise, fall))
    width, period = (x or _needed(card, "width or period", span.stop) for x in (width, period))
    if min(delay, rise, fall, width, period) < 0.0:
        raise card.error("pulse: a time below 0; give times of 0 or more")
    last = period if span.stop is None else span.stop - delay
    ratio = 1.0 if period >= last else last / period
    if not ratio <= most // 4:
        raise card.error(f"pulse: {ratio:g} of them, the limit is {most // 4}; make the run shorter")
    pulses = math.ceil(ratio)
    pulses = min(pulses, int(count)) if count >= 1.0 else pulses
    return Pulse(low, high, tuple(delay + k * period for k in range(pulses)), width, rise, fall)


def _needed(card: Card, what: str, value: float | None) -> float:
    if value is None:
        raise card.foreign(f"pulse: {what} is 0 or missing, and there is no .tran to take it from; give it")
    return value


def _pwl(card: Card, values: list[float], span: Span, most: int, notes: Notes) -> Waveform:
    if not values or len(values) % 2:
        raise card.error(f"pwl: {len(values)} numbers, must be pairs of time and value; complete the last")
    if len(values) > 2 * most:
        raise card.error(f"pwl: {len(values) // 2} vertices, the limit is {most}; thin them out")
    return PiecewiseLinear(tuple(values[::2]), tuple(values[1::2]))


def _sine(card: Card, values: list[float], span: Span, most: int, notes: Notes) -> Waveform:
    if not 2 <= len(values) <= 6:
        raise card.error(f"sin: {len(values)} numbers, must be 2 to 6; write SIN(offset amplitude frequency)")
    offset, amplitude, frequency, delay, damping, phase = values + [0.0] * (6 - len(values))
    if span.stop is None:  # then only its value at 0 s counts
        return Constant(offset + amplitude * math.sin(math.radians(phase)))
    rate = _SAMPLES * (frequency or 1.0 / span.stop)
    samples = (span.stop - delay) * rate + 2.0
    if frequency < 0.0 or not 0.0 <= delay < span.stop or not samples <= most:
        raise card.error(
            f"sin: {samples:g} samples, must be 2 to {most}; change frequency, delay or stop time"
        )
    time = np.arange(math.ceil(samples)) / rate
    angle = 2.0 * np.pi * (frequency or 1.0 / span.stop) * time + math.radians(phase)
    with np.errstate(over="ignore", invalid="ignore"):
        value = offset + amplitude * np.sin(angle) * np.exp(-damping * time)
    notes.add(f"sine sampled {_SAMPLES} times a period", card.place)
    return Sampled(delay, rate, value)


_Shape = Callable[[Card, list[float], Span, int, Notes], Waveform]
_SHAPES: dict[str, _Shape] = {"pulse": _pulse, "pwl": _pwl, "sin": _sine}
