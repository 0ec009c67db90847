"""Pixels of a dynamic vision sensor, compiled: from the intensity of each to its events.

    L = ln(I + I_dark),   tau dV/dt = L - V,   1 / (2 pi tau) = f(I),   1/f = 1/f_follower + 1/(f_lux I)
    ON where V - V_m >= theta_on, OFF where V_m - V >= theta_off; then V_m moves by that threshold

with I the light on the pixel (lux times reflectance), V the low-passed log light and V_m what the pixel
remembers. Over a step L goes straight from its old to its new value, for which V is exact; V is taken as
straight in between, where the times of events come from. After an event the pixel is held in reset for the
refractory period and remembers V at its end. V_m falls by a leak, which makes ON events, and noise makes
events of either polarity, more of them in the dark. Structure as in v2e (Hu, Liu, Delbruck 2021), whose
refractory period only discards events.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.compiled import compiled
from system.dvs_lamp import ON, PERIOD, Glow, is_on

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

SETTLED = 1e-7  # of log light, below which a pixel counts as steady
ACTIVE = -1.0  # in the place of the light on a pixel that is not steady, so that it differs from any light
LEAK_TURNS = 8  # steps in which every column is leaked once; ours
_PIECES = 8  # of a light's period, over which a lit pixel's V is taken as straight; ours
SPARE = 2.0  # times the rate of a mean pixel: thresholds below half of the mean are no noisier
_compiled = compiled()


class Pixels(NamedTuple):
    """The silicon, number of a pixel: column * rows + row.

    on, off (log light), leak (1/s, of log light): float64[pixels]; hot: int64[hot pixels]. dark: lux;
    follower: Hz; per_lux: Hz/lux; refractory: s; noise: Hz in the dark; noise_lux: where it is half of that;
    noise_most: Hz where the scene is darkest;
    nominal: mean threshold; hot_rate: Hz each.
    """

    on: F64
    off: F64
    leak: F64
    hot: I64
    dark: float
    follower: float
    per_lux: float
    refractory: float
    noise: float
    noise_lux: float
    noise_most: float
    nominal: float
    hot_rate: float


class Memory(NamedTuple):
    """State of the pixels, overwritten in place.

    seen (lux, of a steady pixel, else `ACTIVE`), level (L), filtered (V), kept (V_m), blind (s, until when in
    reset): float64[pixels]; is_lit: int64[pixels], of blinking lights; leaked: float64[columns], s, until
    when; turn: int64[1], whose turn it is to leak; next_noise: float64[2], s, of noise and of hot pixels.
    """

    seen: F64
    level: F64
    filtered: F64
    kept: F64
    blind: F64
    is_lit: I64
    leaked: F64
    turn: I64
    next_noise: F64


class Beat(NamedTuple):
    """One step of the sensor: its begin and its length, s."""

    time: float
    step: float


class Tone(NamedTuple):
    """What light makes of a pixel in a step: L, and for its low-pass tau in steps and exp(-1 / that)."""

    level: float
    over: float
    decay: float


class Desk(NamedTuple):
    """Room for the pixels that one step has to do with.

    pixel: int64[pixels], their numbers, and tone, which of the lights in lux, level, over and decay they
    see; start and end: V at the ends of the step.
    """

    pixel: I64
    tone: I64
    lux: F64
    level: F64
    over: F64
    decay: F64
    start: F64
    end: F64


class Raw(NamedTuple):
    """Events as pixels made them: time (s), code (pixel * 2 + polarity); used: int64[2], kept and lost."""

    time: F64
    code: I64
    used: I64
    desk: Desk


def raw_of(pixels: int, events: int) -> Raw:
    """Room for so many events of so many pixels."""
    # what is written for a pixel that turns out not to count goes one place further
    pixel, tone = (np.zeros(pixels + 1, dtype=np.int64) for _ in range(2))
    lux, level, over, decay, start, end = (np.zeros(pixels + 1) for _ in range(6))
    desk = Desk(pixel, tone, lux, level, over, decay, start, end)
    return Raw(np.zeros(events), np.zeros(events, dtype=np.int64), np.zeros(2, dtype=np.int64), desk)


@_compiled
def bandwidth(follower: float, per_lux: float, lux: float) -> float:
    """Cutoff frequency (Hz) of a pixel in light."""
    return follower * per_lux * lux / (follower + per_lux * lux)


@_compiled
def noise_rate(p: Pixels, lux: float) -> float:
    """Rate (Hz) of noise events of a pixel of the mean threshold in light."""
    return p.noise / (1.0 + lux / p.noise_lux)


@_compiled
def settle(p: Pixels, m: Memory, light: F64, time: float) -> None:
    """Start with pixels that have looked at `light` (lux) for long."""
    for i in range(light.size):
        level = math.log(light[i] + p.dark)
        m.seen[i], m.level[i], m.filtered[i], m.kept[i], m.blind[i] = light[i], level, level, level, -np.inf
        m.is_lit[i] = 0
    m.leaked[:] = time


@_compiled
def expose(
    p: Pixels,
    m: Memory,
    light: F64,
    glow: Glow,
    lamps: F64,
    beat: Beat,
    random: np.random.Generator,
    raw: Raw,
) -> None:
    """Let the light on the pixels go to `light` (lux) within a step; add their events to `raw`."""
    time, step, desk = beat.time, beat.step, raw.desk
    for i in range(glow.used[0]):
        m.is_lit[glow.pixel[i]] = i + 1
        m.seen[glow.pixel[i]] = ACTIVE
    changed = _find_changed(light, m.seen, desk)
    tones = _gather_light(light, desk, changed)
    _make_tones(p, step, desk, tones)
    active = _follow_light(p, m, time, desk, changed)
    for k in range(active):
        i = desk.pixel[k]
        if m.is_lit[i] > 0:
            _blink(p, m, i, light[i], glow, lamps, beat, raw)
            m.is_lit[i] = 0
        else:
            _fire(p, m, i, desk.start[k], desk.end[k], beat, raw)
    _leak(p, m, time, step, raw)
    _add_noise(p, m, time + step, random, raw)


# The next four each go through all pixels for one part of the work, almost without branches: twice as fast as
# one loop for all of it, in which the processor would guess wrong at every other pixel.


@_compiled
def _find_changed(light: F64, seen: F64, desk: Desk) -> int:
    """Pixels whose light is another or that are not steady; how many."""
    count = 0
    for i in range(light.size):
        desk.pixel[count] = i
        count += 1 if light[i] != seen[i] else 0
    return count


@_compiled
def _gather_light(light: F64, desk: Desk, changed: int) -> int:
    """Their light, which neighbours often share; how many different ones in a row."""
    count, last = -1, ACTIVE
    for k in range(changed):
        lux = light[desk.pixel[k]]
        count += 1 if lux != last else 0
        desk.lux[count], desk.tone[k], last = lux, count, lux
    return count + 1


@_compiled
def _make_tones(p: Pixels, step: float, desk: Desk, tones: int) -> None:
    for k in range(tones):
        lux = desk.lux[k]
        tone = _tone(math.log(lux + p.dark), bandwidth(p.follower, p.per_lux, lux), step)
        desk.level[k], desk.over[k], desk.decay[k] = tone.level, tone.over, tone.decay


@_compiled
def _follow_light(p: Pixels, m: Memory, time: float, desk: Desk, changed: int) -> int:
    """Low-pass the light of changed pixels; those that have more to do come to the begin. How many."""
    count = 0
    for k in range(changed):
        i, t = desk.pixel[k], desk.tone[k]
        desk.pixel[count] = i
        if m.is_lit[i] > 0:
            count += 1
            continue
        tone = Tone(desk.level[t], desk.over[t], desk.decay[t])
        start, old = m.filtered[i], m.level[i]
        end = _filtered(tone, start, old)
        steady = (tone.level == old) & (abs(end - tone.level) < SETTLED) & (m.blind[i] <= time)
        m.level[i], m.filtered[i] = tone.level, tone.level if steady else end
        m.seen[i] = desk.lux[t] if steady else ACTIVE
        desk.start[count], desk.end[count] = start, end
        fires = (end - m.kept[i] >= p.on[i]) | (m.kept[i] - end >= p.off[i]) | (m.blind[i] > time)
        count += 1 if fires else 0
    return count


@_compiled
def _tone(level: float, cutoff: float, step: float) -> Tone:
    """What light of a level makes of a pixel of some bandwidth (Hz) in a step (s)."""
    over = 1.0 / (2.0 * math.pi * max(cutoff, 1e-6) * step)
    return Tone(level, over, math.exp(-1.0 / over))


@_compiled
def _filtered(tone: Tone, start: float, old: float) -> float:
    """V after a step in which L goes straight from old to the tone's."""
    slope = tone.level - old
    return float(tone.level - slope * tone.over + (start - old + slope * tone.over) * tone.decay)


