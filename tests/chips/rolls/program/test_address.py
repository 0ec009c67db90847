"""Addresses of ROLLS: documented words, round trips, regions that touch, and what is refused.

Reference words: mn256r1_ncs, `AERmn256r1.py` (set_recurrent_bit, set_weight_programmable, set_neuron_tau_1).
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.rolls.program.address import (
    LAB_VIRTUAL,
    LEAK_RELEASE,
    LEAK_RESET,
    LEAK_TAU1,
    NONPLASTIC_LATCHES,
    PAPER_VIRTUAL,
    PLASTIC_LATCHES,
    PLASTIC_WEIGHTS,
    REGIONS,
    WORD_BITS,
    Region,
    VirtualSynapses,
    in_region,
    latch_words,
    leak_words,
    read_latch_words,
    read_stimulate_words,
    stimulate_words,
)
from circuits.errors import ParameterError

neurons = st.integers(0, 255)


def test_words_are_those_of_the_control_software() -> None:
    # 1 * 256 * 256 + syn * 256 + neu + 133632, with syn 7 and neu 3: the recurrent bit on
    assert latch_words(NONPLASTIC_LATCHES, 3, 7, 0, 1) == 65536 + 7 * 256 + 3 + 133632
    # 3 * 2 * 256 * 256 + bit1 * 256 * 256 + syn * 256 + neu + 133632: the second weight bit
    assert latch_words(NONPLASTIC_LATCHES, 3, 7, 3, 1) == 6 * 65536 + 65536 + 7 * 256 + 3 + 133632
    assert latch_words(PLASTIC_WEIGHTS, 3, 7, 0, 0) == 7 * 256 + 3 + 1051136
    assert stimulate_words(88, 512) == 88 + 512 * 256
    assert leak_words([5]).tolist() == [1249282, 1249283, 1249031, 1249283, 1249031]


@given(st.lists(st.tuples(neurons, st.integers(0, 519)), max_size=20))
def test_stimulate_words_and_back(listed: list[tuple[int, int]]) -> None:
    given_neurons, columns = (np.array([t[k] for t in listed], dtype=np.int64) for k in range(2))
    words = stimulate_words(given_neurons, columns)
    assert (words < NONPLASTIC_LATCHES.offset).all()
    found = read_stimulate_words(words)
    assert [a.tolist() for a in found] == [given_neurons.tolist(), columns.tolist()]


@given(st.sampled_from(REGIONS), st.lists(st.tuples(neurons, neurons, st.integers(0, 4), st.integers(0, 1))))
def test_latch_words_and_back(region: Region, listed: list[tuple[int, int, int, int]]) -> None:
    cells = np.array(listed, dtype=np.int64).reshape(-1, 4)
    cells[:, 2] %= len(region.latches)
    words = latch_words(region, *cells.T)
    assert [int(in_region(each, words).sum()) for each in REGIONS] == [
        len(words) if each is region else 0 for each in REGIONS
    ]
    assert np.stack(read_latch_words(region, words), axis=1).tolist() == cells.tolist()


def test_regions_touch_and_fit_the_word() -> None:
    assert NONPLASTIC_LATCHES.end == PLASTIC_LATCHES.offset
    assert PLASTIC_LATCHES.end == PLASTIC_WEIGHTS.offset
    assert LEAK_TAU1 + 256 == LEAK_RESET == LEAK_RELEASE - 1
    assert PLASTIC_WEIGHTS.end < LEAK_TAU1
    assert LEAK_RELEASE < 1 << WORD_BITS


def test_virtual_synapses_of_the_lab_and_of_the_paper() -> None:
    assert list(LAB_VIRTUAL.columns(inhibitory=False)) == [512, 513, 514, 515]
    assert list(LAB_VIRTUAL.columns(inhibitory=True)) == [516, 517, 518, 519]
    assert PAPER_VIRTUAL.excitatory + PAPER_VIRTUAL.inhibitory == 4
    assert list(VirtualSynapses(2, 1).columns(inhibitory=True)) == [516]
    with pytest.raises(ParameterError, match=r"virtual_synapses.inhibitory: 5, must be 0 to 4"):
        VirtualSynapses(4, 5)


def test_what_the_chip_does_not_have_is_refused_by_position() -> None:
    with pytest.raises(ParameterError, match=r"address.neuron\[1\]: 256, must be 0 to 255; the chip has 256"):
        stimulate_words([0, 256], 512)
    with pytest.raises(ParameterError, match=r"address.column: 520, must be 0 to 519"):
        stimulate_words(0, 520)
    with pytest.raises(ParameterError, match=r"address.latch: 2, must be 0 to 1; they are recurrent"):
        latch_words(PLASTIC_LATCHES, 0, 0, 2, 0)
    with pytest.raises(ParameterError, match=r"address.bit: 2, must be 0 to 1"):
        latch_words(PLASTIC_LATCHES, 0, 0, 1, 2)
    with pytest.raises(ParameterError, match=r"address.neuron: float64 values, must be whole numbers"):
        stimulate_words(1.5, 512)
    with pytest.raises(ParameterError, match=r"address.word\[1\]: 788992, must be 133632 to 788991"):
        read_latch_words(NONPLASTIC_LATCHES, [133632, 788992])
    with pytest.raises(ParameterError, match=r"address.word: 133632, must be 0 to 133119"):
        read_stimulate_words(133632)
