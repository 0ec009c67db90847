"""The closed loop of the sonar head: ping, echo at both ears, spikes of two LSO neurons, turn of the neck.

At every ping the speaker calls along the head's axis; the echo comes 2 r / c later, r where the target is by
then, while the neck may still turn. A share of the period later the spikes so far are counted and the servo
is told to go to

    angle + gain (spikes of the left - spikes of the right - balance)

in whole steps and within its reach. Nothing is lost without being counted: see `COUNTS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.lso.model import SIDES, Head, side_spikes
from chips.lso.noise import LsoNoise, head_of_ping, noisy_side_spikes
from circuits.arrays import F64, I64
from system.head.ear import SPEED, Echo, amplitudes, listen
from system.head.numbers import BEHIND, SonarHead
from system.head.world import Way

# what the spikes of which neurons turn the head by
WIRINGS = ("lso", "excitation", "one-ear")
# pings without an answer: heard by no level unit, while the ears were shut, from behind, after the decision
LOST = ("faint", "blanked", "behind", "late")
COUNTS = (
    *LOST,
    "clipped",  # ears whose envelope was cut off
    "late_spikes",  # after the decision, and so in vain
    "steps_over",  # pings whose synapses' steps outlast the period: the next ping does not know of them
    "neck_ends",  # commands beyond the neck's reach
    "neck_late",  # pings before which the neck was not there yet
)


ChipAt = Callable[[float], tuple[Head, LsoNoise | None]]  # chip and its noise at a time, s


class Neck(NamedTuple):
    """A servo on its way: angle (rad) at a time (s), and where to.

    goal : angle to which it is on its way, rad.
    """

    angle: float
    time: float
    goal: float

    def at(self, time: float, speed: float) -> float:
        """Angle (rad) at a time (s) from then on, at a speed (rad/s)."""
        reach = speed * (time - self.time)
        return self.angle + max(-reach, min(reach, self.goal - self.angle))


@dataclass(frozen=True, slots=True)
class Log:
    """What a run leaves, ping by ping.

    time : s; target, head : azimuths, rad; distance : m; heard : spikes that were counted, int64[pings,
    SIDES].

    lost: why a ping was, "" where it was not; spikes: (s, side) of all neurons' spikes, float64[spikes, 2];
    levels: (s, side, unit) of the level units'.

    counts : by the names of `COUNTS`.
    """

    time: F64
    target: F64
    head: F64
    distance: F64
    heard: I64
    lost: tuple[str, ...]
    spikes: F64
    levels: F64
    counts: dict[str, int]

    @property
    def error(self) -> F64:
        """Difference between the directions of head and target at the pings, rad."""
        return self.target - self.head


class _Chip(NamedTuple):
    """A die's numbers in a ping, and what varies within it."""

    head: Head
    noise: LsoNoise | None
    ping: int

    def spikes(self, side: int, level: F64, *, inhibited: bool) -> F64:
        """Of an LSO neuron, s after the echo."""
        if self.noise is None:
            return side_spikes(self.head, side, level, inhibited=inhibited)
        return noisy_side_spikes(self.head, self.noise, self.ping, side, level, inhibited=inhibited)


class _Heard(NamedTuple):
    lost: str
    delay: float
    distance: float
    echo: Echo | None


def follow(
    numbers: SonarHead, chip_at: ChipAt, way: Way, duration: float, random: np.random.Generator,
    wiring: str = WIRINGS[0], progress: Callable[[float], None] | None = None, balance: float = 0.0,
) -> Log:  # fmt: skip
    """Follow a target for a time (s), with the echoes' noise drawn from `random`.

    chip_at: the chip in a ping at a time, s, in which its temperature stands, and the noise of its silicon;
    balance: taken from each count of left less right, spikes.
    """
    pings = max(1, math.floor(duration * numbers.ping_rate + 1e-9))
    time = np.arange(pings) / numbers.ping_rate
    echoes = random.standard_normal((pings, SIDES + 1))
    counts = dict.fromkeys(COUNTS, 0)
    neck = Neck(0.0, 0.0, 0.0)
    angles, distances = np.empty(pings), np.empty(pings)
    heard = np.zeros((pings, SIDES), dtype=np.int64)
    lost: list[str] = []
    spikes: list[F64] = []
    levels: list[F64] = []
    resting = usual_spikes(numbers, chip_at(0.0)[0]) if wiring == "one-ear" else 0
    for k, t in enumerate(time):
        angles[k] = neck.at(t, numbers.neck_speed)
        counts["neck_late"] += int(abs(angles[k] - neck.goal) > 1e-9)
        head, noise = chip_at(float(t))
        chip = _Chip(head if noise is None else head_of_ping(head, noise, k, float(t)), noise, k)
        found = _ping(numbers, chip, way, neck, float(t), echoes[k])
        distances[k] = found.distance
        lost.append(found.lost)
        if found.lost:
            counts[found.lost] += 1
        if found.echo is not None:
            counts["clipped"] += found.echo.clipped
            heard[k], late = _answer(numbers, chip, found, float(t), wiring, spikes, levels)
            counts["late_spikes"] += late
            last = found.delay + head.onset + longest_step(chip.head, found.echo.level)
            counts["steps_over"] += int(last > numbers.period)
        turn = _turn(heard[k], wiring, resting) - balance if not found.lost else 0.0
        neck = _commanded(numbers, neck, float(t) + numbers.decision * numbers.period, turn, counts)
        if progress is not None:
            progress((k + 1) / pings)
    target, _ = way.at(time)
    return Log(
        time, target, angles, distances, heard, tuple(lost),
        np.concatenate([np.empty((0, 2)), *spikes]), np.concatenate([np.empty((0, 3)), *levels]), counts,
    )  # fmt: skip


