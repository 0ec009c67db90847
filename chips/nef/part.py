"""A network on the NEF chip as a part of a running system: nodes take its inputs, probes show its outputs.

Analog inputs `node[k]` are read at the beginning of each interval, in which a node stands still, and put on
the lanes; analog outputs `probe[k]` are the probes' values, known from the end of an interval until the next
one's. An interval is `chips.nef.simulation`'s, run when its end is reached. It makes no events.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from chips.nef.build import Built
from chips.nef.network.kernel import DT
from chips.nef.simulation import Simulation, SimulationState
from chips.part import Analog, Event, Output, port_index
from circuits.arrays import F64
from circuits.devices.source import Polyline
from circuits.errors import unknown_name


@dataclass(frozen=True, slots=True)
class NefState:
    """State of a network in a loop.

    time: reached, s; start: of the first interval, s; intervals: how many have run; simulation: state of the
    network; lines: polylines of the inputs in force.
    """

    time: float
    start: float
    intervals: int
    simulation: SimulationState
    lines: Mapping[str, Polyline] = field(default_factory=dict)


class NefPart:
    """A built network in a loop.

    Parameters
    ----------
    built
        The network, ready to run.
    outputs
        Names of the probes that are reported.
    interval
        Time between two readings of its inputs, s.
    path
        What errors call it.

    Raises
    ------
    ParameterError
        The interval is no whole number of steps.
    UnknownNameError
        There is no such probe.
    """

    def __init__(
        self, built: Built, outputs: Sequence[str], interval: float = DT, path: str = "nef_chip"
    ) -> None:
        """Take a network.

        Raises `ParameterError` unless an interval has whole steps, and `UnknownNameError` for other probes.
        """
        for name in outputs:
            if name not in built.read:
                raise unknown_name(f"{path} probe", name, built.read)
        self.interval, self.path = interval, path
        self._simulation = Simulation(built, interval)
        self._first = self._simulation.snapshot()
        self._outputs = tuple(outputs)
        sizes = [self._simulation.read(name).size for name in outputs]
        self.analog = tuple(f"{n}[{k}]" for n, size in zip(outputs, sizes, strict=True) for k in range(size))

    def begin(self, time: float = 0.0) -> NefState:
        """Return the state at rest at `time` s."""
        return NefState(time, time, 0, self._first)

    def next_time(self, state: NefState) -> float:
        """Return the end of the interval that runs in `state`, s."""
        return state.start + (state.intervals + 1) * self.interval

    def advance(
        self, state: NefState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[NefState, float, Output]:
        """Advance `state` to `until` s, as `chips.part.Part` says.

        `analog` has values of nodes. The network has no port for `events`: any raises `UnknownNameError`.
        """
        for port, _ in events:
            raise unknown_name(f"{self.path} event port", port, [])
        lines = {**state.lines, **(analog or {})}
        run = self._simulation
        run.restore(state.simulation)
        times, values = [state.time], [self._shown()]
        done, end = state.intervals, self.next_time(state)
        while end <= until:
            self._drive(lines, end - self.interval)
            run.advance(self.interval)
            # what is shown jumps at the interval's end
            times += [max(times[-1], np.nextafter(end, -np.inf)), end]
            values += [values[-1], self._shown()]
            done += 1
            end = state.start + (done + 1) * self.interval
        if until > times[-1]:
            times.append(until)
            values.append(values[-1])
        after = NefState(until, state.start, done, run.snapshot(), lines)
        return after, until, Output((), np.array(times), np.array(values))

    def _shown(self) -> F64:
        return np.concatenate([np.zeros(0), *(self._simulation.read(name) for name in self._outputs)])

    def _drive(self, lines: Mapping[str, Polyline], time: float) -> None:
        """Put what the lines are at a time, s, on the nodes."""
        given = self._simulation.built.given
        for port, line in lines.items():
            name = port.partition("[")[0]
            if name not in given:
                raise unknown_name(f"{self.path} node", name, given)
            values = self._simulation.given(name)
            values[port_index(port, name, values.size, self.path)] = float(np.interp(time, *line))
            self._simulation.set(name, values)
