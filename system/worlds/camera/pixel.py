"""The pixels of a dynamic vision sensor: their silicon, what they remember, and the events they make."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled

ACTIVE = -1.0  # in the place of the light on a pixel that is not steady, so that it differs from any light
_compiled = compiled()


class Pixels(NamedTuple):
    """The silicon of all pixels; the number of a pixel is column * rows + row.

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
    """One step of the sensor: its begin and its length, s.

    time : at which it begins, s.
    """

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
def note_event(raw: Raw, time: float, code: int) -> None:
    """Keep an event of a code (pixel * 2 + polarity), or count it as lost."""
    i = raw.used[0]
    if i < raw.time.size:
        raw.time[i], raw.code[i] = time, code
        raw.used[0] += 1
    else:
        raw.used[1] += 1
