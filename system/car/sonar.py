"""A ping of the car's sonar head: echoes of pipes, three envelopes, their peaks, and places.

A pipe at the range r (to its surface) answers after 2 r / c with `robot_localiser`'s amplitudes; by way of
pipe i, then j, after (r_i + d_ij + r_j) / c with s b(theta_i) b(theta_j - psi) / (r_i d_ij r_j), where s is
what a pipe scatters to 1 m. A pipe in the geometric shadow of a nearer one is silent. Echoes add with the
phases of their 40 kHz carriers, so near ones interfere; each lasts `call`, a raised cosine (ours).

What comes within 3 ms of the ping cannot be localised, but is noticed; the robot then sends a soft ping at
once, whose own signal has died out after `soft_blanking`: the paper's remedy for near objects. It is softer
by (soft_blanking / blanking)^2 in amplitude, so that an echo from the edge of either blind zone is as loud.

A peak is the largest of the three envelopes within a call's length, above a threshold. Its time, less half a
call, gives the range; the peaks of all three the direction. A pipe's radius is added to the range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from circuits.arrays import C128, F64, I64, Bools
from system.car.localiser import WIDEST, Localiser, hearing, localise, volts
from system.car.numbers import PIPE_RADIUS, Robot
from system.openspace.population import Population, hear_ping, no_population
from system.openspace.reader import STEP, WINDOW
from system.openspace.reader_noise import Reader, answers, next_ping, no_reader, read
from system.worlds.sound.acoustics import (
    AIR_TEMPERATURE,
    CARRIER_FREQUENCY,
    beam,
    speed_of_sound,
    tone_envelope,
)

SPEED = speed_of_sound(AIR_TEMPERATURE)  # m/s
_NOISE_SAMPLES = 65_521  # a channel, which the pings of a run take in turn
_FAINT = 0.1  # of the threshold: what is less loud by way of two pipes is left out; ours


class Heard(NamedTuple):
    """What a ping gave: places, and counts of what was not heard as it is.

    place : float64[n, 2], m from the head, x along its axis, y to its left.
    """

    place: F64
    near: int  # pipes that answered within the blanking
    missed: int  # echoes of which the chip has no reading
    occluded: int
    clipped: int  # directions beyond what the network was trained for


@dataclass(frozen=True, slots=True, eq=False)
class Sonar:
    """The head: numbers, network, options; reading: range (m) a `STEP` of delay, NaN for none, or empty.

    noise: complex[3, _NOISE_SAMPLES], of the run's seed; reader: of a chip that makes noise, in the place of
    `reading`; population: of a calibrated chip, in the place of both. Every ping overwrites their states.

    robot : numbers of the head.
    occlusion : whether a pipe hides those behind it.
    multipath : whether echoes by way of two pipes are heard.
    soft_pings : whether a soft ping follows where something is near.
    spikes : where those of the chip are kept, times (s) and neurons a ping; None to keep none.
    """

    robot: Robot
    network: Localiser
    noise: C128
    reading: F64
    occlusion: bool = True
    multipath: bool = True
    soft_pings: bool = True
    reader: Reader = field(default_factory=no_reader)
    population: Population = field(default_factory=no_population)
    spikes: list[tuple[F64, I64]] | None = None


class _Echoes(NamedTuple):
    delay: F64  # s
    amplitude: F64  # float64[3, n]


def listened(robot: Robot) -> float:
    """Return from a ping to when the farthest echo is heard, and what a chip answers to it, s."""
    return 2.0 * robot.max_range / SPEED + robot.call + WINDOW


def noise_of(robot: Robot, random: np.random.Generator) -> C128:
    """Noise of three envelopes' quadratures."""
    drawn = random.standard_normal((2, 3, _NOISE_SAMPLES))
    return np.asarray(robot.noise * (drawn[0] + 1j * drawn[1]))


def ping(sonar: Sonar, pipes: F64, number: int, *, soft: bool, time: float = 0.0) -> Heard:
    """Send ping `number`, at `time` s, among pipes, float64[n, 2] in m from the head, x along its axis."""
    r, distance, angle = sonar.robot, np.hypot(*pipes.T), np.arctan2(pipes[:, 1], pipes[:, 0])
    kept = distance < r.max_range + 2.0 * PIPE_RADIUS
    audible = kept & ~shadowed(distance, angle) if sonar.occlusion else kept
    here, distance, angle = pipes[audible], distance[audible], angle[audible]
    direct = _direct(r, distance, angle)
    near = int(
        ((direct.delay < r.blanking) & (direct.amplitude.max(axis=0, initial=0.0) > r.threshold)).sum()
    )
    echoes = _joined(direct, _bounced(r, here, distance, angle)) if sonar.multipath else direct
    first, last = (r.soft_blanking, r.blanking) if soft else (r.blanking, 2.0 * r.max_range / SPEED)
    gain = (r.soft_blanking / r.blanking) ** 2 if soft else 1.0
    when, envelope = _envelopes(sonar, echoes, gain, (first, last), number)
    delay, peak = _peaks(r, when, envelope)
    inside = (delay >= first) & (delay < last)
    angle = localise(sonar.network, volts(r, peak[:, inside]).T)
    distance, missed = _ranges(sonar, delay[inside], time)
    heard, angle = distance[~np.isnan(distance)], angle[~np.isnan(distance)]
    shown = np.clip(angle, -WIDEST, WIDEST)
    place = np.stack([heard * np.cos(shown), heard * np.sin(shown)], axis=1)
    return Heard(place, near, missed, int((kept & ~audible).sum()), int((shown != angle).sum()))


