"""What the sonar's microphone and its amplifier give, from calls and targets.

Each call arrives directly and as one echo from each target; all paths add coherently:

    v(t) = v_mid + sum_p A_p e(t - t_p) cos(2 pi f (t - d_p)) + n(t),   cut off at the rails

with A_p the peak at the amplifier's output, t_p the onset, d_p the delay and e the envelope of
`acoustics.tone_envelope`. The speaker's oscillator runs freely and is gated by the call. A path's delay
is that of the call's first instant and is fixed over the call: there is no Doppler shift or stretch inside
a call (at 1 m/s it would be 0.6 % and 6 us in 1 ms). The amplifier clips hard; clipped samples are counted.

The noise n(t) is that of `acoustics.baseband_noise` about the carrier, sigma = noise_rms.

Source: Cheely & Horiuchi 2003, section 4 (40 kHz; the vocalization reaches the microphones and is far
louder than echoes). The paper gives no voltages; every number here is ours. The transfers put the echo
of the reference reflector at 4.8 m at 50 mV peak for a full-scale call (5 V on the speaker), and the
direct call at 2.4 V peak for a call of a fifth of that, 12 V, clipped at 2.5 V, at full scale.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circuits.errors import ParameterError
from system.acoustics import (
    CARRIER_FREQUENCY,
    Air,
    Call,
    baseband_noise,
    carrier,
    echo_delay,
    echo_pressure,
    interpolate_noise,
    speed_of_sound,
    tone_envelope,
)
from system.targets import Target

DIRECT = "direct"  # the source of the path from speaker to microphone
CHUNK = 8192  # samples worked on at once, so that they stay in the cache
GRID_SLACK = 1e-6  # samples: a time this little past a grid point counts as on it

Number = TypeVar("Number", int, float)


@dataclass(frozen=True, slots=True)
class Microphone:
    """Parameters of the ear: transducers, coupling, amplifier and noise. All defaults are ours.

    Attributes
    ----------
    carrier_frequency : of the transducers, in Hz.
    rise_time : raised-cosine rise and fall of a tone, in s.
    mouth_ear_delay : from speaker to microphone, in s.
    direct_transfer : V at the microphone per V on the speaker, straight across.
    echo_transfer : V at the microphone per V on the speaker, by the reference reflector at 1 m.
    gain : of the amplifier, V/V.
    supply : upper rail in V; the lower rail is 0.
    mid_supply : the output in silence, in V.
    noise_rms : at the amplifier's output in V; 0 switches noise off.
    noise_rate : of the baseband noise samples in Hz; the half-power band is 0.62 of it wide.
    seed, channel : key of the noise; ears on one head share a seed and differ in channel.
    air : what the sound travels in.
    """

    carrier_frequency: float = CARRIER_FREQUENCY
    rise_time: float = 0.2e-3
    mouth_ear_delay: float = 0.1e-3
    direct_transfer: float = 2.4e-3
    echo_transfer: float = 2.304e-4
    gain: float = 1000.0
    supply: float = 5.0
    mid_supply: float = 2.5
    noise_rms: float = 5e-3
    noise_rate: float = 8e3
    seed: int = 0
    channel: int = 0
    air: Air = field(default_factory=Air)

    def __post_init__(self) -> None:
        for name in ("carrier_frequency", "rise_time", "gain", "supply", "noise_rate"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise ParameterError(f"microphone.{name}: {value:g}, must be > 0; see its default")
        for name in ("mouth_ear_delay", "direct_transfer", "echo_transfer", "noise_rms"):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise ParameterError(f"microphone.{name}: {value:g}, must be >= 0; see its default")
        if not 0.0 <= self.mid_supply <= self.supply:
            raise ParameterError(
                f"microphone.mid_supply: {self.mid_supply:g} V, must be 0 to {self.supply:g} V; "
                "use half the supply"
            )


@dataclass(frozen=True, slots=True)
class SoundPath:
    """One way by which one call reaches the microphone.

    Attributes
    ----------
    source : `DIRECT` or the target's name.
    onset, offset : when it starts and ends at the microphone, in s.
    delay : behind the speaker, in s.
    amplitude : peak at the amplifier's output before clipping, in V.
    """

    source: str
    onset: float
    offset: float
    delay: float
    amplitude: float


@dataclass(frozen=True, slots=True)
class MicrophoneState:
    """What is on its way to the microphone.

    Attributes
    ----------
    paths : that sound now or later, in the order of the calls.
    time : up to where samples were handed out, in s.
    clipped : samples at a rail so far.
    """

    paths: tuple[SoundPath, ...] = ()
    time: float = 0.0
    clipped: int = 0


@dataclass(frozen=True, slots=True)
class SoundEdge:
    """A path's onset or offset at `time` in s."""

    time: float
    source: str
    kind: Literal["onset", "offset"]


