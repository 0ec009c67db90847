"""A circuit of transistors as a part of a running system: events and voltages go in and come out.

At the boundary an event becomes a 10 us full-supply pulse with 0.1 us edges, an upward half-supply
crossing becomes an event, and analog ports carry polylines. Every cell is stepped by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from chips.part import Analog, Event, Output, Unforeseen
from circuits.arrays import F64
from circuits.circuit import Circuit, Port
from circuits.devices import Source
from circuits.devices.source import Constant, Driven, Polyline, Sampled, Waveform
from circuits.errors import TopologyError
from circuits.event import EDGE, LENGTH, WIDTH
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.temperature import at_temperature, moved
from circuits.solver.transient import DEFAULT_RTOL, Runner, State
from circuits.testbench import Testbench


@dataclass(frozen=True, slots=True)
class CellState:
    """State of the solver, and how many events were lost.

    merged: events that fell into the pulse of the one before them, and were lost in it.
    """

    solver: State
    merged: int = 0


class Cell(Unforeseen):
    """A circuit that is simulated while a system runs, with its supply and biases, its other inputs driven.

    A step of the solver ends where a span does, so that the spans of a run move its events within
    the solver's error: spikes of the rebound neuron on four dies by at most 8 ns, in spans of 1 ms.

    Parameters
    ----------
    circuit
        The circuit.
    silicon
        Process, temperature and die.
    analog
        Ports or nodes whose waveforms are reported.
    sampled
        Input ports that take samples, by their rate in Hz.
    held
        Voltages (V) of analog inputs until something drives them, by port.
    rtol
        Relative tolerance of the solver, dimensionless.
    start
        Voltages (V) by node near the rest state that is meant, where a circuit has several.

    Raises
    ------
    SolverError
        The circuit has no rest state.
    """

    def __init__(
        self,
        circuit: Circuit,
        silicon: Silicon,
        analog: Sequence[str] = (),
        sampled: Mapping[str, float] | None = None,
        held: Mapping[str, float] | None = None,
        rtol: float = DEFAULT_RTOL,
        start: Mapping[str, float] | None = None,
    ) -> None:
        """Prepare the circuit for the solver and find its rest state.

        Raises `SolverError` where it has none.
        """
        self.v_dd = silicon.process.v_dd
        sources: list[Source] = []
        watch: list[str] = []
        biased = {b.port for b in circuit.biases}
        for port in circuit.ports:
            elements = port.elements()
            if port.direction == "out":
                watch += elements if port.kind == "event" else []
                continue
            for element in elements:
                if element in (held or {}) or port.name not in biased:
                    waveform = self._drive(port, element, sampled or {}, held or {})
                    sources.append(Source(element, element, waveform))
        bench = Testbench(circuit.name, circuit, tuple(sources), np.inf, tuple(watch))
        self.machine: Machine = to_kernel(bench, silicon)
        self.analog = tuple(analog)
        self.runner = Runner(self.machine, self.analog, rtol)
        self._columns = [self.machine.column_of(n) for n in self.analog]
        self._rest = operating_point(self.machine, start=start)

    def _drive(
        self, port: Port, element: str, sampled: Mapping[str, float], held: Mapping[str, float]
    ) -> Waveform:
        if port.kind == "supply":
            return Constant(self.v_dd)
        if port.kind == "event":
            return Driven(0.0)
        if element in sampled:
            return Sampled(0.0, sampled[element], np.array([held[element]]))
        if element in held:
            return Driven(held[element])
        raise TopologyError(f"{element}: input port without a bias or a held voltage; give one")

    def begin(self, time: float = 0.0) -> CellState:
        """Return the state at rest at `time` s."""
        return CellState(self.runner.begin(self._rest, time))

    def drive(self, state: CellState, lines: Mapping[str, Polyline]) -> CellState:
        """Return the state with new polylines on analog inputs, in force until others replace them.

        Parameters
        ----------
        lines
            Times (s) and voltages (V), float64[T] each, by input.
        """
        names = self.machine.source_names
        held = list(state.solver.lines)
        for name, line in lines.items():
            held[names.index(name)] = line
        return replace(state, solver=replace(state.solver, lines=tuple(held)))

    def moved(self, state: CellState, temperature_c: float) -> tuple[Cell, CellState]:
        """Return the circuit at `temperature_c` (degC), to go on with from `state`; all voltages stay."""
        other = copy(self)
        machine = at_temperature(self.machine, temperature_c)
        other.runner, solver = moved(self.runner, state.solver, machine)
        other.machine = other.runner.machine
        return other, replace(state, solver=solver)

    def voltages(self, state: CellState) -> F64:
        """Return the voltages of the analog ports in `state`, V, float64[ports]."""
        return np.asarray(state.solver.voltage[0][self._columns])

    def advance(
        self, state: CellState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[CellState, float, Output]:
        """Advance to `until` s or to the first output event.

        It returns the new state, the time that was reached (s), and the output.

        Parameters
        ----------
        events
            New input events at or after the state's time.
        analog
            New polylines of analog inputs.
        """
        inputs: dict[str, Polyline] = dict(analog or {})
        merged = state.merged
        for port, time in events:
            line = inputs.get(port) or state.solver.lines[self.machine.source_names.index(port)]
            inputs[port], clash = add_pulse(line, time, self.v_dd)
            merged += clash
        start, first = state.solver.now, self.voltages(state)
        solver, segment = self.runner.advance(state.solver, until, inputs)
        output = Output(
            segment.spikes,
            np.concatenate([[start], segment.time]),
            np.concatenate([first[None, :], segment.voltage]),
        )
        return replace(state, solver=solver, merged=merged), solver.now, output


def add_pulse(line: Polyline, time: float, v_dd: float) -> tuple[Polyline, int]:
    """Append an event's pulse to a polyline; return the polyline, and 1 where the event was merged, else 0.

    An event inside the last pulse is merged with it. time: of the event, s; v_dd: height of the pulse, V.
    """
    last_time, last_value = float(line[0][-1]), float(line[1][-1])
    corners = time + np.array([0.0, EDGE, EDGE + WIDTH, LENGTH])
    if line[0].size > 1 and time <= last_time:
        return line, 1
    return (
        np.concatenate([[min(last_time, time - 1e-9)], corners]),
        np.array([last_value, last_value, v_dd, v_dd, 0.0]),
    ), 0
