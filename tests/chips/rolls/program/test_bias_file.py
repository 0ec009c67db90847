"""Bias files: the shipped tables, both layouts there and back, unknown names kept, errors by line."""

from importlib.resources import files
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.rolls.program.bias_file import (
    COARSE_NAMES,
    SHIPPED,
    BiasEntry,
    BiasTable,
    default_biases,
    format_biases,
    parse_biases,
    read_biases,
    shipped_biases,
    write_biases,
)
from circuits.blocks.rolls.bias import DEFAULT_CODES, OFF_CURRENT
from circuits.errors import DataError, ParameterError, UnknownNameError
from circuits.generator.code import COARSE
from circuits.units import parse_quantity

names = st.text("ABCXYZ_019", min_size=1, max_size=12)


def test_coarse_names_are_the_generators_currents() -> None:
    assert [parse_quantity(name, "A", "coarse") for name in COARSE_NAMES] == pytest.approx(COARSE, rel=1e-12)


def test_default_table_agrees_with_the_circuits() -> None:
    codes = default_biases().codes()
    assert {name: codes[name] for name in DEFAULT_CODES} == dict(DEFAULT_CODES)
    assert len(codes) == 65  # 58 used biases, 6 spare ones, the buffer's
    assert default_biases().current("IF_TAU1_N") == pytest.approx(15e-12 * 40 / 256)
    assert default_biases().current("IF_AHW_P") == OFF_CURRENT


def test_shipped_tables_have_the_same_names() -> None:
    assert {frozenset(shipped_biases(name).names) for name in SHIPPED} == {frozenset(default_biases().names)}
    parallella = shipped_biases("rolls_parallella")
    # the facts: IF_DC 820p/108 = 346 pA, both EXC bits 0.4u/255, IF_THR 820p/11
    assert parallella.current("IF_DC_P") == pytest.approx(346e-12, rel=1e-3)  # printed with three digits
    assert parallella.code("NPA_WEIGHT_EXC0_P") == parallella.code("NPA_WEIGHT_EXC1_P") == (2, 255)
    assert parallella.code("IF_THR_N") == (5, 11)
    with pytest.raises(UnknownNameError, match=r"rolls_lab: unknown; .*known are rolls_default"):
        shipped_biases("rolls_lab")


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_files_are_as_they_are_written(name: str) -> None:
    text = files("chips").joinpath("biases", f"{name}.csv").read_text(encoding="utf-8")
    assert format_biases(shipped_biases(name)) == text


@given(
    st.lists(
        st.builds(BiasEntry, names, st.none() | st.integers(0, 7), st.integers(0, 255)),
        min_size=1,
        unique_by=lambda e: e.name,
    )
)
def test_files_there_and_back(entries: list[BiasEntry]) -> None:
    table = BiasTable(tuple(entries))
    assert parse_biases(format_biases(table), "text") == table


def test_files_of_the_control_software_keep_their_flags(tmp_path: Path) -> None:
    path = tmp_path / "set.biases"
    path.write_text(
        "IF_TAU1_N,15p,10,LowBias,Normal,NBias,BiasEnable,\nSSP,SPECIAL,7,NONE,\n", encoding="utf-8"
    )
    table = read_biases(path)
    assert table.entries[0] == BiasEntry("IF_TAU1_N", 7, 10, ("LowBias", "Normal", "NBias", "BiasEnable"))
    assert table.entries[1].coarse is None
    write_biases(path, table)
    assert read_biases(path) == table


def test_unknown_names_are_kept_and_told() -> None:
    table = parse_biases("name,coarse_A,fine_0_255\nIF_TAU1_N,15p,40\nMY_BIAS,50n,3\n", "text")
    assert table.unknown == ("MY_BIAS",)
    assert "MY_BIAS,50n,3" in format_biases(table)
    assert default_biases().unknown == ()


def test_a_code_is_changed_and_checked() -> None:
    table = default_biases().with_code("IF_DC_P", 5, 108)
    assert table.code("IF_DC_P") == (5, 108)
    assert table.names == default_biases().names
    with pytest.raises(ParameterError, match=r"bias.IF_DC_P.fine: 256, must be 0 to 255"):
        table.with_code("IF_DC_P", 5, 256)
    with pytest.raises(ParameterError, match=r"bias.IF_DC_P.coarse: 8, must be 0 to 7"):
        table.with_code("IF_DC_P", 8, 1)
    with pytest.raises(UnknownNameError, match="ROLLS bias IF_D: unknown"):
        table.with_code("IF_D", 0, 1)
    with pytest.raises(ParameterError, match=r"bias.SSP: a shifted source"):
        table.current("SSP")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("IF_TAU1_N,15p", r'f, line 1: "IF_TAU1_N,15p", must be name,coarse,fine'),
        ("\nIF_TAU1_N,16p,40", r"f, line 2: coarse current 16p of IF_TAU1_N, must be one of 24u, 3.2u"),
        ("IF_TAU1_N,15p,256", r"f, line 1: fine code 256 of IF_TAU1_N, must be 0 to 255"),
        ("IF_TAU1_N,15p,-1", r"f, line 1: fine code -1"),
        ("IF_TAU1_N,15p,4.5", r"f, line 1: fine code 4.5"),
        ("A,15p,1\nA,15p,2", r"f, line 2: A stands twice"),
        ("name,coarse_A,fine_0_255\n", r"f: no bias"),
    ],
)
def test_wrong_files_are_refused_with_their_line(text: str, says: str) -> None:
    with pytest.raises(DataError, match=says) as caught:
        parse_biases(text, "f")
    assert "\n" not in str(caught.value)


def test_missing_file_and_folder_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="No such file"):
        read_biases(tmp_path / "none.csv")
    with pytest.raises(DataError, match="must be a file to write"):
        write_biases(tmp_path, default_biases())
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe")
    with pytest.raises(DataError, match="no UTF-8 text"):
        read_biases(tmp_path / "b.csv")
