"""The compiled loop of the approach, for runs in which every box is a measured model.

Goes from event to event: a spike of the hearing, a spike of the chip, a call. Between events the centroid
boards are advanced by their exact stretches and the vocalization controller along the straight proximity
between these, so that a call ends a stretch. A call makes sounds, sounds make spikes of the hearing, these
reach the chip; the chip's spikes reach the boards. Same equations as the parts of `system.approach.loop` run
by `system.loop`, except that nothing between the boards is thinned, and that first-target isolation switches
at once: its circuit's delays matter only to an echo that comes within them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.boards.centroid.kernel import Centroid, centroid_step
from chips.boards.vocalization.kernel import Vocalization, amplitude_at, vocalization_line
from chips.boards.vocalization.noise import OscillatorNoise, phase_after_call
from chips.hearing.kernel import Hearing, hear_sound
from chips.hearing.noise import HearingNoise, threshold_factors
from chips.ranging.kernel import PULSE, Chip, Plan, next_due, on_call, on_echo, take
from chips.ranging.law import Neurons
from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.event import HALF_WIDTH

KINDS = range(5)  # of a row of the log
CALL, PULSE_HEARD, ONSET_HEARD, SPIKE, BOARD = KINDS
ROW = (
    4  # columns of the log: kind, time (s), then (amplitude V), (), (), (neuron), (proximity V, amplitude V)
)
SPARE = 64  # rows that one event may need
SOUNDS = 256  # remembered; more than 20 ms can hold with the shortest interval and eight targets
MERGED, UNDECIDED, CLIPPED, CALLED, HEARD = range(5)  # columns of the counts
COUNTS = 5
_TRIES = 60  # of a delay; a third of the error is left by each at the very worst
_DELAY_ERROR = 1e-12  # s

_compiled = compiled()


class Scene(NamedTuple):
    """Targets and ear. time (s), distance (m): float64[targets, points], held beyond; strength: [targets]."""

    time: F64
    distance: F64
    strength: F64
    speed: float  # of sound, m/s
    absorption: float  # dB/m
    mouth_ear_delay: float  # s
    direct: float  # V at the microphone per V of call
    echo: float  # V per V, of the reference reflector at 1 m
    headroom: float  # V, peak at which the amplifier clips


class Boards(NamedTuple):
    """What stands behind the chip; `amplitude` is `proximity` again where one board gives both.

    heard: whether a neuron's spikes reach the boards, bool[neurons].
    """

    proximity: Centroid
    amplitude: Centroid
    vocalization: Vocalization
    onset: Hearing
    high_threshold: Hearing
    interval_noise: OscillatorNoise
    hearing_noise: HearingNoise
    heard: Bools


class Run(NamedTuple):
    """State of a run, overwritten in place."""

    boards: F64  # float64[boards, 4], of each centroid: time, hold, follower, filtered
    ends: F64  # float64[boards, neurons], s, when each gate goes off
    oscillator: F64  # float64[2], phase and when the interval begins, s
    sounds: F64  # float64[SOUNDS, 2], onset (s) and peak (V)
    due: F64  # float64[2 * SOUNDS, 2], time (s) and kind of the hearing's spikes to come, in order
    used: I64  # int64[3], sounds, spikes due, rows of the log
    levels: F64  # float64[3], v_ex_max now, open and isolated, V; NaN where the neurons' own holds
    counts: I64  # int64[COUNTS], merged, undecided, clipped; calls and sounds so far
    log: F64  # float64[rows, ROW]


@_compiled
def fly(scene: Scene, b: Boards, m: Neurons, p: Plan, c: Chip, r: Run, until: float) -> float:
    """Go on to `until` (s), or to where the log has no more room; returns the time reached."""
    while r.used[2] + SPARE < r.log.shape[0]:
        spike, k = next_due(c)
        heard = r.due[0, 0] if r.used[1] > 0 else np.inf
        called = _to_call(b, r, min(until, spike, heard))
        now = r.boards[0, 0]
        if called < np.inf:
            _emit(scene, b, r, called)
        elif now >= heard and heard <= spike:
            _deliver(m, p, c, r)
        elif now >= spike:
            if take(m, p, c, k) and b.heard[k]:
                _note(r, SPIKE, spike, float(k), 0.0)
                _gates(r, k, spike)
                r.levels[0] = r.levels[2]
        elif now >= until:
            break
    return float(r.boards[0, 0])


@_compiled
def _note(r: Run, kind: int, time: float, a: float, b: float) -> None:
    row = r.log[r.used[2]]
    row[0], row[1], row[2], row[3] = kind, time, a, b
    r.used[2] += 1


@_compiled
def _to_call(b: Boards, r: Run, until: float) -> float:
    """Advance the boards to `until` (s) or to a call; its time, else inf."""
    y, before = r.boards[0], (0.0, 0.0, 0.0, 0.0)
    while y[0] < until and r.used[2] + 2 < r.log.shape[0]:
        before = (y[0], y[1], y[2], y[3])
        centroid_step(b.proximity, r.ends[0], y, until)
        first, last = before[3] + b.proximity.offset, y[3] + b.proximity.offset
        called = vocalization_line(b.vocalization, r.oscillator, before[0], y[0], first, last)
        if called < np.inf:
            y[0], y[1], y[2], y[3] = before
            while y[0] < called:
                centroid_step(b.proximity, r.ends[0], y, called)
        if r.boards.shape[0] > 1:
            while r.boards[1, 0] < y[0]:
                centroid_step(b.amplitude, r.ends[1], r.boards[1], y[0])
        _note(r, BOARD, y[0], y[3] + b.proximity.offset, _amplitude(b, r))
        if called < np.inf:
            rate = b.vocalization.base + b.vocalization.slope * (y[3] + b.proximity.offset)
            r.oscillator[0] += phase_after_call(b.interval_noise, r.counts[CALLED], rate)
            r.counts[CALLED] += 1
            return called
    return np.inf


@_compiled
def _amplitude(b: Boards, r: Run) -> float:
    """Of a call now, V."""
    control = r.boards[r.boards.shape[0] - 1, 3] + b.amplitude.offset
    return amplitude_at(b.vocalization, control)


@_compiled
def _gates(r: Run, k: int, time: float) -> None:
    """Open the gates of neuron k for an event's width."""
    for i in range(r.ends.shape[0]):
        if time <= r.ends[i, k] - HALF_WIDTH + PULSE:
            r.counts[MERGED] += 1
        else:
            r.ends[i, k] = time + HALF_WIDTH


