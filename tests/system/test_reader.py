"""Options of systems in studies."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from typing import Any

import pytest
from typer.main import get_command

from circuits.errors import ParameterError
from system.cli.command_line import app, main
from system.reader import with_params
from system.registry import SYSTEMS, load_system
from system.scenario import read_texts
from tests.refusals import refusals

OPTIONS = load_system("car").settings


def test_text_is_read_and_values_stay() -> None:
    text = {"forest": "open", "soft_pings": "No", "pings": "12", "vmax": "0.5m/s"}
    found = {"forest": "open", "soft_pings": False, "pings": 12, "vmax": 0.5}
    assert read_texts(OPTIONS, text) == found
    assert read_texts(OPTIONS, found) == found


test_what_cannot_be_read_is_refused = refusals(
    ParameterError,
    lambda given: load_system("car").study_options("behavioural", None, given),
    [
        ({"soft_pings": "perhaps"}, 'soft_pings: "perhaps", must be yes or no'),
        ({"pings": "1.5"}, 'pings: "1.5", must be a whole number'),
        ({"vmax": "fast"}, "vmax: "),
        ({"vmax": "0.5"}, "vmax: .*must be a speed in m/s; write the unit too, as in 0.5m/s"),
        ({"unit": "1us"}, "unit: not an option of car, its study has vmax, ping-rate, forest"),
    ],
)


def test_parameters_are_options() -> None:
    assert with_params({"map": "a"}, ["soft-pings=no"]) == {"map": "a", "soft_pings": "no"}
    with pytest.raises(ParameterError, match="map, is given twice"):
        with_params({"map": "a"}, ["map=b"])
    with pytest.raises(ParameterError, match="must be NAME=VALUE"):
        with_params({}, ["map"])


def test_a_study_of_the_car_in_another_forest(capsys: pytest.CaptureFixture[str]) -> None:
    study = ("montecarlo", "car", "-n", "1", "--metric", "collided", "--param", "pings=3", "--json")
    assert main([*study, "--param", "forest=open"]) == 0
    assert json.loads(capsys.readouterr().out)["failed"] == []
    assert main([*study, "--param", "forest=wood"]) == 2
    assert "--param forest: wood, must be corridor, open or dense" in capsys.readouterr().err


def test_a_duration_that_a_system_has_not_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["montecarlo", "rover", "-n", "1", "--duration", "3s"]) == 2
    assert "--duration: not an option of rover, its study has map, start" in capsys.readouterr().err


def test_a_duration_is_none_of_a_block(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["montecarlo", "rebound-neuron", "-n", "1", "--duration", "3s"]) == 2
    assert "--duration: not an option of a block" in capsys.readouterr().err


def test_a_study_of_the_pushbot_on_another_scene(capsys: pytest.CaptureFixture[str]) -> None:
    study = ("montecarlo", "pushbot", "-n", "1", "--metric", "collided", "--json", "--duration", "50ms")
    assert main([*study, "--param", "scene=pair", "--param", "codes=default"]) == 0
    assert json.loads(capsys.readouterr().out)["metrics"]
    assert main([*study, "--param", "scene=none"]) == 2


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_number_of_every_system_states_its_unit(name: str) -> None:
    for option, one in load_system(name).settings.items():
        if not (one.option.run or one.option.study):
            continue
        assert (one.option.unit is not None) == (one.kind is float or option == "area"), option
        if one.option.unit and one.option.unit != "degC":  # which is no other than its number
            with pytest.raises(ParameterError, match=f"{option}: .*write the unit too"):
                load_system(name).scenario(**{option: "1"})


def test_no_option_of_the_command_line_is_read_without_its_unit() -> None:
    """A number that click itself reads has no unit: only ratios may be such."""
    found = {option for command in commands(get_command(app())) for option in plain_numbers(command)}
    assert found == {"rtol", "reach", "sigma", "pace"}


def commands(group: Any) -> Iterator[Any]:
    for name in group.list_commands(None):
        command = group.get_command(None, name)
        yield from commands(command) if hasattr(command, "commands") else (command,)


def plain_numbers(command: Any) -> Iterator[str]:
    for parameter in inspect.signature(command.callback).parameters.values():
        if "float" in str(parameter.annotation):
            yield parameter.name
