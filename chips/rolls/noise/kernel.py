"""Compiled noise of a ROLLS chip's steps, which filters and membranes get from their devices.

White noise of a membrane is a current that stands still for a step h, drawn with the variance `D / h`, in the
parts of a fast neuron's step too; while the neuron's own current carries it to the top it is one current up
to there, with the variance that gives the spike's time the one that white noise gives it. That of a filter is
a charge a step. Flicker moves six currents slowly, each a sum of values held for 2^j looks; lines of the
generator move some of all neurons.
"""

from __future__ import annotations

import math

import numpy as np

from chips.lines.steps import bring_lines
from chips.noise_draw import bring, draw
from chips.rolls.layout import (
    BASE,
    COARSE,
    FINE,
    FINE_POINTS,
    LOW,
    ONE,
    SHIFT,
    SIGNS,
    SPLIT,
    STEEP,
    SURE,
    VALUE,
    ZERO,
    ChipTables,
    Membranes,
    Scratch,
    Z,
    step_compiled,
    step_inlined,
)
from chips.rolls.noise.layout import (
    BACK,
    DIRECT,
    DRAWN,
    INPUT,
    LEAK,
    LINE_DIRECT,
    LINE_EXC_GAIN,
    LINE_EXC_TAU,
    LINE_INH_GAIN,
    LINE_INH_TAU,
    LINE_LEAK,
    PAIR,
    REVERSED,
    RISE,
    SLOW_BACK,
    SLOW_DIRECT,
    SLOW_EXCITE,
    SLOW_INHIBIT,
    SLOW_LEAK,
    SLOW_PAIR,
    WHITE,
    NoiseTables,
)
from chips.rolls.plastic.layout import Plastic
from circuits.arrays import F32, F64, I64

MEMBRANES, FILTERS = 0, 1  # streams; a filter's sign is added, behind them the plastic array's filters


@step_compiled
def disturb_filters(t: NoiseTables, c: ChipTables, state: F64, number: int, s: Scratch) -> None:
    """Add the shot noise of step `number` to the filters before it, whose pulses are in s.charge.

    An electron onto v_syn moves z by (1 + v) grains, one of a pulse is split by the pair: `D = grain (1 + v)
    [(1 + v) dt / tau + q]`, and `grain q excess` of what makes the pulse.
    """
    for sign in range(SIGNS):
        if not c.live[sign]:
            continue
        draw(t.draws, number, FILTERS + sign)
        z, charge, bank = state[Z + sign], s.charge[sign], c.banks[sign]
        for k in range(z.size):
            y = max(z[k], LOW)
            place = (y - LOW) * FINE if y < SPLIT else (y - SPLIT) * (1.0 / COARSE) + FINE_POINTS
            more = ONE + c.omega[sign, int(place), VALUE]
            variance = more * (more * np.float32(bank.fall[k]) + charge[k]) + charge[k] * t.excess[sign, k]
            z[k] += math.sqrt(t.grain[sign, k] * variance) * t.draws.normal[k]


@step_compiled
def disturb_plastic(t: NoiseTables, p: Plastic, number: int) -> None:
    """Add the shot noise of step `number` to the slow filters and the calcium, as in `disturb_filters`."""
    for k in range(len(p.tables.banks)):
        draw(t.draws, number, FILTERS + SIGNS + k)
        z, charge, fall = p.arrays.filters[Z + k], p.scratch.filters.charge[k], p.tables.banks[k].fall
        grain, excess = t.plastic_grain[k], t.plastic_excess[k]
        for j in range(z.size):
            y = max(z[j], LOW)
            place = (y - LOW) * FINE if y < SPLIT else (y - SPLIT) * (1.0 / COARSE) + FINE_POINTS
            more = ONE + p.tables.omega[k, int(place), VALUE]
            variance = more * (more * np.float32(fall[j]) + charge[j]) + charge[j] * excess[j]
            z[j] += math.sqrt(grain[j] * variance) * t.draws.normal[j]


