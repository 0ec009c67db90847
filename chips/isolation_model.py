"""First-target isolation at behavioural level: from the array's first spike to the next call no excitation.

Same ports as the circuit: events spike[k] and call in, v_ex_max (analog) out: the supply while the array is
isolated, else the bias `v_ex_max_set`. A call wins over a spike of the same instant. The circuit's delays,
below 0.2 us, are left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.cell import Event, Output
from circuits.bias import bias_voltages
from circuits.blocks import first_target_isolation
from circuits.devices.source import Polyline
from circuits.silicon import Silicon


@dataclass(frozen=True, slots=True)
class IsolationState:
    """Time reached (s), and whether the array is isolated."""

    time: float
    isolated: bool = False


class IsolationModel:
    """A first-target isolation board on `silicon`."""

    def __init__(self, silicon: Silicon) -> None:
        """Take the two levels of the output from the circuit."""
        circuit = first_target_isolation.build()
        given = bias_voltages(circuit, circuit.bias("v_ex_max_set"), silicon)
        self.open_level = float(np.ravel(given)[0])
        self.isolated_level = silicon.process.v_dd
        self.analog: tuple[str, ...] = ("v_ex_max",)

    def begin(self, time: float = 0.0) -> IsolationState:
        """Open at `time` s."""
        return IsolationState(time)

    def next_time(self, state: IsolationState) -> float:
        """The board makes no events; inf."""
        return math.inf

    def advance(
        self,
        state: IsolationState,
        until: float,
        events: Sequence[Event] = (),
        analog: Mapping[str, Polyline] | None = None,
    ) -> tuple[IsolationState, float, Output]:
        """Advance to `until` (s); the output jumps at each change."""
        time, level = [state.time], [self._level(state)]
        for port, moment in sorted(events, key=lambda e: (e[1], e[0] == "call")):
            before, state = state, replace(state, isolated=port != "call")
            if before.isolated == state.isolated:
                continue
            if moment > time[-1]:
                time.append(moment)
                level.append(self._level(before))
                time.append(math.nextafter(moment, math.inf))
                level.append(self._level(state))
            else:
                level[-1] = self._level(state)
        if until > time[-1]:
            time.append(until)
            level.append(level[-1])
        return replace(state, time=until), until, Output((), np.array(time), np.array(level)[:, None])

    def _level(self, state: IsolationState) -> float:
        return self.isolated_level if state.isolated else self.open_level