@_compiled
def _fire(p: Pixels, m: Memory, i: int, start: float, end: float, beat: Beat, raw: Raw) -> None:
    """Events of a pixel whose V goes straight from start to end; what it remembers at the end."""
    time, step = beat.time, beat.step
    slope = (end - start) / step
    now = 0.0  # s since the step's begin
    if m.blind[i] > time:
        now = min(m.blind[i] - time, step)
        m.kept[i] = start + slope * now
    while now < step:
        on = end >= m.kept[i]
        theta = p.on[i] if on else p.off[i]
        goal = m.kept[i] + theta if on else m.kept[i] - theta
        if (end < goal) if on else (end > goal):
            break
        at = (goal - start) / slope if slope != 0.0 else now
        now = min(max(at, now), step)  # the leak may have crossed before
        _note(raw, time + now, 2 * i + (1 if on else 0))
        m.blind[i] = time + now + p.refractory
        m.kept[i] = goal
        if p.refractory > 0.0:
            now = min(now + p.refractory, step)
            m.kept[i] = start + slope * now


@_compiled
def _blink(p: Pixels, m: Memory, i: int, lux: float, glow: Glow, lamps: F64, beat: Beat, raw: Raw) -> None:
    """One pixel with a light on it: pieces no longer than an eighth of a period, ended by its edges."""
    k = m.is_lit[i] - 1
    lamp = lamps[glow.lamp[k]]
    bright = lux + glow.lux[k]
    levels = math.log(lux + p.dark), math.log(bright + p.dark)
    cutoffs = bandwidth(p.follower, p.per_lux, lux), bandwidth(p.follower, p.per_lux, bright)
    now, end = beat.time, beat.time + beat.step
    while end - now > 1e-12:
        stop = min(_next_edge(lamp, now), now + lamp[PERIOD] / _PIECES, end)
        lit = 1 if is_on(lamp, 0.5 * (now + stop)) else 0
        tone = _tone(levels[lit], cutoffs[lit], stop - now)
        before = m.filtered[i]
        after = _filtered(tone, before, tone.level)
        if after - m.kept[i] >= p.on[i] or m.kept[i] - after >= p.off[i] or m.blind[i] > now:
            _fire(p, m, i, before, after, Beat(now, stop - now), raw)
        m.level[i], m.filtered[i] = tone.level, after
        now = stop


