"""Targets that move about the sonar head: where they are at any time.

    sine    azimuth = A sin(2 pi t / T)
    step    azimuth = 0 before t_s, A from then on
    walk    azimuth and distance with speeds that are kept for a while: an Ornstein-Uhlenbeck process of the
            seed, reflected at +-A and at distance +- swing

Distance of a sine and a step: `d + s sin(2 pi t / T_s)`. All are kept every 5 ms and linear between.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.head.numbers import Motion

MOTIONS = ("sine", "step", "walk")
EVERY = 5e-3  # s; ours


class Way(NamedTuple):
    """The way of a target about the head.

    azimuth : rad to the left, and distance : m, both every `EVERY` s from 0 on.
    """

    azimuth: F64
    distance: F64

    def at(self, time: ArrayLike) -> tuple[F64, F64]:
        """Azimuth (rad) and distance (m) at a time (s) within the way, in its shape."""
        when = np.asarray(time, dtype=np.float64) / EVERY
        index = np.arange(self.azimuth.size)
        return np.interp(when, index, self.azimuth), np.interp(when, index, self.distance)


def way_of(kind: str, motion: Motion, duration: float, random: np.random.Generator) -> Way:
    """Way of a motion of `MOTIONS` for a time (s); raises `ParameterError` for another."""
    if kind not in MOTIONS:
        raise ParameterError(f"motion: {kind}, must be {', '.join(MOTIONS[:-1])} or {MOTIONS[-1]}")
    time = EVERY * np.arange(math.ceil(duration / EVERY) + 2)
    if kind == "walk":
        azimuth = _walk(time.size, motion.walk_rate, motion.walk_time, random)
        # the same share of its room a second as the azimuth
        share = motion.swing / motion.azimuth if motion.azimuth > 0.0 else 0.0
        distance = _walk(time.size, share * motion.walk_rate, motion.walk_time, random)
        return Way(_reflected(azimuth, motion.azimuth), motion.distance + _reflected(distance, motion.swing))
    distance = motion.distance + motion.swing * np.sin(2.0 * np.pi * time / motion.swing_period)
    if kind == "sine":
        return Way(motion.azimuth * np.sin(2.0 * np.pi * time / motion.period), distance)
    return Way(np.where(time < motion.step_at, 0.0, motion.azimuth), distance)


def _walk(count: int, rate: float, kept: float, random: np.random.Generator) -> F64:
    """Integral of a speed of this rms that forgets itself within a time (s)."""
    memory = math.exp(-EVERY / kept)
    kicks = rate * math.sqrt(1.0 - memory**2) * random.standard_normal(count)
    speed = np.empty(count)
    now = rate * float(random.standard_normal())
    for k, kick in enumerate(kicks):
        speed[k] = now
        now = memory * now + kick
    return np.concatenate([[0.0], np.cumsum(speed[:-1]) * EVERY])


def _reflected(values: F64, most: float) -> F64:
    """Values folded into -most to most, as between two mirrors."""
    if most == 0.0:
        return np.zeros_like(values)
    return np.abs((values - most) % (4.0 * most) - 2.0 * most) - most
