"""The latency chip: memories, a delay line and two layers of neurons that race to the first spike.

It hears addresses and says addresses. In: a spike for a memory, the goal's charge, the charge of the ping's
direction, the ping's onset, a reset. Out: winners of the second layer, and the emergency neuron. What the
memories say goes to the first layer on the chip. Between events everything is exact
(`chips.latency.kernel`), so that a ping costs some 0.1 ms of computing, and a chip is the same to the
bit wherever it runs.

A unit may be put at transistor level (`chips.latency.unit_level`): then its spikes are the solver's.

Source: Wen & Horiuchi 2022, section 3; circuits, sizes and addresses are ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol

import numpy as np

from chips.aer import Bus, send
from chips.latency.design import NAME, Biases, Design
from chips.latency.kernel import (
    OVERFLOW,
    STEPS,
    UNDECIDED,
    Charge,
    Memory,
    Race,
    integrate,
    move,
    race,
    recall,
    reset,
)  # fmt: skip
from chips.latency.model import Lumped, lumped, usual_biases
from chips.latency.noise import noise_of, numbers_of_ping
from chips.noise import SiliconNoise
from circuits.arrays import F64, I64
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon


class Addresses(NamedTuple):
    """The address at which each kind of event begins; memories are at 0 to n - 1, for n paths.

    goal: n addresses of goal neurons; direction: one for each group; onset, reset: one each; emergency: of
    the events that leave, whose winners are 0 to n - 1.
    """

    goal: int
    direction: int
    onset: int
    reset: int
    emergency: int = 0  # of the events that leave, whose winners are 0 to n - 1


class Unit(Protocol):
    """A latency unit that is simulated by itself, as at transistor level."""

    def ping(self, start: float, tap: float, spoken: float) -> float:
        """Return the latency of its spike after a ping at `start` (s), s, inf for none.

        tap, spoken: latencies of its inputs, from the delay line and from the integrating neuron, s, inf for
        none.
        """
        ...

    def reset(self, at: float) -> None:
        """Reset the unit at a time, s."""
        ...

    def move(self, temperature_c: float, now: float) -> None:
        """Go on at another temperature (degC) from `now` (s) on."""
        ...


@dataclass(frozen=True, slots=True)
class PingResponse:
    """Response of the chip to a ping; times are in s after it, inf or empty where there was none.

    Attributes
    ----------
    times : array
        When winners of the second layer left the bus, float64[m], s.
    paths : array
        Path of each of these winners, int64[m].
    emergency : float
        Spike of the emergency neuron, s.
    integrating, memory, first : array
        Latencies of the integrating neurons, of the memories' outputs and of the first layer's winners,
        float64[n], s.
    free : array
        Latencies of the first layer if nothing had stopped it, float64[n], s.
    detected : array
        Latencies of the units' detectors, float64[n, u], s.
    lost_in, lost_out : int
        How many events the bus dropped on the way in and out.
    """

    times: F64
    paths: I64
    emergency: float
    integrating: F64 = field(repr=False)
    memory: F64 = field(repr=False)
    first: F64 = field(repr=False)
    free: F64 = field(repr=False)
    detected: F64 = field(repr=False)
    lost_in: int = 0
    lost_out: int = 0


class LatencyChip:
    """A latency chip of a design, on a silicon.

    Parameters
    ----------
    design
        What it is designed for.
    biases
        Its biases; the usual ones unless given.
    silicon
        Process, temperature and die.
    area
        Area of its devices over the circuits', a ratio.
    bus
        Bus by which events come and leave.
    units
        Units that are simulated at transistor level, by memory and number.
    numbers
        Numbers of the chip, instead of those of its silicon.
    noise
        Noise of its devices (`chips.latency.noise`); none unless given. Units at transistor level make none.

    Raises
    ------
    ParameterError
        The silicon is outside the record's box, or the chip lacks a unit.
    """

    def __init__(
        self,
        design: Design,
        biases: Biases | None = None,
        silicon: Silicon | None = None,
        *,
        area: float = 1.0,
        bus: Bus | None = None,
        units: Mapping[tuple[int, int], Unit] | None = None,
        numbers: Lumped | None = None,
        noise: SiliconNoise | None = None,
    ) -> None:
        """Prepare the chip's numbers.

        Raises `ParameterError` for silicon outside the record's box, and for units that the chip lacks.
        """
        self.design, self.silicon, self.area, self.bus = design, silicon or Silicon(), area, bus or Bus()
        self.biases = biases or usual_biases(design, process=self.silicon.process)
        self.lumped = numbers or lumped(design, self.biases, self.silicon, area)
        self.units = dict(units or {})
        self.noise = noise
        self._jitter = (
            None if noise is None else noise_of(self.lumped, self.biases, self.silicon, noise, area)
        )
        for memory, unit in self.units:
            self.check_unit(memory, unit)
        n, groups = design.paths, len(design.second)
        self.addresses = Addresses(n, 2 * n, 2 * n + groups, 2 * n + groups + 1, n)

    def at(self, temperature_c: float) -> LatencyChip:
        """Return the same chip at the temperature `temperature_c`, degC."""
        silicon = replace(self.silicon, temperature_c=temperature_c)
        return LatencyChip(
            self.design,
            self.biases,
            silicon,
            area=self.area,
            bus=self.bus,
            units=self.units,
            noise=self.noise,
        )

    def moved(self, memory: Memory, temperature_c: float, now: float) -> LatencyChip:
        """Return the same chip at another temperature; its memory goes on.

        A charge that is partly taken up is taken up at the new rate from then on.

        Parameters
        ----------
        memory
            What it remembers, which is overwritten.
        temperature_c
            The temperature, degC.
        now
            Time of the change, s.
        """
        chip = self.at(temperature_c)
        move(memory, self.lumped, chip.lumped, now)
        for unit in self.units.values():
            unit.move(temperature_c, now)
        return chip

    def check_unit(self, memory: int, unit: int) -> None:
        """Raise `ParameterError` where the memory of number `memory` has no unit of number `unit`."""
        d = self.design
        if not (0 <= memory < d.paths and 0 <= unit < d.taps):
            raise ParameterError(
                f"{NAME}.memory[{memory}].unit[{unit}]: not on a chip of {d.paths} memories of {d.taps}"
                " units; numbers count from 0"
            )

    def new_memory(self) -> Memory:
        """Return what a chip keeps from ping to ping, after a reset at 0 s."""
        shape = self.design.paths, self.design.taps
        memory = Memory(
            np.full(shape, -math.inf), np.zeros(shape), np.zeros(2, dtype=np.int64), np.empty(STEPS),
            np.empty(STEPS),
        )  # fmt: skip
        reset(memory, self.lumped.tonic, 0.0)
        return memory

    def reset(self, memory: Memory, at: float) -> None:
        """Forget everything in `memory`, by the reset event at the time `at`, s."""
        reset(memory, self.lumped.tonic, at)
        for unit in self.units.values():
            unit.reset(at)

    def ping(self, memory: Memory, start: float, times: F64, addresses: I64) -> PingResponse:
        """Return the response to the events of one ping.

        Resets have their own call.

        Parameters
        ----------
        memory
            What the chip remembers, which is overwritten.
        start
            Time of the ping, s.
        times
            Times of the events after the ping, s, float64[m], 0 for its onset.
        addresses
            Addresses of the events, int64[m], as `addresses` says.

        Raises
        ------
        ParameterError
            The chip does not have an address, or the train does not begin with one onset.
        """
        heard = send(self.bus, times, addresses)
        onset = self._check(heard.addresses)
        late = float(heard.times[onset])
        n, units = self.design.paths, self.design.taps
        mine = heard.addresses < n
        spike, memory_out = np.empty(n), np.empty(n)
        numbers = self._numbers(start)
        integrate(numbers, memory, heard.times[mine] - late, heard.addresses[mine], spike)
        begin = start + late
        given, detected = np.full((n, units), np.nan), np.empty((n, units))
        taps = np.cumsum(numbers.tap)[1:]
        for (p, u), unit in self.units.items():
            given[p, u] = unit.ping(begin, float(taps[u]), float(spike[p]))
        recall(numbers, memory, begin, spike, given, detected, memory_out)
        layers = Race(np.empty(n), np.empty(n), np.empty(n))
        goal, goal_at = _charge(heard.addresses, heard.times - late, self.addresses.goal, n)
        direction, direction_at = _charge(
            heard.addresses, heard.times - late, self.addresses.direction, len(self.design.second)
        )
        charge = Charge(goal, goal_at, direction, direction_at)
        emergency = race(numbers, memory, memory_out, charge, layers)
        times, paths = self._winners(layers.second, emergency)
        left = send(self.bus, times + late, paths)
        alarm = left.addresses == self.addresses.emergency
        return PingResponse(
            times=left.times[~alarm],
            paths=left.addresses[~alarm],
            emergency=float(left.times[alarm][0]) if alarm.any() else math.inf,
            integrating=spike,
            memory=memory_out,
            first=layers.first,
            free=layers.free,
            detected=detected,
            lost_in=heard.dropped,
            lost_out=left.dropped,
        )

    def _numbers(self, start: float) -> Lumped:
        """Numbers of the chip in the ping that begins at `start`, s."""
        return self.lumped if self._jitter is None else numbers_of_ping(self.lumped, self._jitter, start)

    def _winners(self, second: F64, emergency: float) -> tuple[F64, I64]:
        """Times and addresses of what leaves the chip."""
        won = np.flatnonzero(np.isfinite(second))
        if math.isfinite(emergency):
            return np.append(second[won], emergency), np.append(won, self.addresses.emergency)
        return second[won], won

    def _check(self, addresses: I64) -> int:
        """Number of the onset's event."""
        a = self.addresses
        wrong = (addresses < 0) | (addresses > a.onset)
        if wrong.any():
            raise ParameterError(
                f"{NAME}.address: {int(addresses[wrong][0])}, must be 0 to {a.onset}; a reset has a call"
                " of its own"
            )
        onsets = np.flatnonzero(addresses == a.onset)
        if onsets.size != 1 or (addresses[: onsets[0]] < a.goal).any():
            raise ParameterError(f"{NAME}.events: {onsets.size} onsets, must be one, before all else")
        return int(onsets[0])


def counted(memory: Memory) -> dict[str, int]:
    """Return what went wrong so far: inputs that found no synapse, and detectors near a tie, by name."""
    return {"overflowed": int(memory.counts[OVERFLOW]), "undecided": int(memory.counts[UNDECIDED])}


def _charge(addresses: I64, times: F64, begin: int, count: int) -> tuple[int, float]:
    """Number and time of the first event of a range of addresses, -1 for none."""
    mine = np.flatnonzero((addresses >= begin) & (addresses < begin + count))
    return (int(addresses[mine[0]]) - begin, float(times[mine[0]])) if mine.size else (-1, 0.0)
