"""Behavioural model of the first-target isolation board, which stops excitation after the first echo.

Same ports as the circuit: events spike[k] and call in, v_ex_max (analog) out. A latch with measured delays:
isolated from `spike + set_delay` on, open from `call + reset_delay` on. A call wins while its pulse lasts; a
spike whose pulse outlasts it, because it comes later than `call + tie`, isolates the array at
`call + held_delay`. A spike within 20 ns of that tie is counted as undecided. The output jumps between its
two measured levels; numbers from `chips.boards.isolation.measure`. It has no noise: that of the latch moves a
delay by 2 ps, 0.3 % of this model's own error, and that of the gates the excitation by a thousandth of a per
cent (`noctule reproduce chip-noise`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from chips.measured.table_record import all_on_silicon, tables_on
from chips.part import Analog, Event, Output, Unforeseen
from circuits.blocks.sonar import first_target_isolation
from circuits.circuit import Circuit
from circuits.event import LENGTH
from circuits.silicon.silicon import Silicon

UNSURE = 20e-9  # s, about the tie; ours, above twice its error on dies that the record has not seen


@dataclass(frozen=True, slots=True)
class IsolationState:
    """State of a first-target isolation board.

    time: reached, s; isolated: whether echoes are blocked; pending: changes to come in order, as times (s)
    and whether the array is isolated then; call, spike: times of the last of each, s; undecided: spikes so
    near to a tie with a call that either may win.
    """

    time: float
    isolated: bool = False
    pending: tuple[tuple[float, bool], ...] = ()
    call: float = -math.inf
    spike: float = -math.inf
    undecided: int = 0


@cache
def circuits() -> tuple[Circuit, ...]:
    """Return the circuit that the model stands for."""
    return (first_target_isolation.build(),)


class IsolationModel(Unforeseen):
    """A first-target isolation board on a silicon.

    v_ex_max: voltage to which its open output is set, V, the board's own unless given, of which the record
    is; path: the instance path named in errors. Raises `ParameterError` for silicon outside the record's box,
    and `DataError` where the record is of another circuit.
    """

    def __init__(
        self, silicon: Silicon, path: str = "first_target_isolation", v_ex_max: float | None = None
    ) -> None:
        """Read the record at the silicon's temperature and die."""
        data = tables_on(silicon, "first_target_isolation", circuits, path)
        names = ("open_V", "isolated_V", "set_delay_s", "reset_delay_s", "held_delay_s", "tie_s")
        values = (float(value) for value in all_on_silicon(data, names, silicon))
        self.open_level, self.isolated_level, self.set, self.reset, self.held, self.tie = values
        if v_ex_max is not None:  # the open gate carries no current
            self.open_level += v_ex_max - first_target_isolation.V_EX_MAX
        self.analog: tuple[str, ...] = ("v_ex_max",)

    def begin(self, time: float = 0.0) -> IsolationState:
        """Return the state at `time` s, open for echoes."""
        return IsolationState(time)

    def advance(
        self, state: IsolationState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[IsolationState, float, Output]:
        """Advance to `until` s; the output voltage jumps at each change."""
        time, level = [state.time], [self._level(state)]
        for port, moment in sorted(events, key=lambda e: (e[1], e[0] != "call")):
            state = self._called(state, moment) if port == "call" else self._spiked(state, moment)
        while state.pending and state.pending[0][0] <= until:
            (moment, isolated), *rest = state.pending
            if isolated != state.isolated:
                # jumps lie strictly inside, and after what is already there
                before = max(moment, math.nextafter(time[-1], math.inf))
                time += [before, math.nextafter(before, math.inf)]
                level += [self._level(state), self.isolated_level if isolated else self.open_level]
            state = replace(state, isolated=isolated, pending=tuple(rest))
        if until > time[-1]:
            time.append(until)
            level.append(level[-1])
        return replace(state, time=until), until, Output((), np.array(time), np.array(level)[:, None])

    def _called(self, state: IsolationState, call: float) -> IsolationState:
        """The array opens, and closes again after the call where a spike's pulse outlasts it."""
        if call < state.call + LENGTH:
            return state
        opens = call + self.reset
        pending = [p for p in state.pending if p[0] <= opens] + [(opens, False)]
        lag = state.spike - call
        if lag > self.tie:
            pending.append((call + self.held, True))
        return replace(state, pending=tuple(pending), call=call, undecided=state.undecided + self._near(lag))

    def _spiked(self, state: IsolationState, spike: float) -> IsolationState:
        """The array is isolated, at the call's end where the spike comes during one."""
        lag = spike - state.call
        unsure = state.undecided + self._near(lag)
        after = replace(state, spike=spike, undecided=unsure)
        if lag <= self.tie:
            return after
        closes = max(spike + self.set, state.call + self.held)
        return replace(after, pending=tuple(sorted((*state.pending, (closes, True)))))

    def _near(self, lag: float) -> bool:
        return abs(lag - self.tie) < UNSURE

    def _level(self, state: IsolationState) -> float:
        return self.isolated_level if state.isolated else self.open_level
