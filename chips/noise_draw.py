"""Random numbers of a chip's noise, step by step, and slow (flicker) processes, without allocation.

A draw is a function of (key, number of the step, stream, place) alone, whatever was drawn before. It is the
sum of a Philox word's four bytes, with the normal's first three moments, which is what the weak order of a
step asks for (Kloeden, Platen, "Numerical Solution of Stochastic Differential Equations", 1992, chapter 14);
the sum of ten steps has a kurtosis 0.03 below the normal's.

Flicker of density `K / f^AF` is the sum of octaves, values that are held for T_j = 2^j T_0, T_0 being eight
steps, and have the variance

    s_j^2 = ln 2 K T_j^(AF - 1) / (2 M),   M = int_0^inf x^(AF - 1) sinc^2(x) dx = 1/2 at AF = 1,

as each has the density `2 s^2 T sinc^2(f T)`; T_j ends at half a period of LOWEST_FREQUENCY.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F32, F64, I64, U32
from circuits.compiled import compiled
from circuits.devices.noise import NoiseModel
from circuits.silicon.die import philox
from circuits.solver.noise.transient import LOWEST_FREQUENCY, noise_keys

LOOK_BITS = 3  # a look at the flicker every eight steps, far above where it passes below white noise; ours
SLOW = 1 << 20  # streams from here on are the octaves'
_MOST_OCTAVES = 64
_PER_BLOCK = 4  # draws of a Philox block
_MEAN, _SCALE = np.float32(510.0), np.float32(1.0 / math.sqrt((256.0**2 - 1.0) / 3.0))

_compiled = compiled(fastmath={"contract", "nsz", "arcp"})


class Draws(NamedTuple):
    """Working space of the random-number generator, and the numbers that it drew last.

    keys: uint32[2, blocks]; counters, words: uint32[4, blocks], of Philox; normal: float32[4 blocks], drawn,
    or the first quarters of these.
    """

    keys: U32
    counters: U32
    words: U32
    normal: F32


class Slow(NamedTuple):
    """Slow processes at n places.

    deviation: of each octave, float32[processes, octaves]; held: the octaves, float32[processes, octaves, n];
    value: their sum, float32[processes, n]; look: the look that they are of, -1 for none, int64[1].
    """

    deviation: F32
    held: F32
    value: F32
    look: I64


def new_draws(seed: int, trial: int, path: str, count: int) -> Draws:
    """Prepare draws at `count` places of the noise that `path` names, for a seed and a trial."""
    blocks = -(-count // _PER_BLOCK)
    counters = np.zeros((4, blocks), np.uint32)
    counters[1] = np.arange(blocks)
    keys = np.repeat(noise_keys(seed, trial, [path]), blocks, axis=1)
    return Draws(keys, counters, np.zeros_like(counters), np.zeros(_PER_BLOCK * blocks, np.float32))


def new_slow(density: F64, model: NoiseModel, step: float, count: int) -> Slow:
    """Prepare slow processes for steps of `step` s; there are none for a model without flicker.

    density: of each process at 1 Hz, 1/Hz, float64[processes]; count: places, those of the `Draws` that it is
    drawn with.
    """
    octaves = np.zeros((density.size, 0))
    if model.flicker_n > 0.0 or model.flicker_p > 0.0:
        first = step * (1 << LOOK_BITS)
        times = first * np.exp2(np.arange(1 + max(1, math.ceil(math.log2(0.5 / (LOWEST_FREQUENCY * first))))))
        weight = octave_weight(model.exponent) * times ** (model.exponent - 1.0)
        octaves = np.sqrt(density[:, None] * weight)
    places = _PER_BLOCK * -(-count // _PER_BLOCK)
    return Slow(
        octaves.astype(np.float32),
        np.zeros((*octaves.shape, places), np.float32),
        np.zeros((density.size, places), np.float32),
        np.full(1, -1, np.int64),
    )


def copied_slow(s: Slow) -> Slow:
    """Return the same processes with working space of their own, from any look on."""
    return Slow(s.deviation, s.held.copy(), s.value.copy(), np.full(1, -1, np.int64))


def first_draws(d: Draws, count: int) -> Draws:
    """Return the draws of the first `count` places alone, whole quarters of all."""
    return d._replace(counters=d.counters.copy(), words=d.words.copy(), normal=d.normal[:count].copy())


def first_slow(s: Slow, count: int) -> Slow:
    """Return the slow processes of the first `count` places alone, from any look on."""
    return copied_slow(s._replace(held=s.held[..., :count], value=s.value[:, :count]))


def octave_weight(exponent: float) -> float:
    """Return the variance `ln 2 / (2 M)` of an octave that lasts 1 s, for a density of `1 / f^exponent`."""
    s = exponent - 2.0
    m = -((2.0 * math.pi) ** -s) / (4.0 * math.pi * math.gamma(1.0 - s) * math.sin(0.5 * math.pi * s))
    return float(math.log(2.0) / (2.0 * m))


@_compiled
def draw(d: Draws, number: int, stream: int) -> None:
    """Draw a stream's numbers of step or look `number` into `d.normal`, of mean 0 and variance 1."""
    d.counters[0, :] = np.uint32(number & 0xFFFFFFFF)
    d.counters[2, :] = np.uint32(number >> 32)
    d.counters[3, :] = np.uint32(stream)
    philox(d.keys, d.counters, d.words)
    blocks = d.words.shape[1]
    for w in range(d.normal.size // blocks if blocks else 0):
        for b in range(blocks):
            x = d.words[w, b]
            total = (x & 255) + ((x >> 8) & 255) + ((x >> 16) & 255) + (x >> 24)
            d.normal[w * blocks + b] = (np.float32(total) - _MEAN) * _SCALE


def normals(fixed: Draws, number: int, like: F64, stream: int = 0) -> F64:
    """Draws of a stream in step `number`, float64 of the shape of `like`.

    `fixed` is not written to, so that several threads may share it.
    """
    own = Draws(fixed.keys, fixed.counters.copy(), fixed.words.copy(), fixed.normal.copy())
    draw(own, number, stream)
    return np.asarray(own.normal[: like.size].reshape(like.shape), dtype=np.float64)


@_compiled
def bring(s: Slow, d: Draws, number: int) -> None:
    """Bring slow processes to step `number`; octave j > 0 changes half-way between the changes of j + 1."""
    look = number >> LOOK_BITS
    octaves = s.deviation.shape[1]
    if octaves == 0 or s.look[0] == look:
        return
    follows = s.look[0] >= 0 and s.look[0] + 1 == look
    changed = 1
    while changed < octaves and not (look >> (changed - 1)) & 1:
        changed += 1
    for p in range(s.deviation.shape[0]):
        for j in range(octaves):
            if follows and j > 0 and j != changed:
                continue
            draw(d, (look + ((1 << j) >> 1)) >> j, SLOW + p * _MOST_OCTAVES + j)
            for k in range(d.normal.size):
                s.held[p, j, k] = s.deviation[p, j] * d.normal[k]
        s.value[p, :] = np.float32(0.0)
        for j in range(octaves):
            for k in range(d.normal.size):
                s.value[p, k] += s.held[p, j, k]
    s.look[0] = look
