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

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from system.worlds.camera.lamp import ON, PERIOD, Glow, is_on
from system.worlds.camera.noise import add_noise, leak
from system.worlds.camera.pixel import ACTIVE, Beat, Desk, Memory, Pixels, Raw, Tone, bandwidth, note_event

SETTLED = 1e-7  # of log light, below which a pixel counts as steady
_PIECES = 8  # of a light's period, over which a lit pixel's V is taken as straight; ours
_compiled = compiled()


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
    leak(p, m, time, step, raw)
    add_noise(p, m, time + step, random, raw)


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
        note_event(raw, time + now, 2 * i + (1 if on else 0))
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
def _next_edge(lamp: F64, now: float) -> float:
    """When a light goes on or off next, after `now` s."""
    turns = math.floor(now / lamp[PERIOD] + 1e-9)
    off = (turns + lamp[ON]) * lamp[PERIOD]
    return float(off if off > now + 1e-9 else (turns + 1.0) * lamp[PERIOD])
