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
from dataclasses import dataclass, field
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


SETTLED, ANSWERED = 5.0, 0.9  # deg rms of the second half, share of the pings; ours
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


AHEAD = Neck(0.0, 0.0, 0.0)


@dataclass(slots=True)
class Following:
    """A head that follows a target, ping by ping: `hear_ping`, then `told`, and again.

    numbers, way : of the head, and of its target.
    chip_at : the chip in a ping at a time, s, and the noise of its silicon.
    echoes : noise of the echoes, float64[pings, SIDES + 1].
    wiring, balance, resting : as of `follow`, and what is usual, spikes.
    neck : where the neck is, and where to.
    pings : made so far; the others are what they brought, one entry a ping.
    """

    numbers: SonarHead
    chip_at: ChipAt
    way: Way
    echoes: F64
    wiring: str = WIRINGS[0]
    balance: float = 0.0
    resting: int = 0
    neck: Neck = AHEAD
    pings: int = 0
    angles: list[float] = field(default_factory=list)
    distances: list[float] = field(default_factory=list)
    heard: list[I64] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)
    spikes: list[F64] = field(default_factory=list)
    levels: list[F64] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COUNTS, 0))

    @property
    def time(self) -> float:
        """Time of the next ping, s."""
        return self.pings / self.numbers.ping_rate

    def log(self) -> Log:
        """Return what the pings so far have left."""
        time = np.arange(self.pings) / self.numbers.ping_rate
        target, _ = self.way.at(time)
        return Log(
            time, target, np.array(self.angles), np.array(self.distances),
            np.array(self.heard, dtype=np.int64).reshape(-1, SIDES), tuple(self.lost),
            np.concatenate([np.empty((0, 2)), *self.spikes]),
            np.concatenate([np.empty((0, 3)), *self.levels]), self.counts,
        )  # fmt: skip


def begin_following(
    numbers: SonarHead, chip_at: ChipAt, way: Way, duration: float, random: np.random.Generator,
    wiring: str = WIRINGS[0], balance: float = 0.0,
) -> Following:  # fmt: skip
    """Return a head at rest before its first ping; the parameters are those of `follow`."""
    pings = max(1, math.floor(duration * numbers.ping_rate + 1e-9))
    echoes = random.standard_normal((pings, SIDES + 1))
    resting = usual_spikes(numbers, chip_at(0.0)[0]) if wiring == "one-ear" else 0
    return Following(numbers, chip_at, way, echoes, wiring, balance, resting)


def hear_ping(head: Following) -> None:
    """Make a ping and hear its echo."""
    numbers, k, t = head.numbers, head.pings, head.time
    angle = head.neck.at(t, numbers.neck_speed)
    head.counts["neck_late"] += int(abs(angle - head.neck.goal) > 1e-9)
    on, noise = head.chip_at(t)
    chip = _Chip(on if noise is None else head_of_ping(on, noise, k, t), noise, k)
    found = _ping(numbers, chip, head.way, head.neck, t, head.echoes[k])
    heard = np.zeros(SIDES, dtype=np.int64)
    if found.lost:
        head.counts[found.lost] += 1
    if found.echo is not None:
        head.counts["clipped"] += found.echo.clipped
        heard, late = _answer(numbers, chip, found, t, head.wiring, head.spikes, head.levels)
        head.counts["late_spikes"] += late
        last = found.delay + on.onset + longest_step(chip.head, found.echo.level)
        head.counts["steps_over"] += int(last > numbers.period)
    head.angles.append(angle)
    head.distances.append(found.distance)
    head.lost.append(found.lost)
    head.heard.append(heard)
    head.pings += 1


def told(head: Following) -> Neck:
    """Return the neck as the last ping's spikes tell it to go."""
    turn = 0.0
    if not head.lost[-1]:
        turn = _turn(head.heard[-1], head.wiring, head.resting) - head.balance
    return _commanded(head.numbers, head.neck, decision(head), turn, head.counts)


def decision(head: Following) -> float:
    """Return when spikes are counted and the neck is told, s, after the last ping."""
    numbers = head.numbers
    return (head.pings - 1) / numbers.ping_rate + numbers.decision * numbers.period


def follow(
    numbers: SonarHead, chip_at: ChipAt, way: Way, duration: float, random: np.random.Generator,
    wiring: str = WIRINGS[0], progress: Callable[[float], None] | None = None, balance: float = 0.0,
) -> Log:  # fmt: skip
    """Follow a target for a time (s), with the echoes' noise drawn from `random`.

    chip_at: the chip in a ping at a time, s, in which its temperature stands, and the noise of its silicon;
    balance: taken from each count of left less right, spikes.
    """
    head = begin_following(numbers, chip_at, way, duration, random, wiring, balance)
    pings = len(head.echoes)
    while head.pings < pings:
        hear_ping(head)
        head.neck = told(head)
        if progress is not None:
            progress(head.pings / pings)
    return head.log()


def follows(log: Log) -> bool:
    """Whether the second half of the pings points at the target, and most have an answer."""
    error = np.degrees(log.error)[len(log.time) // 2 :]
    answered = 1.0 - sum(log.counts[name] for name in LOST) / len(log.time)
    return bool(np.sqrt(np.mean(error**2)) <= SETTLED and answered >= ANSWERED)


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


def most_of(numbers: SonarHead) -> float:
    """Return the farthest whole step of the servo to either side, rad."""
    return numbers.neck_step * math.floor(numbers.neck_most / numbers.neck_step + 1e-9)


def _commanded(numbers: SonarHead, neck: Neck, time: float, turn: float, counts: dict[str, int]) -> Neck:
    """The neck with a new goal; without spikes it goes on to where it was told to."""
    angle = neck.at(time, numbers.neck_speed)
    if turn == 0.0:
        return Neck(angle, time, neck.goal)
    wanted = numbers.neck_step * round((angle + numbers.gain * turn) / numbers.neck_step)
    most = most_of(numbers)
    counts["neck_ends"] += int(abs(wanted) > most)
    return Neck(angle, time, max(-most, min(most, wanted)))