def headroom(parameters: Microphone) -> float:
    """Peak in V from which on a tone is clipped."""
    return min(parameters.mid_supply, parameters.supply - parameters.mid_supply)


def direct_amplitude(parameters: Microphone, call_amplitude: float) -> float:
    """Peak in V of the direct call at the amplifier's output before clipping."""
    return parameters.gain * parameters.direct_transfer * call_amplitude


def echo_amplitude(
    parameters: Microphone, call_amplitude: float, target_strength: float, range_m: float
) -> float:
    """Peak in V of an echo at the amplifier's output before clipping.

    `call_amplitude` in V on the speaker, `range_m` in m, `target_strength` relative to the reference.
    """
    spread = float(echo_pressure(range_m, parameters.air.absorption))
    return parameters.gain * parameters.echo_transfer * call_amplitude * target_strength * spread


def hear(
    parameters: Microphone, state: MicrophoneState, call: Call, targets: Sequence[Target]
) -> MicrophoneState:
    """Add the paths of `call`: the direct one and one from each target. A silent call adds none.

    Raises
    ------
    ParameterError
        The call is off the transducers' carrier, too short for their rise and fall, or would have been
        heard before the state's time.
    """
    _check_call(parameters, call)
    if call.amplitude == 0.0:
        return state
    speed = speed_of_sound(parameters.air.temperature)
    paths = [_path(call, DIRECT, parameters.mouth_ear_delay, direct_amplitude(parameters, call.amplitude))]
    for target in targets:
        delay = float(echo_delay(target.trajectory, call.start, speed))
        strength = target.target_strength
        amplitude = echo_amplitude(parameters, call.amplitude, strength, speed * delay / 2.0)
        paths.append(_path(call, target.name, delay, amplitude))
    early = min(path.onset for path in paths)
    if early < state.time:
        raise ParameterError(
            f"call.start: {call.start:g} s, must be heard from {state.time:g} s on but is at {early:g} s; "
            "add the call before listening past it"
        )
    return replace(state, paths=state.paths + tuple(paths))


def next_time(state: MicrophoneState) -> float:
    """Time in s of the next onset or offset of a path after the state's time; inf in lasting silence."""
    edges = (edge for path in state.paths for edge in (path.onset, path.offset) if edge > state.time)
    return min(edges, default=math.inf)


def advance(state: MicrophoneState, until: float) -> tuple[MicrophoneState, float, tuple[SoundEdge, ...]]:
    """Move to the next onset or offset, or to `until` in s where that is earlier; finished paths are dropped.

    Returns the state, the time reached, and the edges at that time.
    """
    reached = max(min(until, next_time(state)), state.time)
    edges: list[SoundEdge] = []
    if reached > state.time:
        for path in state.paths:
            if path.onset == reached:
                edges.append(SoundEdge(reached, path.source, "onset"))
            if path.offset == reached:
                edges.append(SoundEdge(reached, path.source, "offset"))
    return prune(state, reached), reached, tuple(edges)


def prune(state: MicrophoneState, time: float) -> MicrophoneState:
    """Drop the paths that ended by `time` in s, and move the state there."""
    paths = tuple(path for path in state.paths if path.offset > time)
    return replace(state, paths=paths, time=max(state.time, time))


