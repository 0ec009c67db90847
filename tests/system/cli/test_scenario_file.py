"""Scenario files: what a file says is what the options say, the command line goes over it, errors name it."""

from pathlib import Path

import pytest

from circuits.errors import DataError
from system.cli.scenario_file import read_scenario_file
from system.registry import load_system, system_names
from tests.refusals import file_refusals
from tests.system.conftest import Run, RunJson

CAR = """
vmax = 0.1
ping-rate = "10Hz"
forest = "dense"
ranges = "exact"
pings = 3
soft_pings = false
seed = 7
"""


@pytest.fixture
def car(tmp_path: Path) -> Path:
    path = tmp_path / "car.toml"
    path.write_text(CAR)
    return path


def test_a_file_says_what_the_options_say(car: Path, run_json: RunJson) -> None:
    words = "--vmax 0.1m/s --ping-rate 10Hz --forest dense --ranges exact --pings 3 --no-soft-pings --seed 7"
    assert run_json("run", "car", "--scenario", str(car)) == run_json("run", "car", *words.split())


def test_the_command_line_goes_over_the_file(car: Path, run_json: RunJson) -> None:
    words = "--pings 2 --ranges flight --soft-pings --forest open --seed 0"
    found = run_json("run", "car", "--scenario", str(car), *words.split())
    said = {"pings": 2, "ranges": "flight", "soft_pings": True, "forest": "open", "seed": 0}
    assert {key: found[key] for key in said} == said
    assert (found["max_speed_m_per_s"], found["ping_rate_Hz"]) == (0.1, 10.0)


def test_texts_of_an_option_that_is_given_again_and_again(tmp_path: Path, run: Run) -> None:
    path = tmp_path / "approach.toml"
    path.write_text('transistors = ["nothing"]\n')
    status, out, err = run("run", "approach", "--scenario", str(path))
    assert (status, out) == (2, "")
    assert err.startswith(f"noctule: {path}: transistors: nothing, must be ")


@pytest.mark.parametrize("name", system_names())
def test_every_option_of_a_run_may_stand_in_a_file(name: str, tmp_path: Path) -> None:
    system = load_system(name)
    for key, one in system.settings.items():
        if not one.option.run or one.option.collect is not None:
            continue
        value = True if one.kind is bool else one.choices[0] if one.choices else one.default
        if not isinstance(value, str | int | float) or one.option.to_field:
            continue
        text = str(value).lower() if isinstance(value, bool) else repr(value)
        path = tmp_path / f"{key}.toml"
        path.write_text(f"{key} = {text}\n")
        assert set(read_scenario_file(str(path), system).values) == {key}


test_an_error_names_file_key_value_and_rule = file_refusals(
    DataError,
    "own.toml",
    lambda path: read_scenario_file(path, load_system("car")),
    [
        ("vmaxx = 1", "vmaxx: unknown; did you mean vmax"),
        ("qqq = 1", "qqq: unknown; options of car are temperature, lot, "),
        ("vmax = -1", "vmax: -1 m/s, must be > 0"),
        ('vmax = "fast"', 'vmax: .*"?fast"?.*'),
        ("vmax = true", "vmax: True, must be a text or a number"),
        ("vmax = [1]", r"vmax: \[1\.?0?\], must be a text or a number"),
        ("ping-rate = 1\nping_rate = 2", "ping_rate: is given twice, must be given once; leave one out"),
        ('soft_pings = "no"', "soft_pings: 'no', must be true or false"),
        ("pings = 1.5", 'pings: "1.5", must be a whole number'),
        ('ranges = "far"', "ranges: far, must be flight, exact or chip"),
        ("seed = 1.5", "seed: 1.5, must be a whole number"),
        ("die = true", "die: True, must be a whole number"),
        ('corner = "slow"', "corner: 'slow', must be random, typical, ss, ff, sf or fs"),
        ("lot = 7", "lot: 7, must be a text"),
        ("pings = ", ".*; must be TOML in UTF-8"),
    ],
    start=r"own\.toml: ",
)


def test_an_error_that_only_the_run_finds_names_the_file_that_gave_the_value(
    tmp_path: Path, run: Run
) -> None:
    path = tmp_path / "own.toml"
    path.write_text("die = -1\ntemperature = 400\n")
    status, _, err = run("run", "car", "--scenario", str(path))
    assert status == 2
    assert err.startswith(f"noctule: {path}: die: -1, must be ")
    status, _, err = run("run", "car", "--scenario", str(path), "--die", "-2")
    assert err.startswith("noctule: --die: -2, must be ")
    status, _, err = run("run", "car", "--scenario", str(path), "--die", "2")
    assert err.startswith(f"noctule: {path}: temperature: 400 ")


def test_a_value_that_the_scenario_itself_refuses_names_the_file(tmp_path: Path, run: Run) -> None:
    path = tmp_path / "own.toml"
    path.write_text('forest = "jungle"\n')
    _, _, err = run("run", "car", "--scenario", str(path))
    assert err.startswith(f"noctule: {path}: forest: jungle, must be corridor, open or dense; or a file")


def test_a_file_that_is_not_there(run: Run) -> None:
    status, _, err = run("run", "car", "--scenario", "none.toml")
    assert status == 2
    assert err == "noctule: none.toml: No such file or directory, must be a readable file; check the path\n"
