"""`noctule show`: the metrics of a block, those of its testbench where they are asked for."""

import json

import pytest

from system.cli.command_line import main


def test_metrics_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "rebound-neuron", "--json"]) == 0
    listed = {m["name"]: m for m in json.loads(capsys.readouterr().out)["metrics"]}
    assert listed["best_delay"]["unit"] == "s"
    assert {m["nominal"] for m in listed.values()} == {None}
    assert main(["show", "axon-delay", "--metrics", "--json"]) == 0
    listed = {m["name"]: m for m in json.loads(capsys.readouterr().out)["metrics"]}
    assert listed["supply_power_W"]["unit"] == "W"
    assert listed["supply_power_W"]["nominal"] > 0.0
    assert main(["show", "axon-delay"]) == 0
    assert "--metrics" in capsys.readouterr().out


@pytest.mark.parametrize("chip", ["rolls", "nef-chip"])
def test_a_chip_without_a_testbench_measures_nothing(chip: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", chip, "--metrics"]) == 2
    assert capsys.readouterr().err.startswith("noctule: --metrics: ")
