"""Words of the plastic array: a round trip, what changed, and what is not modelled."""

import numpy as np
import pytest

from chips.rolls.cut import cut_row
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.plastic.words import plastic_of_words, plastic_words
from chips.rolls.program.address import PLASTIC_LATCHES, PLASTIC_WEIGHTS, latch_words
from chips.rolls.program.nir import nir_graph
from chips.rolls.program.program import Program
from chips.rolls.program.words import program_of_words, program_words
from circuits.errors import ParameterError

LATCHES = np.zeros((4, 4), np.bool_)
LATCHES[1, 2] = LATCHES[3, 0] = True
ARRAY = PlasticArray(LATCHES, np.array([[0, 0], [1, 0]]))


def test_a_program_with_a_plastic_array_is_written_and_read() -> None:
    words = program_words(Program(np.zeros((1, 1)), plastic=ARRAY))
    # five words a non-plastic synapse, two a plastic one and one a weight; two of the leak
    assert words.size == 2 + 8 * 65536
    found = program_of_words(words).plastic
    assert found is not None
    assert np.array_equal(found.latches, ARRAY.latches)
    assert np.array_equal(found.start(), ARRAY.start())


def test_only_what_differs_is_written() -> None:
    assert plastic_words(None).size == 0
    assert plastic_words(ARRAY, ARRAY).size == 0
    more = PlasticArray(LATCHES, np.array([[0, 1], [1, 0]]))
    assert plastic_words(more, ARRAY).tolist() == latch_words(PLASTIC_WEIGHTS, [0], [1], 0, 1).tolist()
    # an array that is left out is cleared
    cleared = plastic_of_words(np.concatenate((plastic_words(ARRAY), plastic_words(None, ARRAY))))
    assert cleared is None


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"plastic.weights\[0, 1\]: 2, must be 0 or 1"):
        PlasticArray(LATCHES, np.array([[0, 2], [0, 0]]))
    with pytest.raises(ParameterError, match=r"plastic.latches: 2 x 3, must be a square"):
        PlasticArray(np.zeros((2, 3)))
    with pytest.raises(ParameterError, match=r"plastic.latches: 257 x 257"):
        PlasticArray(np.zeros((257, 257)))
    with pytest.raises(ParameterError, match=r"plastic broadcast of 2 to 1 is set"):
        plastic_of_words(np.atleast_1d(latch_words(PLASTIC_LATCHES, 1, 2, 1, 1)))


def test_an_array_is_refused_where_it_would_be_lost() -> None:
    program = Program(np.zeros((1, 1)), plastic=ARRAY)
    for lowering in (nir_graph, lambda p: cut_row(p, 0)):
        with pytest.raises(ParameterError, match=r"program.plastic: given, must be None for a"):
            lowering(program)
