"""A network on neurons in a run: nodes are set from outside or called, probes are read.

Every `interval` the functions of nodes are called with the time and what is connected to them, and what nodes
give is put on the lanes, where it stays for the interval. A robot's 10 ms is such an interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from chips.nef.build import Built
from chips.nef.chip import FIFO
from chips.nef.kernel import COUNTERS, ChipState, add_shown, advance_chip, new_chip_state
from chips.nef.network.kernel import DT, State, advance, new_state
from chips.nef.noise import copied
from chips.nef.noise_kernel import NefNoise
from chips.nef.temperature import carried
from chips.nef.whole.kernel import Bends
from circuits.arrays import F64, I64
from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True)
class SimulationState:
    """All that a simulation has at a time, s; it pickles.

    base, chip: of the network, and of the chip unless its neurons are ideal; steps: of the devices' noise,
    which is keyed by them; values: what nodes give.
    """

    time: float
    base: State
    chip: ChipState | None
    steps: int
    values: F64


class Simulation:
    """A network in time.

    Parameters
    ----------
    built
        The network, ready to run.
    interval
        Time between two calls of nodes, s: a whole number of steps of `DT`.

    Raises
    ------
    ParameterError
        The interval is no whole number of steps.
    """

    __slots__ = (
        "_bends", "_chip", "_drive", "_fired", "_noise", "_steps", "_values", "built", "interval", "state",
        "time",
    )  # fmt: skip

    def __init__(self, built: Built, interval: float = DT) -> None:
        steps = round(interval / DT)
        if steps < 1 or abs(steps * DT - interval) > 1e-9:
            raise ParameterError(f"interval: {interval:g} s, must be a whole number of steps of {DT:g} s")
        self.built, self.interval, self._steps = built, interval, steps
        self._chip: ChipState | None = None if built.chip is None else new_chip_state(built.chip, FIFO)
        self._noise, self._bends = _own(built)
        self.state = new_state(built.net) if self._chip is None else self._chip.base
        self.time = 0.0
        self._values = np.zeros(built.drive.shape[1])
        self._fired: list[tuple[float, I64]] | None = None
        self._drive = built.drive

    def set(self, name: str, values: ArrayLike) -> None:
        """Set what the node `name` gives from now on to `values`, float64[size]."""
        self._values[self.built.given[name]] = values

    def given(self, name: str) -> F64:
        """Return what the node `name` gives, float64[size], in its own unit."""
        return np.atleast_1d(self._values[self.built.given[name]]).copy()

    def read(self, name: str) -> F64:
        """Return what a probe shows or a node gets, by its `name`, float64[size], in its own unit."""
        return self.state.y[self.built.read[name]].copy()

    def arrived(self, name: str) -> F64:
        """Return what spikes have added so far to a probe of this `name`, float64[size], in its own unit."""
        return self.state.raw[self.built.read[name]].copy()

    def coming(self, name: str) -> F64:
        """Return what a probe of this `name` will show after the next step, float64[size], in its unit."""
        lanes = self.built.read[name]
        now = self.state.raw[lanes]
        return np.asarray(now + self.built.net.keep[lanes] * (self.state.y[lanes] - now))

    def advance(self, duration: float) -> None:
        """Go on for the time `duration`, s, in whole intervals."""
        for _ in range(round(duration / self.interval)):
            for node in self.built.network.nodes:
                if node.output is not None:
                    self.set(node.name, node.output(self.time, self.read(node.name)))
            np.einsum("kj,j->k", self._drive, self._values, out=self.state.held)
            if self._fired is None:
                self._go_on(self._steps)
            else:
                self._go_on_recording(self._fired)
            self.time += self.interval

    def summed(self, names: Sequence[str], steps: int) -> F64:
        """Go on for some intervals, and return the sums of what probes show at the end of each.

        Parameters
        ----------
        names
            Of the probes.
        steps
            How many intervals.

        Returns
        -------
        One probe after the other, each in its own unit, float64[all results].
        """
        lanes = np.concatenate([np.arange(self.state.y.size)[self.built.read[name]] for name in names])
        total = np.zeros(lanes.size)
        one_by_one = self._called or self._fired is not None or self._steps > 1
        if one_by_one or self.built.chip is None or self._chip is None:
            for _ in range(steps):
                self.advance(self.interval)
                total += self.state.y[lanes]
            return total
        np.einsum("kj,j->k", self._drive, self._values, out=self.state.held)
        add_shown(self.built.chip, self._chip, steps, self._noise, self._bends, lanes, total)
        for _ in range(steps):
            self.time += self.interval
        return total

    @property
    def _called(self) -> bool:
        """Whether a node has a function that is called."""
        return any(node.output is not None for node in self.built.network.nodes)

    def record(self) -> None:
        """Keep every spike from now on, as `recorded` has them."""
        self._fired = []

    def recorded(self) -> tuple[F64, I64]:
        """Return the spikes that were kept: ends of their steps, s, float64[m], and neurons, int64[m]."""
        kept = self._fired or []
        times = np.repeat(np.array([time for time, _ in kept]), [fired.size for _, fired in kept])
        return times, np.concatenate([np.empty(0, dtype=np.int64), *(fired for _, fired in kept)])

    def _go_on(self, steps: int) -> None:
        if self.built.chip is None or self._chip is None:
            advance(self.built.net, self.state, steps)
        else:
            advance_chip(self.built.chip, self._chip, steps, self._noise, self._bends)

    def _go_on_recording(self, fired: list[tuple[float, I64]]) -> None:
        """As `_go_on`, step by step."""
        for k in range(self._steps):
            before = self.state.spikes.copy()
            self._go_on(1)
            count = self.state.spikes - before
            fired.append((self.time + (k + 1) * DT, np.repeat(np.arange(count.size), count)))

    def move(self, built: Built) -> None:
        """Go on with the same network as `built`, as at another temperature (`chips.nef.build.moved`)."""
        old = self._noise
        if self._chip is not None:
            self._chip = carried(self._chip, self.built, built)
            self.state = self._chip.base
        self.built, (self._noise, self._bends) = built, _own(built)
        if self._noise is not None and old is not None:
            self._noise.step[0] = old.step[0]

    def snapshot(self) -> SimulationState:
        """Return the present state, of arrays of its own."""
        chip = None if self._chip is None else _copied_chip(self._chip)
        base = _copied(self.state) if chip is None else chip.base
        steps = 0 if self._noise is None else int(self._noise.step[0])
        return SimulationState(self.time, base, chip, steps, self._values.copy())

    def restore(self, state: SimulationState) -> None:
        """Go on from a state, which is not changed."""
        self.time, self._values = state.time, state.values.copy()
        self._chip = None if state.chip is None else _copied_chip(state.chip)
        self.state = _copied(state.base) if self._chip is None else self._chip.base
        if self._noise is not None:
            self._noise.step[0] = state.steps

    @property
    def counters(self) -> dict[str, int]:
        """Return the chip's counts by name: spikes, dropped ones, most that waited, and clipped steps."""
        if self._chip is None:
            return {}
        return {name: int(k) for name, k in zip(COUNTERS, self._chip.counters, strict=True)}

    @property
    def spikes(self) -> int:
        """Return how many spikes each neuron has had since the start."""
        return int(self.state.spikes.sum())


def _own(built: Built) -> tuple[NefNoise | None, Bends | None]:
    """Noise and bends of a network with working space of their own, so that no run changes the network."""
    bends = built.bends
    return (
        None if built.noise is None else copied(built.noise),
        None if bends is None else bends._replace(draws=np.zeros_like(bends.draws)),
    )


def _copied(state: State) -> State:
    return state._replace(**{name: getattr(state, name).copy() for name in State._fields})


def _copied_chip(chip: ChipState) -> ChipState:
    own = {name: getattr(chip, name).copy() for name in ChipState._fields if name != "base"}
    return chip._replace(base=_copied(chip.base), **own)
