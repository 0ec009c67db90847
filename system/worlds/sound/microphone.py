"""What reaches the sonar's microphone and its amplifier, from calls and targets.

Each call arrives directly and as one echo from each target; all paths add coherently:

    v(t) = v_mid + sum_p A_p e(t - t_p) cos(2 pi f (t - d_p)) + n(t),   cut off at the rails

with A_p the peak at the amplifier's output, t_p the onset, d_p the delay and e the envelope of
`acoustics.tone_envelope`; `system.worlds.sound.waveform` samples it. The speaker's oscillator runs freely and
is gated by the call. A path's delay is that of the call's first instant and is fixed over the call: there is
no Doppler shift or stretch inside a call (at 1 m/s it would be 0.6 % and 6 us in 1 ms). The amplifier clips
hard; clipped samples are counted.

The noise n(t) is that of `acoustics.baseband_noise` about the carrier, sigma = noise_rms.

Source: Cheely & Horiuchi 2003, section 4 (40 kHz; the vocalization reaches the microphones and is far
louder than echoes). The paper gives no voltages; every number here is ours. The transfers put the echo
of the reference reflector at 4.8 m at 50 mV peak for a full-scale call (5 V on the speaker), and the
direct call at 2.4 V peak for a call of a fifth of that, 12 V, clipped at 2.5 V, at full scale.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

from circuits.errors import ParameterError
from system.numbers import check_numbers
from system.worlds.sound.acoustics import (
    CARRIER_FREQUENCY,
    Air,
    Call,
    echo_delay,
    echo_pressure,
    speed_of_sound,
)
from system.worlds.sound.targets import Target

DIRECT = "direct"  # the source of the path from speaker to microphone

_FROM_ZERO = ("mouth_ear_delay", "direct_transfer", "echo_transfer", "noise_rms", "mid_supply")

Number = TypeVar("Number", int, float)


@dataclass(frozen=True, slots=True)
class Microphone:
    """Parameters of the ear: transducers, coupling, amplifier and noise. All defaults are ours.

    Attributes
    ----------
    carrier_frequency : float
        Carrier frequency of the transducers, Hz.
    rise_time : float
        Raised-cosine rise and fall of a tone, s.
    mouth_ear_delay : float
        Delay from speaker to microphone, s.
    direct_transfer : float
        Voltage at the microphone for each V on the speaker, straight across, V/V.
    echo_transfer : float
        Voltage at the microphone for each V on the speaker, by the reference reflector at 1 m, V/V.
    gain : float
        Gain of the amplifier, V/V.
    supply : float
        Upper rail, V; the lower rail is 0.
    mid_supply : float
        Output in silence, V.
    noise_rms : float
        Noise at the amplifier's output, V; 0 switches it off.
    noise_rate : float
        Rate of the baseband noise samples, Hz; the half-power band is 0.62 of it wide.
    seed, channel : int
        Key of the noise; ears on one head share a seed and differ in channel.
    air : Air
        What the sound travels in.

    Raises
    ------
    ParameterError
        A number breaks its rule, as where the output in silence is above the supply.
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
        check_numbers("microphone", self, from_zero=_FROM_ZERO, signed=("seed", "channel"))
        if self.mid_supply > self.supply:
            raise ParameterError(
                f"microphone.mid_supply: {self.mid_supply:g} V, must be 0 to {self.supply:g} V; "
                "use half the supply"
            )


@dataclass(frozen=True, slots=True)
class SoundPath:
    """One way by which one call reaches the microphone.

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

    paths : that sound now or later, in the order of the calls.
    time : up to where samples were handed out, in s.
    clipped : samples at a rail so far.
    """

    paths: tuple[SoundPath, ...] = ()
    time: float = 0.0
    clipped: int = 0


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


def prune(state: MicrophoneState, time: float) -> MicrophoneState:
    """Drop the paths that ended by `time` in s, and move the state there."""
    paths = tuple(path for path in state.paths if path.offset > time)
    return replace(state, paths=paths, time=max(state.time, time))


def sound_segments(state: MicrophoneState, start: float, stop: float) -> tuple[tuple[float, float], ...]:
    """Disjoint intervals in s within `start` to `stop` in which a path sounds, in order."""
    return merged_intervals((max(path.onset, start), min(path.offset, stop)) for path in state.paths)


def _path(call: Call, source: str, delay: float, amplitude: float) -> SoundPath:
    onset = call.start + delay
    return SoundPath(source, onset, onset + call.duration, delay, amplitude)


def merged_intervals(intervals: Iterable[tuple[Number, Number]]) -> tuple[tuple[Number, Number], ...]:
    """Disjoint intervals in order that cover the same; empty ones are left out."""
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
