"""A ROLLS chip learns on its plastic array to tell a 0 from a 1, taught by examples, on two dies.

Digits as alike as 3 and 8 differ in 6 of the 64 columns, and are not learned on most dies.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.api.rolls import RollsChip
from chips.rolls.setups.learning import (
    SETTLING,
    Task,
    held,
    learning_biases,
    learning_program,
    presentation,
)
from circuits.api import ROLLS_180, Die, Silicon

ZERO = "01110 10001 10011 10101 11001 10001 01110"
ONE = "00100 01100 00100 00100 00100 00100 01110"
TASK = Task(training=40, tests=20)  # 64 plastic columns reach 16 neurons a digit


def columns(glyph):
    """Plastic columns that are active for a digit: one of two a point, of the first 32 of its 35 points."""
    points = np.array([point == "1" for point in glyph.replace(" ", "")])[: TASK.columns // 2]
    return np.concatenate([points, ~points])


def shown(chip, state, count, draw, *, teaching):
    """Show both digits in turn, jittered; the state after it, and the share that is told right."""
    right = 0
    for k in range(count):
        digit = k % 2
        taught = digit if teaching else None
        events = presentation(TASK, columns((ZERO, ONE)[digit]), taught, state.time, draw)
        spikes, state = chip.run(state, TASK.presentation, events)
        each = np.bincount(spikes.neurons, minlength=256)
        sums = [each[list(TASK.neurons(which))].sum() for which in (0, 1)]
        right += sums[digit] > sums[1 - digit]
        _, state = chip.run(state, TASK.pause)
    return state, right / count


def main():
    """Test, teach and test again; the weights stay while it is tested."""
    program = learning_program(TASK, 0, learning_biases())
    for number in (1000, 1001):
        silicon, draw = Silicon(ROLLS_180, die=Die("A", number)), np.random.default_rng(0)
        chip = RollsChip(program, silicon)
        still = RollsChip(replace(program, biases=held(program.biases)), silicon)
        state, before = shown(still, chip.at_rest(), TASK.tests, draw, teaching=False)
        state, _ = shown(chip, state, TASK.training, draw, teaching=True)
        _, state = chip.run(state, SETTLING)
        _, after = shown(still, state, TASK.tests, draw, teaching=False)
        print(f"die A/{number}: {before:.0%} right before, {after:.0%} after {TASK.training} examples")


if __name__ == "__main__":
    main()