@step_inlined
def _white(t: NoiseTables, s: Scratch, k: int, row: F32, often: np.float32) -> np.float32:
    """Of dzeta/dt, 1/s; row: of the neuron's rows; often: over the time for which it stands still, 1/s."""
    density = row[WHITE] + row[INPUT] * s.excite[k] + row[DRAWN] * s.inhibit[k]
    return np.float32(math.sqrt(density * often) * t.draws.normal[k])


@step_inlined
def _slow(t: NoiseTables, m: Membranes, s: Scratch, k: int, row: F32) -> np.float32:
    """What flicker brings, 1/s."""
    slow = t.slow.value
    pair = row[PAIR] * slow[SLOW_PAIR, k]
    more = row[LEAK] * slow[SLOW_LEAK, k] + row[BACK] * slow[SLOW_BACK, k]
    more += row[DIRECT] * (slow[SLOW_DIRECT, k] + pair)
    more += m.inverse[k] * s.excite[k] * (slow[SLOW_EXCITE, k] + pair)
    return np.float32(more - row[REVERSED] * s.inhibit[k] * slow[SLOW_INHIBIT, k])


@step_inlined
def _by_lines(t: NoiseTables, m: Membranes, s: Scratch, k: int, row: F32) -> np.float32:
    """What lines that have moved make of the leak, the direct current and the filters, 1/s."""
    line = t.lines.shift
    leak, direct = np.float32(line[LINE_LEAK]), np.float32(line[LINE_DIRECT])
    excite = np.float32(line[LINE_EXC_GAIN] - line[LINE_EXC_TAU])
    inhibit = np.float32(line[LINE_INH_GAIN] - line[LINE_INH_TAU])
    more = row[LEAK] * leak + row[DIRECT] * direct + m.inverse[k] * s.excite[k] * excite
    return np.float32(more - row[REVERSED] * s.inhibit[k] * inhibit)


@step_compiled
def disturb_membranes(t: NoiseTables, m: Membranes, bits: I64, number: int, step: float, s: Scratch) -> None:
    """Add the noise of step `number` to dzeta/dt in `s.rate`; it alone is in `s.push` then."""
    bring(t.slow, t.draws, number)
    draw(t.draws, number, MEMBRANES)
    often, span, steep, sure = (
        np.float32(1.0 / step), np.float32(step), np.float32(STEEP), np.float32(SURE),
    )  # fmt: skip
    for k in range(bits.size):
        row = t.rows[k, np.uint64((bits[k] >> SHIFT) - BASE)]
        own = s.own[k] * m.inverse[k]
        rising = (s.slope[k] * span > steep) & (own > sure * abs(s.rate[k] - own))
        s.push[k] = _white(t, s, k, row, row[RISE] if rising else often)
    bring_lines(t.lines, number)
    for k in range(bits.size * (t.lines.shift.size > 0)):
        s.push[k] += _by_lines(t, m, s, k, t.rows[k, np.uint64((bits[k] >> SHIFT) - BASE)])
    for k in range(bits.size * (t.slow.deviation.size > 0)):
        s.push[k] += _slow(t, m, s, k, t.rows[k, np.uint64((bits[k] >> SHIFT) - BASE)])
    for k in range(bits.size):
        s.rate[k] += s.push[k]


@step_compiled
def disturb_released(t: NoiseTables, m: Membranes, step: float, s: Scratch) -> None:
    """Fill `s.calm` with the noise that `disturb_membranes` saw last, of marked membranes at 0 V, A."""
    often, slow, wander = np.float32(1.0 / step), t.slow.deviation.size > 0, t.lines.shift.size > 0
    for word in range(s.hard_words.size):
        if s.hard_words[word] == 0 and s.fast_words[word] == 0:
            continue
        for k in range(8 * word, 8 * word + 8):
            row = t.rows[k, 0]
            more = _white(t, s, k, row, often)
            more += _by_lines(t, m, s, k, row) if wander else ZERO
            more += _slow(t, m, s, k, row) if slow else ZERO
            s.calm[k] = more / m.inverse[k]
