"""A latency unit of the chip at transistor level inside a run: the same devices, stepped by the solver.

The unit stands at its place on the chip with the chip's biases. Taps and the integrating neuron are the
model's events, which become pulses at its ports; the first rise of its output after a ping is its spike.
Between pings the unit runs on, its tonic neuron and its long inhibition included.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chips.latency_design import Biases
from chips.latency_place import UNIT_WIRES, bench_at, line_volts, standing
from circuits.blocks import latency_unit
from circuits.blocks.latency_synapse import EDGE, WIDTH
from circuits.devices.source import Polyline
from circuits.lowering.kernel import to_kernel
from circuits.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner

F64 = NDArray[np.float64]

AFTER = 4.5e-3  # s that a run goes on after a ping's last input, more than a window; ours
SETTLE = 20e-6  # s, ours: the first reset


class TransistorUnit:
    """Unit `unit` of memory `memory` on the silicon with the chip's biases, after a reset."""

    def __init__(
        self, biases: Biases, silicon: Silicon, memory: int, unit: int, record: tuple[str, ...] = ()
    ) -> None:
        """Build the machine and its state of rest; record: nodes whose voltages are kept in `kept`."""
        volts = line_volts(biases, silicon, UNIT_WIRES, {})
        self.v_dd = silicon.process.v_dd
        bench = bench_at("latency unit", latency_unit.build(), volts, {}, math.inf, self.v_dd)
        placed = standing(silicon, ("memory", (memory,)), ("unit", (unit,)))
        machine = to_kernel(bench, placed)
        self.runner = Runner(machine, record)
        self.kept: list[tuple[F64, F64]] = []
        self.state = self.runner.begin(operating_point(machine))
        self.resets: list[float] = [SETTLE]

    def ping(self, start: float, tap: float, spoken: float) -> float:
        """Latency of its spike after a ping at `start`, s, or inf; tap, spoken: its inputs', s, or inf."""
        heard = [t for t in (tap, spoken) if t < math.inf]
        inputs = {
            "tap": self._pulses([start + tap]),
            "integrating": self._pulses([start + spoken] if spoken < math.inf else []),
            "reset": self._pulses(self.resets),
        }
        self.resets = []
        until = start + max(heard) + AFTER
        self.state, segment = self.runner.advance(self.state, until, inputs, stop_at_event=False)
        if segment.voltage.shape[1]:
            self.kept.append((segment.time, segment.voltage))
        mine = [t - start for _, t in segment.spikes if t >= start]
        return mine[0] if mine else math.inf

    def reset(self, at: float) -> None:
        """A reset at a time, s, which has to be after the last ping's run."""
        self.resets.append(at)

    def _pulses(self, times: Sequence[float]) -> Polyline:
        """Events at these times from now on, as a polyline."""
        at, volts = [self.state.now], [0.0]
        for t in sorted(times):
            at += [t, t + EDGE, t + EDGE + WIDTH, t + 2.0 * EDGE + WIDTH]
            volts += [0.0, self.v_dd, self.v_dd, 0.0]
        return np.array(at), np.array(volts)
