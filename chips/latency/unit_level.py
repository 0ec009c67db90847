"""A latency unit of the chip at transistor level inside a run: the same devices, stepped by the solver.

The unit stands at its place on the chip with the chip's biases. Taps and the integrating neuron are the
model's events, which become pulses at its ports; the first rise of its output after a ping is its spike.
Between pings the unit runs on, its tonic neuron and its long inhibition included. At another temperature the
transistors and the lines are that temperature's, and the nodes' voltages go on: charges are kept, the blocks'
capacitors being the same at all temperatures.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from chips.latency.design import Biases
from chips.latency.place import UNIT_WIRES, bench_at, line_volts, standing
from circuits.arrays import F64
from circuits.blocks.latency import unit as latency_unit
from circuits.devices.source import Polyline
from circuits.event import EDGE, WIDTH
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.temperature import moved
from circuits.solver.transient import Runner

AFTER = 4.5e-3  # s that a run goes on after a ping's last input, more than a window; ours
SETTLE = 20e-6  # s, ours: the first reset


class TransistorUnit:
    """Unit `unit` of memory `memory` at transistor level on a silicon, with the chip's biases."""

    def __init__(
        self, biases: Biases, silicon: Silicon, memory: int, unit: int, record: tuple[str, ...] = ()
    ) -> None:
        """Prepare the unit and find its rest state; record: nodes whose voltages are kept in `kept`."""
        self.biases, self.silicon, self.place, self.record = biases, silicon, (memory, unit), record
        self.v_dd = silicon.process.v_dd
        machine = self._machine(silicon)
        self.runner = Runner(machine, record)
        self.kept: list[tuple[F64, F64]] = []
        self.state = self.runner.begin(operating_point(machine))
        self.resets: list[float] = [SETTLE]

    def _machine(self, silicon: Silicon) -> Machine:
        memory, unit = self.place
        volts = line_volts(self.biases, silicon, UNIT_WIRES, {})
        bench = bench_at("latency unit", latency_unit.build(), volts, {}, math.inf, self.v_dd)
        return to_kernel(bench, standing(silicon, ("memory", (memory,)), ("unit", (unit,))))

    def move(self, temperature_c: float, now: float) -> None:
        """Go on at another temperature (degC) from `now` (s) on, which is after the last ping's run."""
        self.advance(now)
        self.silicon = replace(self.silicon, temperature_c=temperature_c)
        self.runner, self.state = moved(self.runner, self.state, self._machine(self.silicon))

    def advance(self, until: float) -> tuple[tuple[str, float], ...]:
        """Run on to a time, s, with the resets that were asked for, and return its spikes (port, s)."""
        inputs = {"reset": self._pulses(self.resets)}
        self.resets = []
        return self._run(until, inputs)

    def ping(self, start: float, tap: float, spoken: float) -> float:
        """Return the latency of its spike after a ping at `start` (s), s, inf for none.

        tap, spoken: latencies of its inputs, s, inf for none.
        """
        heard = [t for t in (tap, spoken) if t < math.inf]
        inputs = {
            "tap": self._pulses([start + tap]),
            "integrating": self._pulses([start + spoken] if spoken < math.inf else []),
            "reset": self._pulses(self.resets),
        }
        self.resets = []
        spikes = self._run(start + max(heard) + AFTER, inputs)
        mine = [t - start for _, t in spikes if t >= start]
        return mine[0] if mine else math.inf

    def _run(self, until: float, inputs: Mapping[str, Polyline]) -> tuple[tuple[str, float], ...]:
        self.state, segment = self.runner.advance(self.state, until, inputs, stop_at_event=False)
        if segment.voltage.shape[1]:
            self.kept.append((segment.time, segment.voltage))
        return segment.spikes

    def reset(self, at: float) -> None:
        """Ask for a reset at a time, s, which must be after the last ping's run."""
        self.resets.append(at)

    def _pulses(self, times: Sequence[float]) -> Polyline:
        """Events at these times from now on, as a polyline."""
        at, volts = [self.state.now], [0.0]
        for t in sorted(times):
            at += [t, t + EDGE, t + EDGE + WIDTH, t + 2.0 * EDGE + WIDTH]
            volts += [0.0, self.v_dd, self.v_dd, 0.0]
        return np.array(at), np.array(volts)
