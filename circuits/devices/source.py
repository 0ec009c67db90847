"""Ideal sources and their waveforms. They belong to a testbench, never to a circuit.

Every waveform is a polyline: points in time with a value each, joined by straight lines, constant before the
first and after the last. The solver restarts at each point. A sampled waveform, such as a sound, is followed
at its sample rate instead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from circuits.arrays import F64
from circuits.brief import OPTIONAL, brief
from circuits.checks import keep_allowance, require_choice, require_plausible, require_reals, require_type
from circuits.devices.device import Device
from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True)
class Constant:
    """A direct voltage (V) or current (A) of `value`."""

    value: float


@dataclass(frozen=True, slots=True)
class Pulse:
    """Trapezoids from `low` to `high` (V or A), one at each of `starts`, s.

    Each rises for `rise` (s), stays high for `width` (s), and falls for `fall` (s).
    """

    low: float
    high: float
    starts: tuple[float, ...]
    width: float
    rise: float
    fall: float


@dataclass(frozen=True, slots=True)
class PiecewiseLinear:
    """Points at rising times `time` (s) with the values `value` (V or A), joined by straight lines."""

    time: tuple[float, ...]
    value: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """Samples `value` (float64[T], V or A) from `start` (s) on at `rate` (Hz), joined by straight lines."""

    start: float
    rate: float
    value: F64


@dataclass(frozen=True, slots=True)
class Driven:
    """A waveform that is set from outside while a run goes on; until then it is `initial`, V or A."""

    initial: float


Waveform = Constant | Pulse | PiecewiseLinear | Sampled | Driven
Polyline = tuple[F64, F64]
Quantity = Literal["voltage", "current"]


@dataclass(frozen=True, slots=True, repr=False)
class Source(Device):
    """An ideal source between ground and `node`.

    Attributes
    ----------
    node
        Node that it drives against ground.
    waveform
        What it gives over time.
    quantity
        `voltage` or `current`; a current flows into the node.
    direct
        What it gives to an analysis without time, V or A: to an operating point, a sweep, small signals and
        noise, as SPICE's DC value. The waveform's value at 0 s unless given.

    Raises
    ------
    ParameterError
        Times do not rise, or a value is not finite or not plausible.
    """

    name: str
    node: str
    waveform: Waveform
    quantity: Quantity = "voltage"
    direct: float | None = field(default=None, metadata=OPTIONAL)

    def __repr__(self) -> str:
        return brief(self)

    def __post_init__(self) -> None:
        keep_allowance(self)
        require_type("source.name", self.name, str, "a name")
        require_type(f"{self.name}.node", self.node, str, "the name of a port")
        require_choice(f"{self.name}.quantity", self.quantity, get_args(Quantity))
        require_type(
            f"{self.name}.waveform", self.waveform, get_args(Waveform), "a waveform, as Constant(5.0)"
        )
        if self.direct is not None:
            require_reals(f"{self.name}.direct", (self.direct,), "V" if self.quantity == "voltage" else "A")
            if not math.isfinite(self.direct):
                raise ParameterError(f"{self.name}.direct: {self.direct:g}, must be finite; give a number")
            if isinstance(self.waveform, Constant):
                raise ParameterError(f"{self.name}.direct: {self.direct:g} beside a constant; leave it out")
        if not isinstance(self.waveform, Sampled):  # long ones are looked at when they are used
            self.check()

    def terminals(self) -> tuple[str, ...]:
        """The node that is driven."""
        return (self.node,)

    def parameters(self) -> Mapping[str, float]:
        """No numbers, because a waveform is no parameter in SI units."""
        return {}

    def check(self) -> None:
        """Raise `ParameterError` unless times rise and values are finite, the largest of them plausible.

        A current may be 0, and may pass through any value on its way to its largest.
        """
        held = self.waveform.value if isinstance(self.waveform, Constant) else None
        if type(held) is float and math.isfinite(held):  # most sources: no arrays for one number
            largest = abs(held)
        else:
            largest = float(np.abs(polyline(self.name, self.waveform)[1]).max())
        largest = max(largest, abs(self.direct or 0.0))
        if largest:
            unit = "V" if self.quantity == "voltage" else "A"
            require_plausible(f"{self.name}.waveform", largest, unit, allowed=self.allow_implausible)

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """A voltage source ties its node to ground; a current source does not."""
        return ((0, -1),) if self.quantity == "voltage" else ()


def polyline(name: str, waveform: Waveform) -> Polyline:
    """Times (s) and values of a waveform's points, float64[T] each, at least one.

    Raises `ParameterError`, which names the source, for points that do not rise in time or are not finite.
    """
    if isinstance(waveform, Constant):
        return vertices(name, (0.0,), (waveform.value,))
    if isinstance(waveform, Driven):
        return vertices(name, (0.0,), (waveform.initial,))
    if isinstance(waveform, Sampled):
        if not (math.isfinite(waveform.rate) and waveform.rate > 0.0):
            raise ParameterError(f"{name}: rate {waveform.rate:g} Hz, must be > 0; give samples a second")
        return vertices(name, waveform.start + np.arange(waveform.value.size) / waveform.rate, waveform.value)
    if isinstance(waveform, Pulse):
        return vertices(name, *_trapezoids(name, waveform))
    return vertices(name, waveform.time, waveform.value)


def vertices(name: str, time: Sequence[float] | F64, value: Sequence[float] | F64) -> Polyline:
    """Times (s) and values of a polyline as arrays, float64[T] each, after a check.

    Raises `ParameterError`, which names the source, for points that do not rise in time or are not finite.
    """
    require_reals(f"{name}: times", time, "s")
    require_reals(f"{name}: values", value, "V or A")
    t, v = np.asarray(time, dtype=np.float64), np.asarray(value, dtype=np.float64)
    if t.size == 0 or t.shape != v.shape:
        raise ParameterError(
            f"{name}: {t.size} times and {v.size} values, must be equally many and at least one"
        )
    if (t[1:] > t[:-1]).all() and math.isfinite(t[0]) and math.isfinite(t[-1]) and np.isfinite(v).all():
        return t, v
    if not (np.isfinite(t).all() and np.isfinite(v).all()):
        raise ParameterError(f"{name}: a time or value is not finite; give numbers")
    k = int(np.argmax(np.diff(t) <= 0.0)) + 1
    raise ParameterError(
        f"{name}: time {t[k]:g} s after {t[k - 1]:g} s, times must rise; sort and merge the vertices"
    )


def _trapezoids(name: str, pulse: Pulse) -> tuple[list[float], list[float]]:
    require_reals(f"{name}: width, rise, fall", (pulse.width, pulse.rise, pulse.fall), "s")
    require_reals(f"{name}: starts", pulse.starts, "s")
    if min(pulse.width, pulse.rise, pulse.fall) <= 0.0:
        raise ParameterError(
            f"{name}: width {pulse.width:g} s, rise {pulse.rise:g} s, fall {pulse.fall:g} s, must be > 0"
        )
    time, value = [0.0], [pulse.low]
    for start in sorted(pulse.starts):
        if start < time[-1] and len(time) > 1:
            raise ParameterError(
                f"{name}: pulse at {start:g} s begins before the one before has ended ({time[-1]:g} s)"
            )
        corners = (start, start + pulse.rise, start + pulse.rise + pulse.width)
        first = 1 if start == time[-1] else 0
        time += [*corners[first:], corners[2] + pulse.fall]
        value += [*(pulse.low, pulse.high, pulse.high)[first:], pulse.low]
    return time, value
