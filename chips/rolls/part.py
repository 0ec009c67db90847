"""The ROLLS chip as a part of a running system: events go in, spikes come out as they leave its bus.

Inputs are events on `in[A]` with the address A = neuron + (column << 8) of a synapse, outputs `out[k]` the
spikes of neuron k. The chip takes whole steps: one is run when its end is reached, as what comes in during a
step counts from its beginning on. So a spike is told at the end of the step that it is in, with its own time;
steps are the chip's resolution in time, and its bus is never idle between them, as it is between runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from chips.aer import IDLE, Events, send_on
from chips.part import Analog, Event, Output, port_index, quiet
from chips.rolls.chip import ChipState, RollsChip
from chips.rolls.input_check import check_inputs
from chips.rolls.program.address import COLUMNS, NEURONS
from circuits.arrays import F64


@dataclass(frozen=True, slots=True)
class RollsState:
    """State of a ROLLS chip in a loop.

    time: reached, s; start: of the first step, s; steps: how many have run; chip: state after these; waiting:
    events that count in the step that runs, (s, address); due: spikes on their way out, in order; into, out:
    when what is on the buses is delivered, s; lost_in, lost_out, held: as of `Spikes`.
    """

    time: float
    start: float
    steps: int
    chip: ChipState
    waiting: tuple[tuple[float, int], ...] = ()
    due: tuple[Event, ...] = ()
    into: F64 = field(default_factory=lambda: IDLE)
    out: F64 = field(default_factory=lambda: IDLE)
    lost_in: int = 0
    lost_out: int = 0
    held: int = 0


class RollsPart:
    """A ROLLS chip in a loop, at its silicon's temperature.

    It has no analog ports, so that `analog` is empty. Errors call `chip` by `path`.
    """

    analog: tuple[str, ...] = ()

    def __init__(self, chip: RollsChip, path: str = "rolls") -> None:
        self.chip, self.path = chip, path

    def begin(self, time: float = 0.0) -> RollsState:
        """Return the state at rest at `time` s."""
        return RollsState(time, time, 0, replace(self.chip.at_rest(), time=time))

    def next_time(self, state: RollsState) -> float:
        """Return the end of the step that runs in `state`, or the time of the next spike to be sent, s."""
        end = self._end(state)
        return min(end, state.due[0][1]) if state.due else end

    def advance(
        self, state: RollsState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[RollsState, float, Output]:
        """Advance `state` to `until` s, or to where the first spikes are sent, as `chips.part.Part` says.

        `events` are those of ports `in[address]`; `analog` takes no part, since there are no analog ports.
        """
        if events:
            come = [(t, port_index(port, "in", COLUMNS * NEURONS, self.path)) for port, t in events]
            times, words = np.array([t for t, _ in come]), np.array([a for _, a in come], dtype=np.int64)
            check_inputs(times, words & 255, words >> 8, state.time, self.chip.program)
            state = replace(state, waiting=(*state.waiting, *come))
        while True:
            moment = min(until, self.next_time(state))
            if self._end(state) <= moment:
                state = self._stepped(state)
            now = tuple(e for e in state.due if e[1] <= moment)
            state = replace(state, time=moment, due=state.due[len(now) :])
            if now or moment >= until:
                return state, moment, quiet(moment, now)

    def _end(self, state: RollsState) -> float:
        return state.start + (state.steps + 1) * self.chip.step

    def _stepped(self, state: RollsState) -> RollsState:
        """The state after one more step of the chip."""
        end = self._end(state)
        mine = [e for e in state.waiting if e[0] < end]
        times, words = np.array([t for t, _ in mine]), np.array([a for _, a in mine], dtype=np.int64)
        arrived, into = send_on(self.chip.bus, state.into, times, words)
        begun = replace(state.chip, time=state.start + state.steps * self.chip.step)
        times, neurons, after, held = self.chip.run_steps(begun, 1, arrived)
        left, out = send_on(self.chip.bus, state.out, times, neurons)
        return replace(
            state,
            steps=state.steps + 1,
            chip=after,
            waiting=tuple(e for e in state.waiting if e[0] >= end),
            due=(*state.due, *_spikes(left)),
            into=into,
            out=out,
            lost_in=state.lost_in + arrived.dropped,
            lost_out=state.lost_out + left.dropped,
            held=state.held + held,
        )


def _spikes(left: Events) -> list[Event]:
    return [(f"out[{k}]", t) for t, k in zip(left.times.tolist(), left.addresses.tolist(), strict=True)]
