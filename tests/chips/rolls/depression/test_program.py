"""Depression is asked for with its bias on and something to depress, or refused by name."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.program.bias_file import default_biases, parse_biases
from chips.rolls.program.nir import nir_graph
from chips.rolls.program.program import Program
from chips.rolls.program.words import program_of_words, program_words
from circuits.blocks.rolls.depressing_synapse import RECOVERY
from circuits.errors import ParameterError, UnknownNameError
from tests.refusals import refusals

ON = default_biases().with_code(STEP_BIAS, 5, 36)
LEVELS = np.zeros((8, 8), np.int8)
LEVELS[3, 5] = 2


def test_a_program_carries_depression_through_pickle_and_words() -> None:
    program = Program(LEVELS, ON, depression=ShortTermDepression())
    assert program.depression is not None
    assert program.depression.recovery == RECOVERY
    assert pickle.loads(pickle.dumps(program)).depression == program.depression
    again = program_of_words(program_words(program), ON, depression=program.depression)
    assert again.depression == program.depression
    assert Program(LEVELS, ON).depression is None


def test_a_nir_graph_of_depressed_synapses_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match=r"program.depression: given, must be None for a NIR graph"):
        nir_graph(Program(LEVELS, ON, depression=ShortTermDepression()))


def test_what_cannot_depress_is_refused() -> None:
    depression = ShortTermDepression()
    with pytest.raises(
        ParameterError, match=rf"program.depression: {STEP_BIAS} has fine code 0, must be > 0"
    ):
        Program(LEVELS, default_biases(), depression=depression)
    with pytest.raises(ParameterError, match=r"program.depression: no excitatory synapse.*inhibitory"):
        Program(-LEVELS, ON, depression=depression)
    with pytest.raises(ParameterError, match=r"program.depression: bool, must be a ShortTermDepression"):
        Program(LEVELS, ON, depression=True)  # type: ignore[arg-type]
    unnamed = parse_biases(
        "NPA_WEIGHT_EXC_P,50n,98\nNPA_WEIGHT_EXC0_P,.4u,127".replace(".4u", "0.4u"), "text"
    )
    with pytest.raises(UnknownNameError):
        Program(LEVELS, unnamed, depression=depression)


test_a_recovery_is_a_code_that_is_on = refusals(
    ParameterError,
    lambda code: ShortTermDepression(recovery=code),
    [((7, 0), "recovery: fine code 0"), ((8, 3), "bias code: 8, 3")],
)
