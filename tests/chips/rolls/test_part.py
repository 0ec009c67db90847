"""A ROLLS chip in the event loop is its run, to the bit."""

from __future__ import annotations

import numpy as np

from chips.aer import Bus
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.part import RollsPart
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from tests.chips.looped import looped


def test_a_rolls_chip_in_the_loop_is_its_run() -> None:
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    levels[:40, 7], levels[40:50, :30] = 2, 1
    biases = default_biases().with_code("IF_DC_P", 5, 150)
    # a bus on which events wait for each other across steps
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003))
    chip = RollsChip(Program(levels, biases), silicon, bus=Bus(service=20e-6, depth=40))
    times = np.sort(np.random.default_rng(3).uniform(1e-3, 20e-3, 400))
    neurons = np.arange(400) % 40
    columns = np.full(400, 256 + 7)
    whole, after = chip.run(chip.at_rest(), 24e-3, Inputs(times, neurons, columns))
    words = neurons + (columns << 8)
    events = [(f"in[{w}]", t) for w, t in zip(words.tolist(), times.tolist(), strict=True)]
    said, state = looped(RollsPart(chip), events, 24.001e-3, horizon=0.7e-3)
    each = zip(whole.times.tolist(), whole.neurons.tolist(), strict=True)
    # on their way out when the run ends are the last ones
    assert [*said, *state.due] == [(f"out[{k}]", t) for t, k in each]
    assert len(said) > 100
    assert whole.lost_out > 0
    assert (state.lost_in, state.lost_out) == (whole.lost_in, whole.lost_out)
    np.testing.assert_array_equal(state.chip.values[:, :5], after.values[:, :5])