def sound_segments(state: MicrophoneState, start: float, stop: float) -> tuple[tuple[float, float], ...]:
    """Disjoint intervals in s within `start` to `stop` in which a path sounds, in order."""
    return _merge((max(path.onset, start), min(path.offset, stop)) for path in state.paths)


def waveform(
    parameters: Microphone, state: MicrophoneState, start_s: float, stop_s: float, sample_rate: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sample the amplifier's output.

    Sample k lies at k / sample_rate; the segment has those with start_s <= k / sample_rate < stop_s, so
    that adjoining segments share none. A sample's value does not depend on the segment it is asked in.

    Parameters
    ----------
    parameters : the ear.
    state : holds the paths of every call heard so far.
    start_s, stop_s : the segment in s, from 0 on.
    sample_rate : in Hz; more than twice the carrier.

    Returns
    -------
    time : in s, shape (n,).
    voltage : in V, shape (n,), within the rails.
    """
    _check_segment(parameters, start_s, stop_s, sample_rate)
    first, last = _grid_index(start_s, sample_rate), _grid_index(stop_s, sample_rate)
    voltage = np.full(last - first, parameters.mid_supply)
    spans = [_sample_span(path, sample_rate) for path in state.paths]
    noisy = parameters.noise_rms > 0.0
    for begin, end in _merge([(first, last)] if noisy else ((max(a, first), min(b, last)) for a, b in spans)):
        noise, first_noise = _draw_noise(parameters, begin, end, sample_rate)
        low = begin
        while low < end:
            high = min((low // CHUNK + 1) * CHUNK, end)
            in_phase, quadrature = _noise_part(parameters, noise, first_noise, (low, high), sample_rate)
            for path, span in zip(state.paths, spans, strict=True):
                _add_path(parameters, path, span, low, sample_rate, in_phase, quadrature)
            cosine, sine = carrier(parameters.carrier_frequency, low, high, sample_rate)
            in_phase *= cosine
            quadrature *= sine
            in_phase -= quadrature
            voltage[low - first : high - first] += in_phase
            low = high
    np.clip(voltage, 0.0, parameters.supply, out=voltage)
    return np.arange(first, last) / sample_rate, voltage


def listen(
    parameters: Microphone, state: MicrophoneState, stop_s: float, sample_rate: float
) -> tuple[MicrophoneState, NDArray[np.float64], NDArray[np.float64]]:
    """Give the state at `stop_s` in s, and the `waveform` from the state's time to there.

    Clipped samples are added to the state's count, and finished paths are dropped.
    """
    time, voltage = waveform(parameters, state, state.time, stop_s, sample_rate)
    clipped = state.clipped + clipped_samples(parameters, voltage)
    return prune(replace(state, clipped=clipped), stop_s), time, voltage


def clipped_samples(parameters: Microphone, voltage: NDArray[np.float64]) -> int:
    """How many samples of `voltage` in V are at a rail."""
    return int(np.count_nonzero((voltage <= 0.0) | (voltage >= parameters.supply)))


def envelope(parameters: Microphone, state: MicrophoneState, time: ArrayLike) -> NDArray[np.float64]:
    """Envelope in V of the superposed paths at `time` in s, in its shape: |sum A e exp(-i 2 pi f d)|.

    Before clipping and without noise; what an ideal envelope detector would follow.
    """
    moment = np.asarray(time, dtype=np.float64)
    phasor = np.zeros(moment.shape, dtype=np.complex128)
    for path in state.paths:
        shape = tone_envelope(moment - path.onset, path.offset - path.onset, parameters.rise_time)
        phasor += shape * complex(*_path_phasor(parameters, path))
    return np.abs(phasor)


def _path(call: Call, source: str, delay: float, amplitude: float) -> SoundPath:
    onset = call.start + delay
    return SoundPath(source, onset, onset + call.duration, delay, amplitude)


def _path_phasor(parameters: Microphone, path: SoundPath) -> tuple[float, float]:
    angle = -math.tau * math.fmod(parameters.carrier_frequency * path.delay, 1.0)
    return path.amplitude * math.cos(angle), path.amplitude * math.sin(angle)


def _draw_noise(
    parameters: Microphone, begin: int, end: int, sample_rate: float
) -> tuple[NDArray[np.float64], int]:
    if parameters.noise_rms == 0.0:
        return np.zeros((2, 0)), 0
    step = parameters.noise_rate / sample_rate
    first, last = math.floor(begin * step), math.floor((end - 1) * step) + 1
    samples = baseband_noise(parameters.seed, parameters.channel, first, last + 1)
    return parameters.noise_rms * samples, first


def _noise_part(
    parameters: Microphone,
    noise: NDArray[np.float64],
    first_noise: int,
    span: tuple[int, int],
    sample_rate: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if parameters.noise_rms == 0.0:
        return np.zeros(span[1] - span[0]), np.zeros(span[1] - span[0])
    position = np.arange(*span, dtype=np.float64) * (parameters.noise_rate / sample_rate)
    return interpolate_noise(noise, first_noise, position)


def _add_path(
    parameters: Microphone,
    path: SoundPath,
    span: tuple[int, int],
    low: int,
    sample_rate: float,
    in_phase: NDArray[np.float64],
    quadrature: NDArray[np.float64],
) -> None:
    """Add to the baseband samples from `low` on, in place.

    Ramps are worked out whole and then cut, so that a sample's value does not depend on the segment.
    """
    begin, end = max(span[0], low), min(span[1], low + in_phase.size)
    if begin >= end:
        return
    shape = np.ones(end - begin)
    ramp = math.ceil(parameters.rise_time * sample_rate) + 1
    rise, fall = (span[0], min(span[0] + ramp, span[1])), (max(span[1] - ramp, span[0]), span[1])
    for ramp_begin, ramp_end in (rise, fall):
        inner, outer = max(ramp_begin, begin), min(ramp_end, end)
        if inner < outer:
            since_onset = np.arange(ramp_begin, ramp_end) / sample_rate - path.onset
            values = tone_envelope(since_onset, path.offset - path.onset, parameters.rise_time)
            shape[inner - begin : outer - begin] = values[inner - ramp_begin : outer - ramp_begin]
    x, y = _path_phasor(parameters, path)
    in_phase[begin - low : end - low] += x * shape
    quadrature[begin - low : end - low] += y * shape


def _sample_span(path: SoundPath, sample_rate: float) -> tuple[int, int]:
    return math.ceil(path.onset * sample_rate), math.floor(path.offset * sample_rate) + 1


def _grid_index(time: float, sample_rate: float) -> int:
    return math.ceil(time * sample_rate - GRID_SLACK)


def _merge(intervals: Iterable[tuple[Number, Number]]) -> tuple[tuple[Number, Number], ...]:
    merged: list[tuple[Number, Number]] = []
    for begin, end in sorted(interval for interval in intervals if interval[0] < interval[1]):
        if merged and begin <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], end))
        else:
            merged.append((begin, end))
    return tuple(merged)


def _check_call(parameters: Microphone, call: Call) -> None:
    if call.carrier_frequency != parameters.carrier_frequency:
        raise ParameterError(
            f"call.carrier_frequency: {call.carrier_frequency:g} Hz, must be the transducers' "
            f"{parameters.carrier_frequency:g} Hz; change the call or microphone.carrier_frequency"
        )
    if call.duration < 2.0 * parameters.rise_time:
        raise ParameterError(
            f"call.duration: {call.duration:g} s, must be >= {2.0 * parameters.rise_time:g} s, the rise and "
            "fall; lengthen the call or shorten microphone.rise_time"
        )


def _check_segment(parameters: Microphone, start_s: float, stop_s: float, sample_rate: float) -> None:
    if not 0.0 <= start_s <= stop_s < math.inf:
        raise ParameterError(
            f"segment: {start_s:g} to {stop_s:g} s, must start at 0 or later and not end before its start; "
            "swap or move it"
        )
    lowest = 2.0 * parameters.carrier_frequency
    if not lowest < sample_rate < math.inf:
        raise ParameterError(
            f"sample_rate: {sample_rate:g} Hz, must be > {lowest:g} Hz, twice the carrier; try 1e6"
        )
