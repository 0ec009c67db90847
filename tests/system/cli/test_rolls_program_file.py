"""Programs of ROLLS from a file."""

from pathlib import Path

import numpy as np
import pytest

from chips.rolls.cut import cut_row
from chips.rolls.program.bias_file import default_biases
from circuits.errors import DataError, ParameterError
from system.cli.rolls_program_file import read_program
from system.pushbot.network.plain import pushbot_network
from tests.refusals import file_refusals


@pytest.mark.parametrize("header", ["", "post,pre,level\n"])
def test_rows_are_synapses(tmp_path: Path, header: str) -> None:
    path = tmp_path / "program.csv"
    path.write_text(f"{header}5,17,4\n\n 5, 40, -2\n255,0,0\n")
    levels = read_program(str(path), default_biases()).levels
    assert (levels[5, 17], levels[5, 40], levels[255, 0], np.count_nonzero(levels)) == (4, -2, 0, 2)


def test_the_pushbot_s_network_has_a_name() -> None:
    found = read_program("pushbot", default_biases())
    assert np.array_equal(found.levels, pushbot_network().levels())
    assert found.inputs


def test_a_row_turns_depression_on_and_the_row_as_a_circuit_has_it(tmp_path: Path) -> None:
    path = tmp_path / "program.csv"
    path.write_text("post,pre,level\ndepression,7,20\n5,17,4\n")
    program = read_program(str(path), default_biases().with_code("NPA_WEIGHT_STD_N", 5, 36))
    assert program.depression is not None
    assert program.depression.recovery == (7, 20)
    assert any(i.name == "depression_exc" for i in cut_row(program, 5).circuit.instances[0].circuit.instances)
    with pytest.raises(ParameterError, match="NPA_WEIGHT_STD_N has fine code 0"):
        read_program(str(path), default_biases())


test_a_bad_row_is_refused_with_its_line = file_refusals(
    DataError,
    "program.csv",
    lambda path: read_program(path, default_biases()),
    [
        ("5,17\n", 'line 1: "5,17", must be post,pre,level'),
        ("5,17,x\n", "must be post,pre,level"),
        ("5,17,5\n", "line 1: level 5, must be -4 to 4"),
        ("256,17,1\n", "line 1: post 256, must be 0 to 255"),
        ("5,-1,1\n", "line 1: pre -1, must be 0 to 255"),
        ("5,17,1\n5,17,2\n", "line 2: 17 to 5 stands twice"),
        ("post,pre,level\n", "no synapse"),
        ("depression,7\n", 'line 1: "depression,7", must be depression,coarse,fine as in 7,27'),
        ("depression,7,0\n", "line 1.*recovery: fine code 0"),
        ("depression,7,27\ndepression,7,27\n", "line 2: depression stands twice"),
    ],
)


def test_a_missing_file_and_a_missing_level_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="No such file"):
        read_program(str(tmp_path / "none.csv"), default_biases())
    path = tmp_path / "program.csv"
    path.write_text("5,17,2\n")
    with pytest.raises(ParameterError, match="NPA_WEIGHT_EXC0_P has fine code 0"):
        read_program(str(path), default_biases().with_code("NPA_WEIGHT_EXC0_P", 2, 0))
