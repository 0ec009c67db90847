"""Nothing that is given twice is quietly taken once."""

import json
from typing import Any

import pytest
import typer

from system.cli import given_once
from system.cli.command_line import app, main

CASES = [
    ("op rebound-neuron --temperature 27 --temperature 85", "--temperature: given 2 times"),
    ("simulate rebound-neuron --die 1 --json --die 2", "--die: given 2 times"),
    ("montecarlo rebound-neuron -n 3 --samples 4", "--samples/-n: given 2 times"),
    ("characterise rebound-neuron -o a.nc --output b.nc", "--output/-o: given 2 times"),
    ("run approach --isolation --no-isolation", "--isolation/--no-isolation: given 2 times"),
    ("run bug --seed 1 --seed 1", "--seed: given 2 times"),
    ("op rebound-neuron --bias v-th=2V --bias v_th=3V", "--bias: v_th is set 2 times"),
    ("op rebound-neuron --start v_mem=2V --start v_mem=3V", "--start: v_mem is set 2 times"),
    ("reproduce latency-dies --param dies=1 --param dies=2", "--param: dies is set 2 times"),
]


@pytest.mark.parametrize(("arguments", "words"), CASES)
def test_what_is_given_twice_is_refused(
    arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments.split()) == 2
    found = capsys.readouterr()
    assert found.out == ""
    assert words in found.err
    assert found.err.count("\n") == 1


def test_what_is_repeatable_stays_so(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = "show rebound-neuron --bias v_th=2V --bias i_lim=6uA --json"
    assert main(arguments.split()) == 0
    assert json.loads(capsys.readouterr().out)["block"] == "rebound-neuron"


def test_every_command_refuses() -> None:
    def commands(group: Any) -> list[Any]:
        each = [group.get_command(None, name) for name in group.list_commands(None)]
        inner = [commands(c) if hasattr(c, "commands") else [c] for c in each]
        return [command for part in inner for command in part]

    found = commands(typer.main.get_command(app()))
    assert len(found) > 15
    assert {type(command) for command in found} == {given_once.OnceCommand}
