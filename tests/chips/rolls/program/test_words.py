"""Words of programs: there and back, only what changed, time, events of inputs, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.rolls.program.address import (
    NONPLASTIC_LATCHES,
    PLASTIC_LATCHES,
    PLASTIC_WEIGHTS,
    in_region,
    latch_words,
    leak_words,
    read_latch_words,
    stimulate_words,
)
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.program.words import (
    input_words,
    program_of_words,
    program_words,
    programming_time,
    virtual_columns,
)
from circuits.blocks.rolls.dpi_synapse import latches
from circuits.errors import ParameterError

neurons = st.integers(0, 255)
EMPTY = Program(np.zeros((1, 1)))


def random_program(seed: int, tau1: tuple[int, ...] = ()) -> Program:
    return Program(np.random.default_rng(seed).integers(-4, 5, size=(256, 256)), tau1=tau1)


@settings(max_examples=5, deadline=None)  # 327,680 words each
@given(st.integers(0, 999), st.sets(neurons))
def test_a_program_survives_its_words(seed: int, slow: set[int]) -> None:
    program = random_program(seed, tuple(slow))
    found = program_of_words(program_words(program))
    assert (found.levels == program.levels).all()
    assert found.tau1 == program.tau1


@given(st.lists(st.tuples(neurons, neurons, st.integers(-4, 4)), max_size=8), st.sets(neurons, max_size=3))
@settings(max_examples=30, deadline=None)
def test_words_of_a_change_change_just_that(cells: list[tuple[int, int, int]], slow: set[int]) -> None:
    before = random_program(1)
    levels = before.levels.copy()
    for post, pre, level in cells:
        levels[post, pre] = level
    after = Program(levels, tau1=tuple(slow))
    words = program_words(after, before)
    differ = int((after.levels != before.levels).sum())
    assert int(in_region(NONPLASTIC_LATCHES, words).sum()) == 5 * differ
    assert program_words(after, after).size == 0
    found = program_of_words(np.concatenate((program_words(before), words)))
    assert (found.levels == after.levels).all()
    assert found.tau1 == after.tau1


def test_latches_of_each_level() -> None:
    levels = np.zeros((9, 9))
    levels[np.arange(9), 0] = np.arange(-4, 5)
    words = program_words(Program(levels), EMPTY)
    # recurrent, sign, w0, w1, broadcast of levels -4 to -1, 1 to 4: ROLLSDevice.h, weight_0 to weight_3
    bits = [
        (1, 0, 1, 1, 0), (1, 0, 0, 1, 0), (1, 0, 1, 0, 0), (1, 0, 0, 0, 0),
        (1, 1, 0, 0, 0), (1, 1, 1, 0, 0), (1, 1, 0, 1, 0), (1, 1, 1, 1, 0),
    ]  # fmt: skip
    posts = [0, 1, 2, 3, 5, 6, 7, 8]
    expected = [
        133632 + post + (bit << 16) + (latch << 17)
        for post, row in zip(posts, bits, strict=True)
        for latch, bit in enumerate(row)
    ]
    assert words.tolist() == expected


@pytest.mark.parametrize("level", [*range(-4, 0), *range(1, 5)])
def test_latches_are_those_that_the_circuit_is_given(level: int) -> None:
    program = Program(np.full((1, 1), level, dtype=np.int8))
    written = read_latch_words(NONPLASTIC_LATCHES, program_words(program, EMPTY))
    names = [NONPLASTIC_LATCHES.latches[k] for k in written.latch]
    bits = dict(zip(names, written.bit.tolist(), strict=True))
    assert bits == {**{name: volts / 1.8 for name, volts in latches(level, 1.8).items()}, "broadcast": 0}


def test_the_last_write_to_a_latch_holds() -> None:
    on = latch_words(NONPLASTIC_LATCHES, 2, 4, [0, 1, 2], 1)
    off = latch_words(NONPLASTIC_LATCHES, 2, 4, [2], 0)
    assert program_of_words(on).levels[2, 4] == 2
    assert program_of_words(np.concatenate((on, off))).levels[2, 4] == 1
    assert program_of_words(np.concatenate((off, on))).levels[2, 4] == 2
    assert program_of_words(on[1:]).levels[2, 4] == 0  # without the recurrent latch nothing is let in
    assert program_of_words(np.concatenate((leak_words([3, 5]), leak_words([9])))).tau1 == (9,)


def test_programming_takes_ten_microseconds_a_synapse() -> None:
    words = program_words(EMPTY)
    assert programming_time(words) == pytest.approx(65536 * 10e-6)
    grid = np.arange(256)
    plastic = latch_words(PLASTIC_LATCHES, grid[:, None, None], grid[:, None], [0, 1], 0).ravel()
    weights = latch_words(PLASTIC_WEIGHTS, grid[:, None], grid, 0, 0).ravel()
    # facts: three sleeps a pair of neurons, 2 s for both arrays
    assert programming_time(np.concatenate((words, plastic, weights))) == pytest.approx(3 * 65536 * 10e-6)
    assert programming_time([]) == 0.0
    # two leak words, then five words a synapse
    assert [programming_time(words[:n], pause=1.0) for n in (2, 7, 8)] == [0.0, 1.0, 2.0]


def test_events_reach_the_virtual_synapses_of_their_input() -> None:
    inputs = (
        VirtualInput("dvs", (7, 3), 2),
        VirtualInput("touch", (3, 9), 1),
        VirtualInput("stop", (3, 7), 1, inhibitory=True),
    )
    program = Program(np.zeros((1, 1)), inputs=inputs)
    columns = virtual_columns(program)
    assert columns["dvs"].tolist() == [[512, 513], [512, 513]]
    assert columns["touch"].tolist() == [[514], [512]]  # neuron 3 has given two to dvs
    assert columns["stop"].tolist() == [[516], [516]]
    words = input_words(program, "touch", [9, 3, 3])
    assert words.tolist() == stimulate_words([[9], [3], [3]], [[512], [514], [514]]).tolist()
    assert input_words(program, "dvs", 3).tolist() == [stimulate_words(3, [512, 513]).tolist()]
    with pytest.raises(
        ParameterError, match=r"program.input.touch\[1\]: neuron 4, must be one that it reaches"
    ):
        input_words(program, "touch", [3, 4])


def test_words_without_a_model_are_refused_by_position() -> None:
    cleared = latch_words(PLASTIC_LATCHES, 1, 2, [0, 1], 0)
    assert not program_of_words(cleared).levels.any()
    assert program_of_words(cleared).plastic is None
    with pytest.raises(ParameterError, match=r"program.words: plastic broadcast of 2 to 1 is set"):
        program_of_words([*cleared, int(latch_words(PLASTIC_LATCHES, 1, 2, 1, 1))])
    with pytest.raises(ParameterError, match=r"program.words: broadcast of 2 to 1 is set"):
        program_of_words([int(latch_words(NONPLASTIC_LATCHES, 1, 2, 4, 1))])
    with pytest.raises(ParameterError, match=r"program.words\[0\]: 131072 writes no latch"):
        program_of_words([int(stimulate_words(0, 512))])
