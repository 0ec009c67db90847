"""What the command line asks for on ROLLS."""

from pathlib import Path

import pytest

from chips.rolls.program.bias_file import shipped_biases, write_biases
from circuits.errors import DataError, ParameterError
from system.options.block import refuse_bias_file
from system.options.silicon import SiliconChoice
from system.rolls.options import bias_table, refuse_block_options, silicon_of


def test_a_table_comes_by_name_or_from_a_file(tmp_path: Path) -> None:
    assert bias_table(None) == shipped_biases("rolls_default")
    assert bias_table("rolls_parallella") == shipped_biases("rolls_parallella")
    own = shipped_biases("rolls_default").with_code("IF_TAU2_N", 5, 21)
    write_biases(tmp_path / "own.csv", own)
    assert bias_table(str(tmp_path / "own.csv")).code("IF_TAU2_N") == (5, 21)
    with pytest.raises(DataError, match="must be a bias file"):
        bias_table(str(tmp_path / "none.csv"))


def test_silicon_is_the_whole_chip_s() -> None:
    found = silicon_of(SiliconChoice("40", "B", 3))
    assert (found.temperature_c, found.die.lot, found.die.number, found.place) == (40.0, "B", 3, None)
    assert found.process.name == "rolls-180"
    assert silicon_of(SiliconChoice(process="coach-180")).process.pair_a_vt > found.process.pair_a_vt
    with pytest.raises(ParameterError, match="at: x, the chip stands by itself"):
        silicon_of(SiliconChoice(at="x"))
    with pytest.raises(ParameterError, match=r"rolls_chip.supply: 5 V, must be 1.8 V"):
        silicon_of(SiliconChoice(process="ami-1500"))


def test_options_of_blocks_and_of_the_chip_keep_apart() -> None:
    refuse_block_options((), (), None)
    for given in ((("a=1",), (), None), ((), ("a=1",), None), ((), (), "robust")):
        with pytest.raises(ParameterError, match="rolls has its biases by code"):
            refuse_block_options(*given)
    refuse_bias_file("dpi-synapse", None)
    with pytest.raises(ParameterError, match="of rolls only"):
        refuse_bias_file("dpi-synapse", "x.csv")