def usual_spikes(numbers: SonarHead, head: Head, distance: float = 1.0) -> int:
    """Spikes of the left neuron, not inhibited, of a target straight ahead (distance in m), without noise."""
    envelope = amplitudes(numbers, 0.0, 0.0, distance)
    return int(side_spikes(head, 0, listen(numbers, head, envelope, 0.0).level, inhibited=False).size)


def longest_step(head: Head, level: F64) -> float:
    """When the last synapse's step ends that level units' spikes (s, inf for none) begin, s; 0 for none."""
    ends = np.maximum(head.excite_step, head.inhibit_step[::-1]) + level
    return float(ends[np.isfinite(ends)].max(initial=0.0))


def _ping(numbers: SonarHead, chip: _Chip, way: Way, neck: Neck, t: float, noise: F64) -> _Heard:
    distance = float(way.at(t)[1])
    for _ in range(4):  # contracts by the target's speed over that of sound
        distance = float(way.at(t + distance / SPEED)[1])
    delay = 2.0 * distance / SPEED
    if delay < numbers.blanking:
        return _Heard("blanked", delay, distance, None)
    azimuth = float(way.at(t + 0.5 * delay)[0])
    sent, heard = (azimuth - neck.at(when, numbers.neck_speed) for when in (t, t + delay))
    if max(abs(sent), abs(heard)) >= BEHIND:
        return _Heard("behind", delay, distance, None)
    loud = np.exp(numbers.glint * noise[-1] + numbers.ear_noise * noise[:SIDES])
    envelope = amplitudes(numbers, sent, heard, distance) * loud
    echo = listen(numbers, chip.head, envelope, heard, chip.noise, chip.ping)
    if not np.isfinite(echo.level).any():
        return _Heard("faint", delay, distance, echo)
    if delay + float(echo.level.min()) > numbers.decision * numbers.period:
        return _Heard("late", delay, distance, echo)
    return _Heard("", delay, distance, echo)


def _answer(
    numbers: SonarHead, chip: _Chip, found: _Heard, t: float, wiring: str,
    spikes: list[F64], levels: list[F64],
) -> tuple[I64, int]:  # fmt: skip
    """Spikes of both neurons by the decision, and how many came after it; all are added to the lists."""
    counted, late = np.zeros(SIDES, dtype=np.int64), 0
    if found.echo is None:
        return counted, late
    level = found.echo.level
    for side in range(SIDES):
        came = found.delay + chip.spikes(side, level, inhibited=wiring == "lso")
        counted[side] = int((came <= numbers.decision * numbers.period).sum())
        late += came.size - int(counted[side])
        spikes.append(np.stack([t + came, np.full(came.size, float(side))], axis=1))
    side_of, unit = np.nonzero(np.isfinite(level))
    levels.append(np.stack([t + found.delay + level[side_of, unit], side_of, unit], axis=1))
    return counted, late


def _turn(heard: I64, wiring: str, resting: int) -> int:
    """Spikes that count: of the left less those of the right, or less what is usual."""
    return int(heard[0]) - (resting if wiring == "one-ear" else int(heard[1]))


def _commanded(numbers: SonarHead, neck: Neck, time: float, turn: float, counts: dict[str, int]) -> Neck:
    """The neck with a new goal; without spikes it goes on to where it was told to."""
    angle = neck.at(time, numbers.neck_speed)
    if turn == 0.0:
        return Neck(angle, time, neck.goal)
    wanted = numbers.neck_step * round((angle + numbers.gain * turn) / numbers.neck_step)
    most = numbers.neck_step * math.floor(numbers.neck_most / numbers.neck_step + 1e-9)
    counts["neck_ends"] += int(abs(wanted) > most)
    return Neck(angle, time, max(-most, min(most, wanted)))
