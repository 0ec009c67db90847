"""`noctule export rolls --at row[5]`: a neuron of a die with its latched synapses."""

import json
from pathlib import Path

import pytest

from chips.rolls.cut import cut_row, silicon_of
from chips.rolls.program.bias_file import write_biases
from circuits.lowering.flatten import flatten
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main
from system.cli.export_rolls import row_testbench
from system.cli.rolls_program_file import read_program
from system.rolls.options import bias_table


@pytest.fixture
def program(tmp_path: Path) -> str:
    path = tmp_path / "two.csv"
    path.write_text("5,17,4\n5,40,-2\n")
    return str(path)


@pytest.fixture
def quiet(tmp_path: Path) -> str:
    """A bias file without the current that makes every neuron fire."""
    path = tmp_path / "quiet.csv"
    write_biases(path, bias_table(None).with_code("IF_DC_P", 7, 0))
    return str(path)


def test_what_is_written_is_the_row_of_the_die(
    program: str, quiet: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "row.cir"
    options = ["export", "rolls", "--at", "rolls/row[5]", "--program", program, "--bias-file", quiet]
    assert main([*options, "--die", "1003", "-o", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["synapses"] == [
        {"element": 0, "column": 17, "level": 4}, {"element": 1, "column": 40, "level": -2},
    ]  # fmt: skip
    assert (found["at"], found["starts_at_rest"], found["devices"]) == ("row[5]", True, 183)
    text = path.read_text()
    assert "die A/1003 plan row[5]" in text.splitlines()[0]
    assert text.count("\n") == found["lines"]


def test_events_come_one_after_another_and_latches_are_set(program: str) -> None:
    cut = cut_row(read_program(program, bias_table(None).with_code("IF_DC_P", 7, 0)), 5)
    bench, rests = row_testbench(cut, {"rate": 100.0, "events": 2.0, "duration": None})
    assert rests
    assert bench.stop == pytest.approx(1e-3 + 15e-3 + 10e-3)
    assert len(flatten(cut.circuit).groups) > 50
    assert silicon_of(cut, Silicon(ROLLS_180_IDEAL, die=Die(number=3))).die.sampling is not None


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--at", "row[256]"], "row[256]: must be 0 to 255"),
        (["--at", "row"], "--at: row, must be row[NEURON]"),
        ([], "--at: nothing, must be row[NEURON]"),
        (["--at", "row[5]", "--param", "x=1"], "--param: rolls has"),
        (["--at", "row[5]", "--mapping", "gf180mcu"], "--mapping: a row of rolls"),
        (["--at", "row[5]", "--level", "behavioural"], "--level: a row of rolls"),
        (["--at", "row[5]", "--die", "3", "--dialect", "cdl"], "--die: 3, cdl is the drawing"),
        (["--at", "row[5]", "--stimulus", "events=0"], "events: 0, must be a whole number from 1"),
        (["--at", "row[5]", "--stimulus", "duration=-1s"], "duration: -1 s, must be > 0"),
    ],
)
def test_bad_options_are_one_line(
    program: str, options: list[str], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", "rolls", "--program", program, "-o", "-", *options]) == 2
    error = capsys.readouterr().err
    assert text in error
    assert error.count("\n") == 1


def test_a_program_is_asked_for_and_is_of_the_chip_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "rolls", "--at", "row[5]", "-o", "-"]) == 2
    assert "--program: which synapses are latched" in capsys.readouterr().err
    assert main(["export", "dpi-synapse", "--program", "x", "-o", "-"]) == 2
    assert "--program: x, of rolls only" in capsys.readouterr().err
