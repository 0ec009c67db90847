"""The wavefront chip as a part of a running system: a start goes in, spikes of the wave come out.

An event on `start[k]` resets the chip and fires cell k, its number in the chip's order; from then on
`fired[k]` comes as the spikes leave the bus, until the goal has fired, where there is one. A wave is
`WavefrontChip.plan`'s, whole, at the start's time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chips.part import Analog, Event, Output, next_due, port_index, tell
from chips.wavefront.chip import Place, Program, WavefrontChip
from circuits.devices.source import Polyline


@dataclass(frozen=True, slots=True)
class WaveState:
    """State of a wavefront chip in a loop.

    time: reached, s; due: spikes to come, in order; waves: how many were started; dropped: spikes, by the
    bus.
    """

    time: float
    due: tuple[Event, ...] = ()
    waves: int = 0
    dropped: int = 0


class WavefrontPart:
    """A wavefront chip with a program, in a loop.

    It has no analog ports, so that `analog` is empty.

    Parameters
    ----------
    chip
        The chip.
    program
        Codes of its cells.
    goal
        Cell at which every wave ends; none unless given.
    temperature
        Temperature, degC, or times (s) and temperatures, which waves follow; the silicon's unless given.
    path
        What errors call it.
    """

    analog: tuple[str, ...] = ()

    def __init__(
        self,
        chip: WavefrontChip,
        program: Program,
        goal: Place | None = None,
        temperature: float | Polyline | None = None,
        path: str = "wavefront_chip",
    ) -> None:
        """Take a chip and its program.

        temperature: as of `WavefrontChip.plan`; path: named in errors.
        """
        self.chip, self.program, self.goal, self.temperature = chip, program, goal, temperature
        self.path = path

    def begin(self, time: float = 0.0) -> WaveState:
        """Return the state after a reset at `time` s."""
        return WaveState(time)

    def next_time(self, state: WaveState) -> float:
        """Return the time of the next spike in `state`, s, inf where no wave runs."""
        return next_due(state)

    def advance(
        self, state: WaveState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[WaveState, float, Output]:
        """Advance `state` to `until` s or to the first spike, as `chips.part.Part` says.

        Spikes of one moment come together. `events` are those of ports `start[cell]`, which start a wave;
        `analog` takes no part, since there are no analog ports.
        """
        for port, time in sorted(events, key=lambda e: e[1]):
            state = self._started(state, port, time)
        return tell(state, until)

    def _started(self, state: WaveState, port: str, time: float) -> WaveState:
        shape = self.chip.shape
        number = port_index(port, "start", math.prod(shape), self.path)
        place = tuple(int(k) for k in np.unravel_index(number, shape))
        start: Place = (place[0], place[1]) if len(place) == 2 else place[0]
        plan = self.chip.plan(
            self.program, start, self.goal, temperature=self.temperature, time=time, number=state.waves
        )
        spikes = plan.events()
        due = tuple(
            (f"fired[{k}]", time + t)
            for t, k in zip(spikes.times.tolist(), spikes.addresses.tolist(), strict=True)
        )
        return WaveState(state.time, due, state.waves + 1, state.dropped + spikes.dropped)
