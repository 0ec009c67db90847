"""Sound in air between a narrowband sonar and a reflector.

    c(T) = 331.3 m/s sqrt(1 + T_C / 273.15)          speed of sound, T_C in degrees Celsius
    r(t_e + d / 2) = c d / 2                          d: delay of the echo of what is emitted at t_e
    p = (1 m / r)^2 10^(-2 a (r - 1 m) / 20)          pressure of an echo relative to one from 1 m
    I = p^2                                           its intensity, 1 / r^4

Noise about a carrier f: n(t) = sigma [x(t) cos(2 pi f t) - y(t) sin(2 pi f t)]. x and y come from
independent Gaussian samples w_k at a baseband rate, with u the fraction of the way from one to the next:

    x = ((1 - u) w_k + u w_{k+1}) / sqrt((1 - u)^2 + u^2)

a linear interpolation whose variance is exactly 1 at every instant. w_k is a pure function of (seed,
channel, k), so any stretch of time can be drawn again, in any order.

Sources: 1 / r^4 for a target with fixed reflective properties, Cheely & Horiuchi 2003, section 4; the
speed of sound is that of an ideal diatomic gas, scaled from 331.3 m/s in dry air at 0 degrees Celsius
(the usual textbook figure). The other numbers are ours.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64, U64
from circuits.errors import ParameterError, SolverError
from system.worlds.sound.targets import Trajectory, range_at

_ICE_POINT = 273.15  # K
_SPEED_AT_ICE_POINT = 331.3  # m/s, dry air
COLDEST, HOTTEST = 223.15, 333.15  # K, ours: where the law is within 1 % for air of any humidity
AIR_TEMPERATURE = 293.15  # K, ours: 4.8 m is then 28 ms
_ABSORPTION_AT_40_KHZ = 1.3  # dB/m one way, ours: a usual figure near 20 C and 50 % humidity; off by default
_REFERENCE_RANGE = 1.0  # m
CARRIER_FREQUENCY = 40e3  # Hz, the paper's speaker
FULL_SCALE_AMPLITUDE = 5.0  # V on the speaker, ours
CALL_DURATION = 1e-3  # s, ours
CARRIER_BLOCK = 512  # samples whose carrier shares one table
NOISE_BLOCK = 256  # baseband samples drawn at once
_DELAY_TOLERANCE = 1e-12  # s, ours: well below the 1 ns that is promised
MAX_ITERATIONS = 100


@dataclass(frozen=True, slots=True)
class Air:
    """Still air between a sonar and its reflectors.

    temperature : in K.
    absorption : one-way loss at the carrier in dB/m, >= 0; 0 leaves spreading alone.
    """

    temperature: float = AIR_TEMPERATURE
    absorption: float = 0.0

    def __post_init__(self) -> None:
        speed_of_sound(self.temperature)
        if not 0.0 <= self.absorption < math.inf:
            raise ParameterError(
                f"air.absorption: {self.absorption:g} dB/m, must be >= 0; use 0 for none, "
                f"{_ABSORPTION_AT_40_KHZ:g} for 40 kHz"
            )


@dataclass(frozen=True, slots=True)
class Call:
    """One vocalization: a tone of constant frequency that sounds from `start` for `duration`.

    start : when the speaker starts, in s, >= 0.
    duration : in s, > 0, rise and fall included.
    amplitude : peak voltage on the speaker in V, >= 0.
    carrier_frequency : in Hz, > 0.
    """

    start: float
    duration: float = CALL_DURATION
    amplitude: float = FULL_SCALE_AMPLITUDE
    carrier_frequency: float = CARRIER_FREQUENCY

    def __post_init__(self) -> None:
        if not 0.0 <= self.start < math.inf:
            raise ParameterError(f"call.start: {self.start:g} s, must be >= 0; start within the run")
        if not 0.0 < self.duration < math.inf:
            raise ParameterError(f"call.duration: {self.duration:g} s, must be > 0; try {CALL_DURATION:g}")
        if not 0.0 <= self.amplitude < math.inf:
            raise ParameterError(f"call.amplitude: {self.amplitude:g} V, must be >= 0; give a peak voltage")
        if not 0.0 < self.carrier_frequency < math.inf:
            raise ParameterError(
                f"call.carrier_frequency: {self.carrier_frequency:g} Hz, must be > 0; "
                f"try {CARRIER_FREQUENCY:g}"
            )


def speed_of_sound(temperature: float) -> float:
    """Speed of sound in m/s in air at `temperature` in K.

    Raises
    ------
    ParameterError
        Outside -50 to 60 degrees Celsius.
    """
    if not COLDEST <= temperature <= HOTTEST:
        raise ParameterError(
            f"air.temperature: {temperature:g} K, must be {COLDEST:g} to {HOTTEST:g}; "
            "give kelvin, such as 293.15 for 20 C"
        )
    return _SPEED_AT_ICE_POINT * math.sqrt(temperature / _ICE_POINT)


def two_way_delay(range_m: ArrayLike, speed: float) -> F64:
    """Delay in s of the echo of a resting target at `range_m` in m, with sound at `speed` in m/s."""
    return 2.0 * np.asarray(range_m, dtype=np.float64) / speed


def echo_delay(trajectory: Trajectory, emission_time: ArrayLike, speed: float) -> F64:
    """Delay in s of the echo of what leaves the speaker at `emission_time`, in its shape.

    The sound meets the target where the target is by then: r(t_e + d / 2) = c d / 2. Iterating
    d / 2 <- r(t_e + d / 2) / c contracts by the target's speed over c, a third at the very worst.
    The range at reflection is c d / 2.

    Parameters
    ----------
    trajectory : the target's range over time.
    emission_time : in s.
    speed : of sound, in m/s.
    """
    emission = np.asarray(emission_time, dtype=np.float64)
    one_way = range_at(trajectory, emission) / speed
    for _ in range(MAX_ITERATIONS):
        before, one_way = one_way, range_at(trajectory, emission + one_way) / speed
        # Beyond the tolerance, only the rounding of the times themselves.
        if np.all(
            np.abs(one_way - before) <= _DELAY_TOLERANCE + 4.0 * np.spacing(np.abs(emission) + one_way)
        ):
            return np.asarray(2.0 * one_way)
    raise SolverError(
        f"echo delay: no solution in {MAX_ITERATIONS} steps, speed of sound {speed:g} m/s must exceed the "
        "target's; slow the target down"
    )


def echo_pressure(range_m: ArrayLike, absorption: float = 0.0) -> F64:
    """Pressure amplitude of an echo from `range_m` in m relative to the same reflector at 1 m.

    Spreading out and back gives 1 / r^2; `absorption` in dB/m one way acts on the path beyond 1 m.
    """
    distance = np.asarray(range_m, dtype=np.float64)
    loss = 2.0 * absorption * (distance - _REFERENCE_RANGE)
    return np.asarray((_REFERENCE_RANGE / distance) ** 2 * 10.0 ** (-loss / 20.0))


def tone_envelope(time_since_onset: ArrayLike, duration: float, rise_time: float) -> F64:
    """Envelope, 0 to 1, of a tone through narrowband transducers, in the shape of the times in s.

    Raised-cosine rise from 0 to `rise_time` and the mirrored fall up to `duration`; 0 outside. The shape
    is ours: real transducers ring up and down exponentially.
    """
    time = np.asarray(time_since_onset, dtype=np.float64)
    progress = np.clip(np.minimum(time, duration - time) / rise_time, 0.0, 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * progress))


def carrier(frequency: float, first: int, stop: int, sample_rate: float) -> tuple[F64, F64]:
    """Cosine and sine of 2 pi f k / sample_rate for k = first to stop - 1, each of shape (stop - first,).

    By the angle sum from the start of each block of `CARRIER_BLOCK` samples: products and sums round
    alike wherever an element stands in its array, which vectorised cosines need not.
    """
    blocks = range(first // CARRIER_BLOCK, -(-stop // CARRIER_BLOCK))
    cycles = [frequency * (block * CARRIER_BLOCK) / sample_rate for block in blocks]
    angles = [math.tau * math.fmod(cycle, 1.0) for cycle in cycles]
    cos_start = np.array([[math.cos(angle)] for angle in angles])
    sin_start = np.array([[math.sin(angle)] for angle in angles])
    within = math.tau * frequency / sample_rate * np.arange(CARRIER_BLOCK)
    cos_within, sin_within = np.cos(within), np.sin(within)
    cut = slice(first - blocks.start * CARRIER_BLOCK, stop - blocks.start * CARRIER_BLOCK)
    cosine = (cos_start * cos_within - sin_start * sin_within).ravel()[cut]
    sine = (sin_start * cos_within + cos_start * sin_within).ravel()[cut]
    return cosine, sine


def baseband_noise(seed: int, channel: int, first: int, stop: int) -> F64:
    """In-phase and quadrature Gaussian samples k = first to stop - 1, shape (2, stop - first), variance 1.

    Block b of `NOISE_BLOCK` samples is Philox with a hash of (seed, channel) as key and b as counter.
    """
    digest = hashlib.blake2b(f"microphone noise {seed} {channel}".encode(), digest_size=16).digest()
    key = np.frombuffer(digest, dtype="<u8").astype(np.uint64)
    blocks = range(first // NOISE_BLOCK, -(-stop // NOISE_BLOCK))
    drawn = [_noise_block(key, block) for block in blocks]
    origin = blocks.start * NOISE_BLOCK
    return np.concatenate(drawn, axis=1)[:, first - origin : stop - origin]


def interpolate_noise(samples: F64, first: int, position: F64) -> tuple[F64, F64]:
    """In-phase and quadrature noise of variance 1 at `position`, in baseband samples from k = 0, shape (n,).

    `samples` are those of `baseband_noise` from `first` on, and reach one past the last position. Only
    correctly rounded operations are used, so a value does not depend on its neighbours.
    """
    cell = np.floor(position)
    after = position - cell
    before = 1.0 - after
    scale = np.sqrt(before * before + after * after)
    before /= scale
    after /= scale
    index = cell.astype(np.intp) - first
    in_phase, quadrature = samples
    x = before * in_phase.take(index)
    y = before * quadrature.take(index)
    index += 1
    x += after * in_phase.take(index)
    y += after * quadrature.take(index)
    return x, y


def _noise_block(key: U64, block: int) -> F64:
    counter = np.array([0, block, 0, 0], dtype=np.uint64)  # the low word counts within the block
    return np.random.Generator(np.random.Philox(key=key, counter=counter)).standard_normal((2, NOISE_BLOCK))


def beam(angle: F64, width: float) -> F64:
    """Amplitude of a transducer's beam at an angle (rad) from its axis, relative to the axis."""
    return np.asarray(np.exp(-0.5 * math.log(2.0) * (2.0 * angle / width) ** 2))
