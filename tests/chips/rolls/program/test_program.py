"""Programs of ROLLS: levels from the shared currents, and what the chip cannot do, by position."""

import pickle

import numpy as np
import pytest

from chips.rolls.program.address import PAPER_VIRTUAL, VirtualSynapses
from chips.rolls.program.bias_file import default_biases, parse_biases, shipped_biases
from chips.rolls.program.program import Program, VirtualInput, level_current, missing_levels
from circuits.blocks.rolls.bias import default_current
from circuits.errors import ParameterError, UnknownNameError


def one(level: float, post: int = 3, pre: int = 7) -> np.ndarray:
    """A matrix with one synapse, as float64."""
    levels = np.zeros((10, 10))
    levels[post, pre] = level
    return levels


def test_levels_are_the_four_sums_of_the_shared_currents() -> None:
    biases = default_biases()
    const, w0, w1 = (default_current(f"NPA_WEIGHT_EXC{k}_P") for k in ("", "0", "1"))
    currents = [level_current(biases, level) for level in range(5)]
    assert currents == pytest.approx([0.0, const, const + w0, const + w1, const + w0 + w1])
    inhibition = [level_current(biases, -level) for level in range(1, 5)]
    assert inhibition == sorted(inhibition)  # with the default codes, not by design
    with pytest.raises(ParameterError, match="level: 5, must be -4 to 4"):
        level_current(biases, 5)


def test_a_program_is_padded_and_frozen() -> None:
    levels = one(-4)
    program = Program(levels, tau1=(9, 3, 3))
    levels[:] = 1
    assert program.levels.dtype == np.int8
    assert program.levels.shape == (256, 256)
    assert np.argwhere(program.levels).tolist() == [[3, 7]]
    assert program.tau1 == (3, 9)
    assert np.flatnonzero(program.slow_leak()).tolist() == [3, 9]
    with pytest.raises(ValueError, match="read-only"):
        program.levels[0, 0] = 1
    assert (pickle.loads(pickle.dumps(program)).levels == program.levels).all()


@pytest.mark.parametrize("level", [5, -5, 1.5, np.nan])
def test_a_ninth_weight_is_refused_by_position(level: float) -> None:
    with pytest.raises(ParameterError, match=r"program.levels\[3, 7\]: .* from -4 to 4; the chip has eight"):
        Program(one(level))


def test_integers_that_would_wrap_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"program.levels\[3, 7\]: 257,"):
        Program(one(257).astype(np.int64))


@pytest.mark.parametrize(
    ("name", "coarse", "missing"),
    [
        ("NPA_WEIGHT_EXC_P", 3, {1}),
        ("NPA_WEIGHT_EXC0_P", 2, {2, 4}),
        ("NPA_WEIGHT_EXC1_P", 2, {3, 4}),
        ("NPA_WEIGHT_INH_N", 1, {-1}),
        ("NPA_WEIGHT_INH0_N", 0, {-2, -4}),
        ("NPA_WEIGHT_INH1_N", 0, {-3, -4}),
    ],
)
def test_a_level_without_its_current_is_refused(name: str, coarse: int, missing: set[int]) -> None:
    biases = default_biases().with_code(name, coarse, 0)
    assert missing_levels(biases) == dict.fromkeys(missing, name)
    for level in set(range(-4, 5)) - {0}:
        if level in missing:
            with pytest.raises(ParameterError, match=rf"program.levels\[3, 7\]: {level}, .*{name} has fine"):
                Program(one(level), biases)
        else:
            assert Program(one(level), biases).levels[3, 7] == level


def test_shipped_tables_have_all_levels() -> None:
    assert missing_levels(default_biases()) == missing_levels(shipped_biases("rolls_parallella")) == {}


def test_biases_without_a_weight_are_told() -> None:
    with pytest.raises(UnknownNameError, match="NPA_WEIGHT_EXC_P"):
        Program(one(1), parse_biases("IF_TAU1_N,15p,40", "text"))


def test_neurons_and_shapes_that_the_chip_does_not_have_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"program.levels: neuron 256, must be 0 to 255; make"):
        Program(np.zeros((257, 257)))
    with pytest.raises(ParameterError, match=r"program.levels: 3 x 4, must be a square"):
        Program(np.zeros((3, 4)))
    with pytest.raises(ParameterError, match=r"program.tau1: neuron 256, must be 0 to 255"):
        Program(one(1), tau1=(0, 256))
    with pytest.raises(ParameterError, match=r"program.inputs.dvs: neuron -1, must be 0 to 255"):
        Program(one(1), inputs=(VirtualInput("dvs", (-1,)),))


def test_too_many_virtual_inputs_are_refused_with_the_limit() -> None:
    first, second = VirtualInput("dvs", (0, 5), 3), VirtualInput("touch", (5, 6), 2)
    with pytest.raises(
        ParameterError,
        match=r"program.inputs.touch: 5 excitatory virtual synapses of neuron 5, must be <= 4; send inputs",
    ):
        Program(one(1), inputs=(first, second))
    other = VirtualInput("touch", (5, 6), 2, inhibitory=True)
    assert Program(one(1), inputs=(first, other)).input("touch") is other
    with pytest.raises(ParameterError, match=r"2 inhibitory virtual synapses of neuron 5, must be <= 0"):
        Program(one(1), inputs=(first, other), virtual=PAPER_VIRTUAL)
    with pytest.raises(ParameterError, match=r"3 excitatory virtual synapses of neuron 0, must be <= 2"):
        Program(one(1), inputs=(first,), virtual=VirtualSynapses(2, 2))


def test_inputs_that_make_no_sense_are_refused() -> None:
    for each, says in (
        (VirtualInput("dvs", ()), "inputs.dvs.neurons: none or one twice"),
        (VirtualInput("dvs", (1, 1)), "inputs.dvs.neurons: none or one twice"),
        (VirtualInput("dvs", (1,), 0), "inputs.dvs.synapses: 0, must be >= 1"),
    ):
        with pytest.raises(ParameterError, match=says):
            Program(one(1), inputs=(each,))
    twice = (VirtualInput("dvs", (1,)), VirtualInput("dvs", (2,)))
    with pytest.raises(ParameterError, match=r"inputs.dvs: given twice"):
        Program(one(1), inputs=twice)
    silent = default_biases().with_code("VA_EXC_N", 0, 0)
    with pytest.raises(ParameterError, match=r"inputs.dvs: VA_EXC_N has fine code 0"):
        Program(one(1), silent, inputs=(VirtualInput("dvs", (1,)),))
    with pytest.raises(ParameterError, match=r"program.input: ear, must be one of the inputs; they are none"):
        Program(one(1)).input("ear")
