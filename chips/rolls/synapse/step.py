"""Compiled step of a ROLLS chip's filters, one kind at a time (`chips.rolls.kernel`)."""

from __future__ import annotations

import math

import numpy as np

from chips.rolls.layout import (
    C11,
    C20,
    C32,
    C35,
    COARSE,
    FINE,
    FINE_POINTS,
    HALF,
    HIGH,
    LOW,
    ONE,
    POWER,
    POWER_SLOPE,
    SINCE,
    SLOPE,
    SPLIT,
    TAKEN,
    VALUE,
    ZERO,
    Banks,
    ChipTables,
    FilterBank,
    Scratch,
    Z,
    step_inlined,
)  # fmt: skip
from circuits.arrays import F32, F64


@step_inlined
def _some(bank: FilterBank, first: int, end: int) -> FilterBank:
    """Filters of the neurons from `first` to `end`."""
    return FilterBank(
        bank.lost[first:end], bank.fall[first:end], bank.rest[first:end], bank.empty[first:end],
        bank.idle[first:end], bank.line[first:end], bank.first[first:end], bank.lag[first:end],
        bank.scale[first:end], bank.fallen[first:end], bank.specific[first:end],
    )  # fmt: skip


@step_inlined
def step_filters(
    state: F64, sign: np.int64, omega: F32, bank: FilterBank, step: float, out: F32, s: Scratch
) -> int:
    """Step the filters of one kind: add their currents to `out` (A), and empty their charges.

    Returns how many were beyond the table's end, and were held there. sign: an `int64`; of each literal numba
    would compile it anew.
    """
    return step_some_filters(state, sign, omega, bank, step, out, s, (0, out.size))


@step_inlined
def step_some_filters(
    state: F64, sign: np.int64, omega: F32, whole: FilterBank, step: float, out: F32, s: Scratch,
    some: tuple[int, int],
) -> int:  # fmt: skip
    """Step those of the neurons from one number up to another, as `step_filters` says."""
    first, end = some
    bank = _some(whole, first, end)
    place, value, power, lag = s.place[first:end], s.value[first:end], s.power[first:end], s.lag[first:end]
    z, taken = state[Z + sign, first:end], state[TAKEN + sign, first:end]
    since, q = state[SINCE + sign, first:end], s.charge[sign, first:end]
    half, out = 0.5 * step, out[first:end]
    # short loops over few arrays, or the compiler does not pack them
    for k in range(z.size):
        value[k] = max(bank.line[k] / np.float32(since[k] + half) - bank.idle[k], ZERO)
    for k in range(z.size):
        quiet = ZERO if q[k] > ZERO else ONE
        lag[k] = quiet * HALF * value[k] + (ONE - quiet) * bank.lag[k]
        value[k] = quiet * value[k] + (ONE - quiet) * bank.first[k]
        power[k] = quiet
    for k in range(z.size):
        since[k] = power[k] * since[k] + step
    for k in range(z.size):
        before, quiet = np.float32(taken[k]), power[k]
        power[k] = value[k] + (ONE - quiet) * (q[k] - before)
        taken[k] = value[k] + quiet * before
    held = 0
    for k in range(z.size):
        q[k] = ZERO
        x = min(z[k] + power[k], HIGH)
        held += 1 if z[k] + power[k] > HIGH else 0
        z[k] = x
        y = max(x - lag[k], LOW)
        place[k] = (y - LOW) * FINE if y < SPLIT else (y - SPLIT) * (1.0 / COARSE) + FINE_POINTS
    for k in range(z.size):
        i = np.uint32(place[k])
        t = np.float32(place[k] - i)
        row = omega[i]
        value[k] = row[VALUE] + t * row[SLOPE]
        power[k] = row[POWER] + t * row[POWER_SLOPE]
    for k in range(z.size):
        ratio = min(bank.empty[k] / power[k], ONE)
        lag[k] = ONE - ratio * math.sqrt(ratio)
    for k in range(z.size):
        e = math.sqrt(power[k] * bank.scale[k] * (ONE - bank.fallen[k] * lag[k]))
        # ln(1 + e) by a fraction of fourth order, 1e-3 off at e = 3
        log = e * (ONE + e * (ONE + C11 * e)) / (ONE + e * (C32 + e * (C35 + C20 * e)))
        out[k] += bank.specific[k] * log * log
    for k in range(z.size):
        leaked = (bank.fall[k] + value[k] * bank.lost[k]) * lag[k]
        z[k] = max(z[k] - leaked + bank.idle[k], bank.rest[k])
    return held


@step_inlined
def step_all_filters(
    c: ChipTables, banks: Banks, step: float, state: F64, s: Scratch, some: tuple[int, int]
) -> int:
    """Add what the filters of some neurons put out to `s.excite` and `s.inhibit`, as `step_filters` says."""
    held = 0
    if c.live[0]:
        held += step_some_filters(state, np.int64(0), c.omega[0], banks[0], step, s.excite, s, some)
    if c.live[1]:
        held += step_some_filters(state, np.int64(1), c.omega[1], banks[1], step, s.inhibit, s, some)
    if c.live[2]:
        held += step_some_filters(state, np.int64(2), c.omega[2], banks[2], step, s.excite, s, some)
    if c.live[3]:
        held += step_some_filters(state, np.int64(3), c.omega[3], banks[3], step, s.inhibit, s, some)
    return held