@_compiled
def _deliver(m: Neurons, p: Plan, c: Chip, r: Run) -> None:
    """Hand the hearing's next spike to chip and isolation."""
    time, kind = r.due[0, 0], int(r.due[0, 1])
    r.used[1] -= 1
    for i in range(r.used[1]):
        r.due[i, 0], r.due[i, 1] = r.due[i + 1, 0], r.due[i + 1, 1]
    _note(r, kind, time, 0.0, 0.0)
    if kind == PULSE_HEARD:
        on_call(m, p, c, time)
        r.levels[0] = r.levels[1]
    else:
        on_echo(m, p, c, time, r.levels[0])


@_compiled
def _emit(scene: Scene, b: Boards, r: Run, time: float) -> None:
    """Sound a call at `time` s: directly and by every target, in the order of the onsets."""
    amplitude = _amplitude(b, r)
    _note(r, CALL, time, amplitude, 0.0)
    if amplitude == 0.0:
        return
    first = r.used[0]
    _sound(r, time + scene.mouth_ear_delay, scene.direct * amplitude)
    for k in range(scene.strength.size):
        delay = echo_delay(scene, k, time)
        distance = 0.5 * scene.speed * delay
        loss = 10.0 ** (-scene.absorption * (distance - 1.0) / 10.0)
        _sound(r, time + delay, scene.echo * amplitude * scene.strength[k] / distance**2 * loss)
    for i in range(first, r.used[0]):
        r.counts[CLIPPED] += r.sounds[i, 1] > scene.headroom
        _hear(b, r, i + 1)
    _forget(r)


@_compiled
def _sound(r: Run, onset: float, peak: float) -> None:
    """Put a sound among those known, in the order of the onsets."""
    i = r.used[0]
    while i > 0 and r.sounds[i - 1, 0] > onset:
        r.sounds[i, 0], r.sounds[i, 1] = r.sounds[i - 1, 0], r.sounds[i - 1, 1]
        i -= 1
    r.sounds[i, 0], r.sounds[i, 1] = onset, peak
    r.used[0] += 1


@_compiled
def _hear(b: Boards, r: Run, count: int) -> None:
    """Put the spikes of the last of `count` sounds among those that are due."""
    peak = r.sounds[count - 1, 1]
    one, other = threshold_factors(
        b.hearing_noise, r.counts[HEARD], peak / b.onset.threshold, peak / b.high_threshold.threshold
    )
    r.counts[HEARD] += 1
    onset, high, unsure = hear_sound(_moved(b.onset, one), _moved(b.high_threshold, other), r.sounds, count)
    r.counts[UNDECIDED] += unsure
    for time, kind in ((onset, ONSET_HEARD), (high, PULSE_HEARD)):
        if time == np.inf:
            continue
        i = r.used[1]
        while i > 0 and r.due[i - 1, 0] > time:
            r.due[i, 0], r.due[i, 1] = r.due[i - 1, 0], r.due[i - 1, 1]
            i -= 1
        r.due[i, 0], r.due[i, 1] = time, float(kind)
        r.used[1] += 1


@_compiled
def _moved(m: Hearing, by: float) -> Hearing:
    """The same with its threshold multiplied."""
    return Hearing(m.threshold * by, m.knots, m.latency, m.recovery_knots, m.recovery)


@_compiled
def _forget(r: Run) -> None:
    """Keep the later half of the sounds where there are many."""
    if r.used[0] <= r.sounds.shape[0] // 2:
        return
    drop = r.used[0] - r.sounds.shape[0] // 4
    for i in range(drop, r.used[0]):
        r.sounds[i - drop, 0], r.sounds[i - drop, 1] = r.sounds[i, 0], r.sounds[i, 1]
    r.used[0] -= drop


@_compiled
def echo_delay(scene: Scene, k: int, emission: float) -> float:
    """Delay (s) of target k's echo of what leaves the speaker at `emission` s, as `acoustics.echo_delay`."""
    one_way = _distance(scene, k, emission) / scene.speed
    for _ in range(_TRIES):
        before = one_way
        one_way = _distance(scene, k, emission + one_way) / scene.speed
        if abs(one_way - before) <= _DELAY_ERROR:
            break
    return 2.0 * one_way


@_compiled
def _distance(scene: Scene, k: int, time: float) -> float:
    """Range of target k at `time` s, m."""
    t, d = scene.time[k], scene.distance[k]
    if time <= t[0]:
        return float(d[0])
    for i in range(1, t.size):
        if time < t[i]:
            return float(d[i - 1] + (d[i] - d[i - 1]) * (time - t[i - 1]) / (t[i] - t[i - 1]))
    return float(d[t.size - 1])
