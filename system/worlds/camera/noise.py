"""Events of a dynamic vision sensor that nothing seen has made, compiled: leak, noise and hot pixels.

V_m of every pixel falls by a leak, which makes ON events. Noise makes events of either polarity, more of them
in the dark: they are drawn for the darkest that the scene can be, and then thinned. Structure as in v2e (Hu,
Liu, Delbruck 2021).
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from system.worlds.camera.pixel import Memory, Pixels, Raw, noise_rate, note_event

_LEAK_TURNS = 8  # steps in which every column is leaked once; ours
SPARE = 2.0  # times the rate of a mean pixel: thresholds below half of the mean are no noisier
_compiled = compiled()


@_compiled
def leak(p: Pixels, m: Memory, time: float, step: float, raw: Raw) -> None:
    """Let an eighth of the columns leak for all the time since their last turn."""
    rows = p.on.size // m.leaked.size
    for column in range(m.turn[0], m.leaked.size, _LEAK_TURNS):
        gone = time + step - m.leaked[column]
        m.leaked[column] = time + step
        first, last = column * rows, (column + 1) * rows
        if _sink(m.kept[first:last], p.leak[first:last], gone, m.filtered[first:last], p.on[first:last]) == 0:
            continue
        for i in range(first, last):
            over = m.filtered[i] - m.kept[i] - p.on[i]
            if over >= 0.0 and m.blind[i] <= time:
                note_event(raw, max(time + step - over / max(p.leak[i], 1e-12), time), 2 * i + 1)
                m.kept[i] = m.filtered[i]
                m.blind[i] = time + step + p.refractory
    m.turn[0] = (m.turn[0] + 1) % _LEAK_TURNS


@_compiled
def _sink(kept: F64, leak: F64, gone: float, filtered: F64, on: F64) -> int:
    """Let some pixels leak for `gone` s; how many are then at their threshold."""
    count = 0
    for i in range(kept.size):
        kept[i] -= leak[i] * gone
        count += 1 if filtered[i] - kept[i] - on[i] >= 0.0 else 0
    return count


@_compiled
def add_noise(p: Pixels, m: Memory, until: float, random: np.random.Generator, raw: Raw) -> None:
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
    note_event(raw, at, 2 * i + polarity)
    m.blind[i] = at + p.refractory
    m.kept[i] = m.filtered[i]
