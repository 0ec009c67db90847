"""A chip that is driven live, all chips alike: events go in, time goes on, events come out.

    chip = open_chip("rolls", die=Die("A", 1001), program=program)
    chip.send([1e-3, 2e-3], [addresses])
    spikes = chip.advance(10e-3)                       times (s) and addresses
    chip.write_bias("IF_TAU2_N", 20e-12)

A chip's state is a value that pickles: what is kept of `state` can be put back later. Each kind of chip
brings an `Engine`; times are seconds since the chip was opened, addresses those of `inputs` and `outputs`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from chips.aer import Events
from chips.part import Event, Part
from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError, unknown_name

Train = tuple[F64, I64]  # times, s, and addresses


@dataclass(frozen=True, slots=True)
class Addresses:
    """Addresses of a kind of event.

    Attributes
    ----------
    name : str
        What they are, as the port of the chip.
    first : int
        Number of the first address.
    count : int
        How many there are.
    """

    name: str
    first: int
    count: int


def within(kinds: Sequence[Addresses], addresses: I64) -> Bools:
    """Return whether each of some addresses is of one of the kinds, bool[m]."""
    known = np.zeros(addresses.shape, dtype=np.bool_)
    for one in kinds:
        known |= (addresses >= one.first) & (addresses < one.first + one.count)
    return known


class Engine(Protocol):
    """What a kind of chip brings; states are values that pickle and are never written to."""

    @property
    def inputs(self) -> tuple[Addresses, ...]:
        """Addresses of the events that it takes."""

    @property
    def outputs(self) -> tuple[Addresses, ...]:
        """Addresses of the events that it sends."""

    @property
    def lines(self) -> Mapping[str, int]:
        """How many numbers each line that can be driven takes, by name."""

    def takes(self, addresses: I64) -> Bools:
        """Return whether it takes events of these addresses, as `within` where all of a kind are alike."""

    def begin(self) -> Any:
        """Return the state at rest at 0 s."""

    def go_on(self, state: Any, now: float, until: float, train: Train) -> tuple[Any, Train]:
        """Go on from `now` to `until`, s, with events of the time between; returns what was sent."""

    def counts(self, state: Any) -> Mapping[str, int]:
        """Return what was lost, merged or clipped so far, by name."""

    def biases(self) -> Mapping[str, float]:
        """Return the biases by name, A or V."""

    def with_bias(self, state: Any, name: str, value: float) -> tuple[Engine, Any]:
        """Return the chip with another value of a bias, A or V, and the state as it goes on."""

    def at(self, state: Any, temperature_c: float) -> tuple[Engine, Any]:
        """Return the chip at another temperature, degC, and the state as it goes on."""

    def drive(self, state: Any, line: str, values: F64) -> Any:
        """Return the state in which a line is at some values from now on."""

    def show(self, state: Any) -> Mapping[str, F64]:
        """Return what its analog outputs are, by name."""


@dataclass(frozen=True, slots=True)
class LiveState:
    """State of a live chip; it pickles.

    time : s; engine, inner : the chip and its state; train : events that wait for their time.
    """

    time: float
    engine: Engine
    inner: Any
    train: Train


class LiveChip:
    """A chip that is driven live.

    Parameters
    ----------
    engine
        The kind of chip (`open_chip` makes it).
    path
        What errors call it.

    Attributes
    ----------
    state : LiveState
        All of it; one that was kept can be put back.
    """

    def __init__(self, engine: Engine, path: str) -> None:
        self.path = path
        nothing = np.empty(0), np.empty(0, dtype=np.int64)
        self.state = LiveState(0.0, engine, engine.begin(), nothing)

    @property
    def time(self) -> float:
        """Time that it has reached, s."""
        return self.state.time

    @property
    def inputs(self) -> tuple[Addresses, ...]:
        """Addresses of the events that it takes."""
        return self.state.engine.inputs

    @property
    def outputs(self) -> tuple[Addresses, ...]:
        """Addresses of the events that it sends."""
        return self.state.engine.outputs

    @property
    def lost(self) -> Mapping[str, int]:
        """Counts of events that were lost, merged or clipped so far, by name."""
        return dict(self.state.engine.counts(self.state.inner))

    def send(self, times: ArrayLike, addresses: ArrayLike) -> None:
        """Send events, which are taken at their times.

        Parameters
        ----------
        times
            Times, s, float64[m], none before the chip's own and none before the one ahead of it; one number
            for all.
        addresses
            Addresses, int64[m], as `inputs` has them.

        Raises
        ------
        ParameterError
            An address is not one of the chip's, or times go backwards.
        """
        given = np.atleast_1d(np.asarray(addresses))
        if given.dtype.kind not in "iu" and given.size:
            raise ParameterError(f"{self.path}.addresses: {given.dtype} numbers, must be whole numbers")
        where = given.astype(np.int64)
        when = np.asarray(times, dtype=np.float64)
        when = np.full(where.shape, when) if when.ndim == 0 else when
        if when.shape != where.shape or when.ndim != 1:
            raise ParameterError(
                f"{self.path}.send: {when.size} times and {where.size} addresses, must be as many"
            )
        self._check_addresses(where)
        self._check_times(when)
        old, last = self.state.train
        late = np.concatenate([old, when])
        order = np.argsort(late, kind="stable")
        train = late[order], np.concatenate([last, where])[order]
        self.state = replace(self.state, train=train)

    def advance(self, duration: float) -> Events:
        """Go on and return the events that were sent meanwhile, in the order of their times.

        Parameters
        ----------
        duration
            For how long, s; events of the very end count in the next stretch.

        Raises
        ------
        ParameterError
            The duration is not above 0 and finite.
        """
        if not 0.0 < duration < math.inf:
            raise ParameterError(f"{self.path}.advance: {duration:g} s, must be above 0 and finite")
        state, until = self.state, self.state.time + duration
        times, addresses = state.train
        split = int(np.searchsorted(times, until, side="left"))
        inner, sent = state.engine.go_on(state.inner, state.time, until, (times[:split], addresses[:split]))
        self.state = replace(state, time=until, inner=inner, train=(times[split:], addresses[split:]))
        order = np.argsort(sent[0], kind="stable")
        return Events(sent[0][order], sent[1][order])

    def address(self, name: str, index: int = 0) -> int:
        """Return the address number of the event `index` of the kind `name`.

        Raises `UnknownNameError` for a name that is none, `ParameterError` for an index beyond its kind.
        """
        known = {one.name: one for one in (*self.outputs, *self.inputs)}
        if name not in known:
            raise unknown_name(f"{self.path} address", name, known)
        if not 0 <= index < known[name].count:
            raise ParameterError(f"{self.path}.{name}[{index}]: must be 0 to {known[name].count - 1}")
        return known[name].first + index

    def biases(self) -> dict[str, float]:
        """Return all biases by name, A or V."""
        return dict(self.state.engine.biases())

    def read_bias(self, name: str) -> float:
        """Return the value of the bias called `name`, A or V; raises `UnknownNameError` for none."""
        found = self.biases()
        if name not in found:
            raise unknown_name(f"{self.path} bias", name, found)
        return found[name]

    def write_bias(self, name: str, value: float) -> float:
        """Write a bias from now on, and return what it then is, which a generator's codes round.

        value: A or V. Raises `UnknownNameError` where there is no bias `name`, and `ParameterError` for a
        value that cannot be reached, or that leads outside of what the chip's model was measured for.
        """
        self.read_bias(name)
        if not math.isfinite(value):
            raise ParameterError(f"{self.path}.{name}: {value:g}, must be finite")
        engine, inner = self.state.engine.with_bias(self.state.inner, name, value)
        self.state = replace(self.state, engine=engine, inner=inner)
        return self.read_bias(name)

    def warm(self, temperature_c: float) -> None:
        """Take the chip to `temperature_c`, degC; raises `ParameterError` outside of its model's box."""
        engine, inner = self.state.engine.at(self.state.inner, temperature_c)
        self.state = replace(self.state, engine=engine, inner=inner)

    def drive(self, line: str, values: ArrayLike) -> None:
        """Hold an analog input at values from now on.

        Parameters
        ----------
        line
            Its name.
        values
            Values in the line's unit, one number or float64[n].

        Raises
        ------
        UnknownNameError
            There is no such line.
        ParameterError
            There are not as many values as the line takes, or one is not finite.
        """
        known = self.state.engine.lines
        if line not in known:
            raise unknown_name(f"{self.path} line", line, known)
        found = np.broadcast_to(np.asarray(values, dtype=np.float64), (known[line],)).copy()
        if not np.isfinite(found).all():
            raise ParameterError(f"{self.path}.{line}: {values!r}, must be finite")
        inner = self.state.engine.drive(self.state.inner, line, found)
        self.state = replace(self.state, inner=inner)

    def show(self) -> dict[str, F64]:
        """Return what the analog outputs are by name, float64[n] each, in their own units."""
        return dict(self.state.engine.show(self.state.inner))

    def _check_addresses(self, where: I64) -> None:
        known = self.state.engine.takes(where)
        if not known.all():
            wrong = where[~known][:1]
            raise ParameterError(f"{self.path}.address: {wrong[0]}, {self._why_not(wrong)}")

    def _why_not(self, wrong: I64) -> str:
        if within(self.inputs, wrong).all():
            return "a synapse that is not latched; set it in the chip's program"
        ranges = ", ".join(f"{a.first} to {a.first + a.count - 1} ({a.name})" for a in self.inputs if a.count)
        return f"not on the chip; it has {ranges or 'none'}"

    def _check_times(self, when: F64) -> None:
        before = np.concatenate([[self.time], when[:-1]])
        wrong = np.flatnonzero(~(when >= before) | ~np.isfinite(when))
        if wrong.size:
            k = int(wrong[0])
            what = "the chip's time" if k == 0 else "the one before"
            raise ParameterError(
                f"{self.path}.times[{k}]: {when[k]:g} s, must not be before {what}, {before[k]:g} s"
            )


def moments(part: Part[Any], state: Any, until: float, events: Sequence[Event]) -> tuple[Any, list[Event]]:
    """Go on with a part of a loop to `until`, s, through events in the order of their times; what it sent."""
    sent: list[Event] = []
    taken = 0
    while True:
        begin = taken
        while taken < len(events) and events[taken][1] <= state.time:
            taken += 1
        now = events[begin:taken]
        if state.time >= until and not now:
            return state, sent
        stop = min(until, events[taken][1]) if taken < len(events) else until
        state, _, out = part.advance(state, max(stop, state.time), now)
        sent += out.events
