"""Behavioural model of the vocalization controller, as a part of a running system.

Same ports as the circuit, which is enabled from the start on: proximity and amplitude_control (analog) in,
call (event) and amplitude (analog) out. The phase grows with the measured linear rate; a call comes when it
reaches one, and the next interval begins after the measured length of the call. The amplitude is linear.
Equations in `chips.boards.vocalization.kernel`, numbers from `chips.boards.vocalization.measure`, noise from
`chips.boards.vocalization.noise`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from chips.boards.vocalization.kernel import Vocalization, vocalization_run
from chips.boards.vocalization.noise import oscillator_noise, phase_after_call
from chips.measured.table_record import all_on_silicon, tables_on, temperature_weights
from chips.noise import SiliconNoise
from chips.part import Analog, Event, Output, Unforeseen
from circuits.arrays import F64
from circuits.blocks.sonar import vocalization_controller
from circuits.circuit import Circuit
from circuits.devices.source import Polyline
from circuits.lowering.on_die import on_die
from circuits.silicon.silicon import Silicon

_SILENT: Polyline = (np.zeros(1), np.zeros(1))


@dataclass(frozen=True, slots=True)
class VocalizationState:
    """State of a vocalization controller.

    time: reached, s; phase: of the oscillator, 1 at a call; free: when the phase begins to grow, s; lines:
    polylines of the analog inputs in force; calls: that were made so far.
    """

    time: float
    phase: float
    free: float
    lines: Mapping[str, Polyline] = field(default_factory=dict)
    calls: int = 0


@cache
def circuits() -> tuple[Circuit, ...]:
    """Return the circuit that the model stands for."""
    return (vocalization_controller.build(),)


class VocalizationModel(Unforeseen):
    """A vocalization controller on a silicon, with the mismatch of its current mirror alone.

    path: the instance path named in errors; noise: of its devices, none unless given. Raises `ParameterError`
    for silicon outside the record's box, and `DataError` where the record is of another circuit.
    """

    def __init__(
        self, silicon: Silicon, path: str = "vocalization_controller", noise: SiliconNoise | None = None
    ) -> None:
        """Read the record at the silicon's temperature and die."""
        data = tables_on(silicon, "vocalization_controller", circuits, path)
        names = ("base_Hz", "slope_Hz_per_V", "dead_time_s", "first_phase", "amplitude_V", "amplitude_slope")
        values = [float(value) for value in all_on_silicon(data, names, silicon)]
        at = temperature_weights(data, silicon.temperature_c)
        by_mirror = np.tensordot(at, data["mirror"], (0, 0)) @ mirror_mismatch(silicon)
        base, slope = (v * math.exp(x) for v, x in zip(values[:2], by_mirror, strict=True))
        dead, first, amplitude, amplitude_slope = values[2:]
        self.numbers = Vocalization(
            base, slope, dead, first, amplitude, amplitude_slope, silicon.process.v_dd
        )
        self.noise = oscillator_noise(self.numbers, silicon, noise)
        self.analog: tuple[str, ...] = ("amplitude",)

    def begin(self, time: float = 0.0) -> VocalizationState:
        """Return the state of a controller that is enabled at `time` s."""
        return VocalizationState(time, -self.numbers.first, time)

    def advance(
        self, state: VocalizationState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[VocalizationState, float, Output]:
        """Advance to `until` s or to the first call."""
        lines = {**state.lines, **(analog or {})}
        oscillator = np.array([state.phase, state.free])
        time, value = lines.get("proximity", _SILENT)
        call = vocalization_run(self.numbers, oscillator, time, value, state.time, until)
        reached, calls = min(call, until), state.calls
        if call <= until:
            rate = self.numbers.base + self.numbers.slope * float(np.interp(call, time, value))
            oscillator[0] += phase_after_call(self.noise, calls, rate)
            calls += 1
        control, level = lines.get("amplitude_control", _SILENT)
        inside = control[(control > state.time) & (control < reached)]
        moments = np.concatenate([[state.time], inside, [reached]])
        base, slope = self.numbers.amplitude_base, self.numbers.amplitude_slope
        amplitude = np.clip(base + slope * np.interp(moments, control, level), 0.0, self.numbers.v_dd)
        found = (("call", call),) if call <= until else ()
        after = VocalizationState(reached, float(oscillator[0]), float(oscillator[1]), lines, calls)
        return after, reached, Output(found, moments, amplitude[:, None])


def mirror_mismatch(silicon: Silicon) -> F64:
    """Return how the current mirror's output transistor differs from its input: V_T0 (V) and ln beta."""
    (circuit,) = circuits()
    d = on_die(circuit, silicon, ("m_out", "m_in"))
    return d.offset("m_out") - d.offset("m_in")
