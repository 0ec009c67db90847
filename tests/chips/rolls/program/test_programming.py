"""A chip of ROLLS is the same however it is programmed, and speaks its documented addresses."""

import numpy as np
import pytest

from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.program.address import NEURONS, read_stimulate_words, stimulate_words
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.program.words import input_words, program_of_words, program_words
from chips.validity import outside_boxes
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

SILICON = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1004))
TABLE = default_biases().with_code("IF_DC_P", 7, 0)
DRIVE = VirtualInput("drive", tuple(range(NEURONS)))


@pytest.fixture(scope="module")
def chips() -> tuple[RollsChip, RollsChip]:
    levels = np.random.default_rng(3).integers(-4, 5, (NEURONS, NEURONS)).astype(np.int8)
    program = Program(levels, TABLE, (1, 200), (DRIVE,))
    read = program_of_words(program_words(program), TABLE, (DRIVE,))
    return RollsChip(program, SILICON), RollsChip(read, SILICON)


def test_latch_words_and_the_matrix_make_one_chip(chips: tuple[RollsChip, RollsChip]) -> None:
    ours, theirs = (chip.built().tables for chip in chips)
    assert np.array_equal(ours.charges, theirs.charges)
    assert np.array_equal(ours.membranes.lines, theirs.membranes.lines)
    assert ours.charges.any()


def test_words_in_and_addresses_out(chips: tuple[RollsChip, RollsChip]) -> None:
    program = chips[0].program
    neurons = np.arange(0, NEURONS, 5)
    words = input_words(program, "drive", neurons).ravel()
    assert (words < 1 << 22).all()
    to, columns = read_stimulate_words(words)
    assert np.array_equal(stimulate_words(to, columns), words)
    times = np.linspace(1e-4, 5e-3, words.size)
    with outside_boxes("warn"):  # of the control software's strongest inhibition
        sent = [chip.run(chip.at_rest(), 0.02, Inputs(times, to, columns))[0] for chip in chips]
    assert np.array_equal(sent[0].times, sent[1].times)
    assert np.array_equal(sent[0].neurons, sent[1].neurons)
    assert sent[0].neurons.size > 0
    assert set(sent[0].neurons.tolist()) <= set(range(NEURONS))