def shadowed(distance: F64, angle: F64) -> Bools:
    """Which pipes have the middle in the geometric shadow of a nearer one."""
    half = np.arcsin(np.minimum(PIPE_RADIUS / np.maximum(distance, PIPE_RADIUS), 1.0))
    behind = distance[:, None] > distance[None, :]
    return np.asarray((behind & (np.abs(angle[:, None] - angle[None, :]) < half[None, :])).any(axis=1))


def _direct(r: Robot, distance: F64, angle: F64) -> _Echoes:
    surface = np.maximum(distance - PIPE_RADIUS, 1e-3)
    return _Echoes(2.0 * surface / SPEED, beam(angle, r.beam) * hearing(r, angle) / surface**2)


def _bounced(r: Robot, place: F64, distance: F64, angle: F64) -> _Echoes:
    """Echoes by way of pipe i, then j, where they are not too faint."""
    apart = np.hypot(*(place[:, None, :] - place[None, :, :]).transpose(2, 0, 1)) - 2.0 * PIPE_RADIUS
    np.fill_diagonal(apart, np.inf)
    surface = np.maximum(distance - PIPE_RADIUS, 1e-3)
    way = surface[:, None] + apart + surface[None, :]
    loss = r.scatter * beam(angle, r.beam)[:, None] / (surface[:, None] * apart * surface[None, :])
    ears = hearing(r, angle)
    i, j = np.nonzero(
        (loss * ears.max(axis=0, initial=0.0) > _FAINT * r.threshold) & (way < 2.0 * r.max_range)
    )
    return _Echoes(way[i, j] / SPEED, loss[i, j] * ears[:, j])


def _joined(a: _Echoes, b: _Echoes) -> _Echoes:
    return _Echoes(np.concatenate([a.delay, b.delay]), np.concatenate([a.amplitude, b.amplitude], axis=1))


def _envelopes(
    sonar: Sonar, echoes: _Echoes, gain: float, window: tuple[float, float], number: int
) -> tuple[F64, F64]:
    """Times (s) and amplitudes of the three envelopes, float64[3, times], from the blanking's end on."""
    r = sonar.robot
    samples = math.ceil((window[1] - window[0] + r.call) * r.sample_rate)
    when = window[0] + np.arange(samples) / r.sample_rate
    shape = tone_envelope(when[None, :] - echoes.delay[:, None], r.call, 0.5 * r.call)
    phase = np.exp(-2j * math.pi * CARRIER_FREQUENCY * echoes.delay)
    taken = (number * samples + np.arange(samples)) % _NOISE_SAMPLES
    return when, np.abs(gain * (echoes.amplitude * phase) @ shape + sonar.noise[:, taken])


def _peaks(r: Robot, when: F64, envelope: F64) -> tuple[F64, F64]:
    """Delays (s) of the peaks and the largest amplitude of each transducer about them, float64[3, peaks]."""
    reach = max(1, round(0.5 * r.call * r.sample_rate))
    loudest = envelope.max(axis=0)
    padded = np.pad(envelope, ((0, 0), (reach, reach)))
    about = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=1).max(axis=2)
    at = np.flatnonzero((loudest >= about.max(axis=0)) & (loudest > r.threshold))
    return when[at] - 0.5 * r.call, about[:, at]


def _ranges(sonar: Sonar, delay: F64, time: float) -> tuple[F64, int]:
    """Ranges (m) to the middles of pipes of a ping at `time` s, NaN for none; how many are none."""
    if sonar.population.on.size:
        found = 0.5 * SPEED * _readings(sonar.population, delay, time) + PIPE_RADIUS
        if sonar.spikes is not None:
            sonar.spikes.append(sonar.population.spoke())
        return found, int(np.isnan(found).sum())
    if sonar.reader.value.size:
        next_ping(sonar.reader, time)
        found = 0.5 * SPEED * np.array([read(sonar.reader, d) for d in delay]) + PIPE_RADIUS
        if sonar.spikes is not None:
            told = [answers(sonar.reader, d) for d in delay.tolist()]
            sonar.spikes.extend((time + late, which) for late, which in told)
        return found, int(np.isnan(found).sum())
    if sonar.reading.size == 0:
        return 0.5 * SPEED * delay + PIPE_RADIUS, 0
    k = np.minimum(np.rint(delay / STEP).astype(np.int64), sonar.reading.size - 1)
    found = sonar.reading[k] + PIPE_RADIUS
    return found, int(np.isnan(found).sum())


def _readings(population: Population, delay: F64, time: float) -> F64:
    """What a calibrated chip reads (s, NaN for none) of a ping's echoes, whose delays (s) rise.

    Beyond the room for echoes there is no reading.
    """
    heard = population.echo[: delay.size]
    heard[:, 0] = delay[: len(heard)]
    hear_ping(population, time, len(heard))
    found: F64 = np.full(delay.size, np.nan)
    found[: len(heard)] = heard[:, 1]
    return found
