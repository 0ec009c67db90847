"""Measures as metrics of a study: kept as data, counted where they do not occur."""

import json
import math
from pathlib import Path

import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.cli.command_line import main
from system.options.block import choose
from system.study.metrics.measure import is_measure, measure_metrics, measure_name, named_measures
from system.study.metrics.metric import metrics_of, with_named
from system.study.table import Condition
from system.study.target import BlockTarget, Subject

BLOCK = "lso-neuron"
TOP, LATE = "v_top = max(v_mem)", "t = cross(v_mem, 7V)"


def test_texts_get_names() -> None:
    assert named_measures(["max(v)", " t=cross(v, 1)", "mean(v, from=1ms)"]) == (
        "measure_1 = max(v)", " t=cross(v, 1)", "measure_3 = mean(v, from=1ms)"
    )  # fmt: skip
    assert [measure_name(text) for text in named_measures(["1", "a = 2"])] == ["measure_1", "a"]
    assert [is_measure(text) for text in ("a = 2", "my_module:function", "best_delay")] == [
        True,
        False,
        False,
    ]
    assert with_named((TOP,), ("v_top", "x")) == (TOP, "x")


def test_a_measure_is_a_metric_with_the_unit_of_its_expression() -> None:
    choice = choose(BLOCK)
    assert {m.name: m.unit for m in measure_metrics(choice, [TOP, LATE]).values()} == {"v_top": "V", "t": "s"}
    names = [TOP, "supply_power_W", LATE]
    assert [m.name for m in metrics_of(choice, names)] == ["v_top", "supply_power_W", "t"]
    with pytest.raises(ParameterError, match="supply_power_W, the name of 2 of them, must be of one"):
        metrics_of(choice, ["supply_power_W", "supply_power_W = max(v_mem)"])


def test_what_does_not_occur_on_a_die_is_its_reason() -> None:
    target = BlockTarget(Subject(BLOCK, (TOP, LATE)))
    found = target.measure(Die(number=1000), Condition("random", 27.0, 0))
    assert found.reason == "t: v_mem does not pass through 7V"
    assert (found.values[0] > 0.0, math.isnan(found.values[1])) == (True, True)
    assert target.identity() != BlockTarget(Subject(BLOCK, (TOP, "t = cross(v_mem, 6V)"))).identity()


def test_a_study_keeps_its_measures_and_is_replayed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = str(tmp_path / "study")
    words = ["-n", "3", "--threads", "1", "--measure", TOP, "--measure", LATE, "--spec", "v_top in 1V:6V"]
    assert main(["montecarlo", BLOCK, *words, "-o", study, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["metrics"]["v_top"]["unit"] == "V"
    assert found["unmeasured"] == {"t: v_mem does not pass through 7V": 3}
    assert found["failed"] == []
    assert main(["replay", study, "--die", "1001", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["identical"]
    assert again["measured"][0]["value"] == again["again"]["v_top"]
    assert again["again"]["v_top"] == found["values"]["v_top"][1]


def test_simulate_measures_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", BLOCK, "--measure", TOP, "--measure", LATE, "--json"]) == 0
    top, late = json.loads(capsys.readouterr().out)["measured"]
    assert (top["name"], top["unit"], top["reason"]) == ("v_top", "V", None)
    assert (late["value"], late["reason"]) == (None, "v_mem does not pass through 7V")
    assert main(["simulate", BLOCK, "--measure", "max(v_meme)"]) == 2
    assert capsys.readouterr().err == (
        'noctule: --measure: "max(>v_meme)", column 5: node v_meme: unknown; did you mean v_mem?\n'
    )
    assert main(["simulate", BLOCK, "--analysis", "noise", "--node", "v_mem", "--measure", TOP]) == 2
    assert "--measure: not of --analysis noise" in capsys.readouterr().err
