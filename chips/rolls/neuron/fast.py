"""Compiled steps of a ROLLS chip's fast neurons, each in equal parts.

Where a neuron could spike again within `FEWEST` steps, and its filters fall fast enough for that to count,
the mean of its currents over a step is not enough. It takes the step in parts: in each its own filters are
stepped, with events in the part that begins nearest to them, and its membrane goes on with their currents.
Spikes of the last step, what depressed synapses bring, noise, adaptation and the plastic array are those of
the whole step.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.layout import (
    INVERSE,
    READ,
    SIGNS,
    SINCE,
    VIRTUAL,
    ZERO,
    ChipRun,
    ChipTables,
    Scratch,
    Traffic,
    Z,
    step_compiled,
    step_inlined,
)
from chips.rolls.neuron.step import live, sorted_out
from chips.rolls.synapse.step import step_all_filters

WORD = 8  # neurons that are stepped side by side


@step_inlined
def bring(c: ChipTables, t: Traffic, j: int, s: Scratch) -> None:
    """Add the charge of event j."""
    column, k = t.columns[j], t.neurons[j]
    if column < VIRTUAL:
        s.charge[2 + (column >> 2), k] += c.virtual[column, k]
    else:
        charge = c.charges[column - VIRTUAL, k]
        s.charge[0, k] += max(charge, ZERO)
        s.charge[1, k] -= min(charge, ZERO)


@step_inlined
def find_fast(chip: ChipRun) -> tuple[int, int]:
    """Mark fast neurons, and keep the filters with which they begin; their number, and their words'."""
    c, s, state, kept = chip.tables, chip.scratch, chip.state, chip.part_state
    some = False
    for k in range(s.fast.size):
        fast = (state[Z, k] + s.charge[0, k] > c.fast[0, k]) | (
            state[Z + 2, k] + s.charge[2, k] > c.fast[2, k]
        )
        s.fast[k] = 1 if fast else 0
        some |= fast
    if not some:
        return 0, 0
    count, words = sorted_out(s.fast_words, s.fast, s.found[2], s.found[3])
    for j in range(words):
        first = WORD * s.found[3, j]
        for row in range(SINCE + SIGNS):
            for k in range(first, first + WORD):
                kept[row, k] = state[row, k]
    return count, words


@step_inlined
def _filtered(chip: ChipRun, step: float, words: int) -> None:
    """Currents of the words with fast neurons in a part of `step` s, A."""
    c, p, rows = chip.tables, chip.part_scratch, chip.part_state
    for j in range(words):
        first = WORD * chip.scratch.found[3, j]
        end = first + WORD
        for k in range(first, end):
            p.excite[k] = chip.scratch.beside[0, k]
            p.inhibit[k] = chip.scratch.beside[1, k]
        step_all_filters(c, c.part_banks, step, rows, p, (first, end))


@step_compiled
def live_fast(chip: ChipRun, now: float, event: int, count: int, words: int) -> None:
    """All that fast neurons do in the step from `now` s; event: the first one of those that come in it."""
    c, t, s, p = chip.tables, chip.traffic, chip.scratch, chip.part_scratch
    part = c.step / c.parts
    for i in range(c.parts):
        until = now + (i + 0.5) * part if i + 1 < c.parts else np.inf
        while event < t.counts[READ] and t.times[event] < until:
            if s.fast[t.neurons[event]] != 0:
                bring(c, t, event, p)
            event += 1
        _filtered(chip, part, words)
        for j in range(count):
            k = s.found[2, j]
            noise = s.push[k] / c.membranes.spiking[k, INVERSE]
            given = float(p.excite[k]), float(p.inhibit[k]), noise, float(s.calm[k])
            span = i * part, (i + 1) * part, c.step
            if live(c.membranes, chip.state, chip.bits, k, given, span, now, t):
                s.push[k] = s.calm[k] * c.membranes.inverse[k]
    for j in range(count):
        k = s.found[2, j]
        for row in range(SINCE + SIGNS):
            chip.state[row, k] = chip.part_state[row, k]