@_compiled
def _leak(p: Pixels, m: Memory, time: float, step: float, raw: Raw) -> None:
    """Let an eighth of the columns leak for all the time since their last turn."""
    rows = p.on.size // m.leaked.size
    for column in range(m.turn[0], m.leaked.size, LEAK_TURNS):
        gone = time + step - m.leaked[column]
        m.leaked[column] = time + step
        first, last = column * rows, (column + 1) * rows
        if _sink(m.kept[first:last], p.leak[first:last], gone, m.filtered[first:last], p.on[first:last]) == 0:
            continue
        for i in range(first, last):
            over = m.filtered[i] - m.kept[i] - p.on[i]
            if over >= 0.0 and m.blind[i] <= time:
                _note(raw, max(time + step - over / max(p.leak[i], 1e-12), time), 2 * i + 1)
                m.kept[i] = m.filtered[i]
                m.blind[i] = time + step + p.refractory
    m.turn[0] = (m.turn[0] + 1) % LEAK_TURNS


@_compiled
def _sink(kept: F64, leak: F64, gone: float, filtered: F64, on: F64) -> int:
    """Let some pixels leak for `gone` s; how many are then at their threshold."""
    count = 0
    for i in range(kept.size):
        kept[i] -= leak[i] * gone
        count += 1 if filtered[i] - kept[i] - on[i] >= 0.0 else 0
    return count


@_compiled
def _next_edge(lamp: F64, now: float) -> float:
    """When a light goes on or off next, after `now` s."""
    turns = math.floor(now / lamp[PERIOD] + 1e-9)
    off = (turns + lamp[ON]) * lamp[PERIOD]
    return float(off if off > now + 1e-9 else (turns + 1.0) * lamp[PERIOD])


@_compiled
def _add_noise(p: Pixels, m: Memory, until: float, random: np.random.Generator, raw: Raw) -> None:
    """Events that nothing seen has made, up to `until` s: thinned from as many as the dark would make."""
    total = SPARE * p.noise_most * p.on.size
    while m.next_noise[0] < until:
        i = int(random.random() * p.on.size)
        polarity = int(2.0 * random.random())
        theta = p.on[i] if polarity == 1 else p.off[i]
        # as in v2e, a pixel of a lower threshold is noisier
        chance = noise_rate(p, math.exp(m.level[i]) - p.dark) / p.noise_most * p.nominal / theta / SPARE
        if random.random() < chance:
            _spurious(p, m, i, m.next_noise[0], polarity, raw)
        m.next_noise[0] += random.exponential(1.0) / total
    while m.next_noise[1] < until:
        i = p.hot[int(random.random() * p.hot.size)]
        _spurious(p, m, i, m.next_noise[1], 1, raw)
        m.next_noise[1] += random.exponential(1.0) / (p.hot_rate * p.hot.size)


@_compiled
def _spurious(p: Pixels, m: Memory, i: int, at: float, polarity: int, raw: Raw) -> None:
    """An event of noise, which resets its pixel like any other."""
    if at < m.blind[i]:
        return
    _note(raw, at, 2 * i + polarity)
    m.blind[i] = at + p.refractory
    m.kept[i] = m.filtered[i]


@_compiled
def _note(raw: Raw, time: float, code: int) -> None:
    i = raw.used[0]
    if i < raw.time.size:
        raw.time[i], raw.code[i] = time, code
        raw.used[0] += 1
    else:
        raw.used[1] += 1
