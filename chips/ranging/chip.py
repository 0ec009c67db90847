"""Behavioural model of the ranging chip, as a part of a running system.

Same ports and same silicon as the circuit: events call and echo in, spike[k] out, v_ex_max analog in. The
neurons are those of `chips.ranging.model`; outside the validity box of their record the chip refuses with the
instance path, or goes on with a warning (`chips.validity`). Temperature is an analog input too (port
`temperature`, degC); a release under way moves in proportion to t_inh.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from chips.codes import Codes
from chips.noise import SiliconNoise
from chips.part import Analog, Event, Output
from chips.ranging import circuit as ranging_chip
from chips.ranging.calibration.found import values_of
from chips.ranging.law import Neurons
from chips.ranging.model import Located, ReboundModel, check_box, model_of, neurons_on, with_biases
from chips.ranging.neuron_kernel import Looked, bring, call, echo, go_on, look_all, resting
from chips.ranging.noise import Jitter, copied, new_jitter, next_durations
from chips.ranging.record import ReboundRecord
from chips.ranging.temperature import move_releases
from chips.validity import require_inside
from circuits.arrays import F64, I64
from circuits.bias import rebias
from circuits.circuit import BiasKind, Circuit
from circuits.devices.source import Polyline
from circuits.errors import unknown_name
from circuits.event import LENGTH
from circuits.silicon.course import STEP
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

_INPUTS = ("call", "echo")
ABOVE_SUPPLY = 0.1  # V, by which v_ex_max may pass the supply


NoiseState = tuple[F64, F64, I64]  # relaxations, time of the last call (s), calls


@dataclass(frozen=True, slots=True)
class ChipState:
    """State of a ranging chip.

    time: reached, s; neurons: as they were looked at, and what lies ahead of them; temperature_c: degC;
    pending: events that were handed in early; last: times of the last call and of the last echo, s; lines:
    polylines of the analog inputs in force; merged: events that fell into the pulse of the one before;
    noise_state: what noise carries from call to call, None without noise.
    """

    time: float
    neurons: Looked
    temperature_c: float
    pending: tuple[Event, ...] = ()
    last: tuple[float, float] = (-math.inf, -math.inf)
    lines: Mapping[str, Polyline] | None = None
    merged: int = 0
    noise_state: NoiseState | None = None

    @property
    def undecided(self) -> int:
        """How many moments there were at which a spike was too near to call."""
        return self.neurons.undecided


@lru_cache(maxsize=8)
def shipped_model(process: Process, bias_kind: BiasKind | None = None) -> ReboundModel:
    """Return the model of the ranging chip in a process, its biases all of a kind, or as built."""
    return model_of(rebias(ranging_chip.build(), kind=bias_kind), process)


def coded_model(process: Process, bias_kind: BiasKind, codes: Codes | None) -> ReboundModel:
    """Return the model of the ranging chip in a process at codes, with its biases as built without any."""
    model = shipped_model(process, bias_kind)
    return model if codes is None else with_biases(model, values_of(codes))


class RangingChip:
    """A ranging chip on a silicon: 13 rebound neurons, or another array of them, or one.

    Parameters
    ----------
    silicon
        Process, temperature and die.
    circuit
        Circuit of the neurons; the ranging chip's unless given.
    path
        Instance path that errors name.
    record
        Record of the model; the one in force unless given.
    noise
        What varies from call to call on one die; nothing unless given.
    bias_kind
        What all biases but voltages are, `gate`, `ideal` or `generator`. Where a circuit is given its own
        biases hold.
    codes
        Codes of its calibration, which set its biases; those of the design unless given.
    model
        Model of its neurons with its biases, in the place of all these.
    """

    def __init__(
        self,
        silicon: Silicon,
        circuit: Circuit | None = None,
        path: str = "ranging_chip",
        record: ReboundRecord | None = None,
        noise: SiliconNoise | None = None,
        bias_kind: BiasKind = "generator",
        codes: Codes | None = None,
        model: ReboundModel | None = None,
    ) -> None:
        """Prepare the neurons; raises `ParameterError` outside the box (`chips.validity`)."""
        self.silicon, self.path, self.noise = silicon, path, noise
        if model is not None:
            self.model = model
        elif circuit is None and record is None:
            self.model = coded_model(silicon.process, bias_kind, codes)
        else:
            built = circuit or rebias(ranging_chip.build(), kind=bias_kind)
            self.model = model_of(built, silicon.process, record)
        self.spikes = self.model.circuit.port("spike").elements()
        self.analog: tuple[str, ...] = ()
        self._at: dict[float, Neurons] = {}
        self._located: dict[float, Located] = {}  # of temperatures whose jitter is not asked for yet
        self._jitter: dict[float, Jitter] = {}
        self.neurons_at(silicon.temperature_c)

    def begin(self, time: float = 0.0) -> ChipState:
        """Return the state at rest at `time` s, at the silicon's temperature."""
        neurons = resting(self.neurons_at(self.silicon.temperature_c), time)
        jitter = self.jitter_at(self.silicon.temperature_c)
        return ChipState(time, neurons, self.silicon.temperature_c, noise_state=_noise_state(jitter))

    def next_time(self, state: ChipState) -> float:
        """Return the time of the next event that was handed in early to `state`, s, else inf.

        Spikes are found by advancing.
        """
        return state.pending[0][1] if state.pending else math.inf

    def advance(
        self, state: ChipState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[ChipState, float, Output]:
        """Advance `state` to `until` s, or to the first spike, as `chips.part.Part` says.

        `events` are calls and echoes, and `analog` may have `v_ex_max` (V) and `temperature` (degC), which is
        taken at the state's time. Into how many spans a run is cut moves no bit of it, but for when a
        temperature that moves is taken.

        Raises
        ------
        UnknownNameError
            An event is for a port that the chip does not have.
        """
        for port, _ in events:
            if port not in _INPUTS:
                raise unknown_name(f"{self.path} event port", port, _INPUTS)
        lines = {**(state.lines or {}), **(analog or {})}
        self._check(lines)
        pending = sorted([*state.pending, *events], key=lambda e: e[1])
        state = self._at_temperature(replace(state, lines=lines), lines)
        neurons = self.neurons_at(state.temperature_c)
        now, looked, fired = state.time, state.neurons.copied(), np.zeros(len(self.spikes), np.bool_)
        last, merged = list(state.last), state.merged
        jitter = self.jitter_at(state.temperature_c)
        if jitter is not None and state.noise_state is not None:
            relaxation, called, calls = state.noise_state
            jitter = copied(jitter._replace(relaxation=relaxation, last=called, calls=calls))
        while True:
            while pending and pending[0][1] <= now:
                port, time = pending.pop(0)
                which = _INPUTS.index(port)
                if time <= last[which] + LENGTH:
                    merged += 1
                    continue
                last[which] = time
                bring(neurons, looked, now, fired)
                self._apply(neurons, looked.base, port, now, lines, jitter)
                look_all(neurons, looked)
            if now >= until or fired.any():
                break
            now = go_on(neurons, looked, min([until, *(t for _, t in pending[:1])]), fired)
            if fired.any():
                break
        state = replace(
            state, time=now, neurons=looked, pending=tuple(pending), last=(last[0], last[1]), merged=merged,
            noise_state=_noise_state(jitter),
        )  # fmt: skip
        found = tuple((self.spikes[k], now) for k in np.flatnonzero(fired))
        return state, now, Output(found, np.array([state.time]), np.zeros((1, 0)))

    def _apply(
        self,
        neurons: Neurons,
        states: F64,
        port: str,
        now: float,
        lines: Mapping[str, Polyline],
        jitter: Jitter | None,
    ) -> None:
        if port == "call" and jitter is not None:
            neurons = neurons._replace(t_inh=neurons.t_inh.copy())
            next_durations(jitter, now, neurons.t_inh)
        for k in range(len(states)):
            if port == "call":
                call(neurons, k, states[k])
            elif "v_ex_max" in lines:
                echo(neurons, k, states[k], float(np.interp(now, *lines["v_ex_max"])))
            else:
                echo(neurons, k, states[k], float(neurons.v_ex_max[k]))

    def _at_temperature(self, state: ChipState, lines: Mapping[str, Polyline]) -> ChipState:
        if "temperature" not in lines:
            return state
        temperature = float(np.interp(state.time, *lines["temperature"]))
        temperature = STEP * round(temperature / STEP)
        return state if temperature == state.temperature_c else self.moved(state, temperature)

    def moved(self, state: ChipState, temperature_c: float) -> ChipState:
        """Return `state` as it goes on at `temperature_c`, degC."""
        neurons, old = self.neurons_at(temperature_c), self.neurons_at(state.temperature_c)
        return replace(state, neurons=_on(neurons, old, state), temperature_c=temperature_c)

    def rebiased(self, values: Mapping[str, float | tuple[float, ...]]) -> RangingChip:
        """Return the chip with other `values` of its biases, A or V by name; raises outside of its box."""
        model = with_biases(self.model, values)
        return RangingChip(self.silicon, path=self.path, noise=self.noise, model=model)

    def carried(self, state: ChipState, before: RangingChip) -> ChipState:
        """Return `state` of the chip `before` as it goes on with this one's biases.

        What is left of an inhibition is left in proportion to the new one.
        """
        at = state.temperature_c
        return replace(state, neurons=_on(self.neurons_at(at), before.neurons_at(at), state))

    def neurons_at(self, temperature: float) -> Neurons:
        """Return the neurons at `temperature` (degC), which is checked against the box once."""
        if temperature not in self._at:
            silicon = replace(self.silicon, temperature_c=temperature)
            found = check_box(self.model, silicon, self.path)
            self._at[temperature] = neurons_on(self.model, silicon, found)
            if self.noise is not None:
                self._located[temperature] = found
        return self._at[temperature]

    def jitter_at(self, temperature: float) -> Jitter | None:
        """Return the jitter at `temperature` (degC) before any call, None without noise.

        It has a state of its own.
        """
        if self.noise is None:
            return None
        if temperature not in self._jitter:
            neurons, silicon = self.neurons_at(temperature), replace(self.silicon, temperature_c=temperature)
            shortest = float(self.neurons_at(self.silicon.temperature_c).t_inh.min())
            found = self._located.pop(temperature)
            self._jitter[temperature] = new_jitter(
                self.model, neurons, silicon, self.noise, shortest, found=found
            )
        return copied(self._jitter[temperature])

    def _check(self, lines: Mapping[str, Polyline]) -> None:
        if "v_ex_max" in lines:
            v_dd = self.silicon.process.v_dd
            limits = v_dd - self.model.record.box.v_ex_max, v_dd + ABOVE_SUPPLY
            for level in (lines["v_ex_max"][1].min(), lines["v_ex_max"][1].max()):
                require_inside(f"{self.path}.v_ex_max", float(level), limits, "V")


def _on(neurons: Neurons, old: Neurons, state: ChipState) -> Looked:
    """The neurons of a state of other numbers; what is left of an inhibition is left in proportion."""
    looked = state.neurons.copied()
    bring(old, looked, state.time, np.zeros(looked.due.size, np.bool_))
    move_releases(looked.base, state.time, neurons.t_inh / old.t_inh)
    look_all(neurons, looked)
    return looked


def _noise_state(jitter: Jitter | None) -> NoiseState | None:
    """The part of the jitter that is state."""
    return None if jitter is None else (jitter.relaxation, jitter.last, jitter.calls)
