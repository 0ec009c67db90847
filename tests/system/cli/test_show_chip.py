"""Chips that run as a behavioural model alone are listed and shown, and say what else to do with them."""

from __future__ import annotations

import json

import pytest

from chips.nef.circuit import FILTERS, NEURONS, chip_biases
from chips.registry import CHIPS
from system.cli.command_line import main


def test_the_circuits_of_a_chip_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "nef-chip", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    parts = {i["name"]: i["shape"] for circuit in found["circuits"] for i in circuit["instances"]}
    assert parts == {"neuron": [NEURONS], "stage": [NEURONS], "filter": [FILTERS], "line": [FILTERS]}
    shown = {b["name"]: b["value"] for circuit in found["circuits"] for b in circuit["biases"]}
    assert shown == {b.name: b.value for b in chip_biases()}
    assert all(c["device_count"] > c["node_count"] > 1 for c in found["circuits"])
    assert main(["show", "nef-chip"]) == 0
    assert "neuron[8192]" in capsys.readouterr().out


@pytest.mark.parametrize("option", [("--die", "3"), ("--param", "a=1"), ("--bias-kind", "ideal")])
def test_what_only_blocks_take_is_refused(
    option: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["show", "nef-chip", *option]) == 2
    said = capsys.readouterr().err
    assert option[0] in said
    assert said.endswith("nef-chip is shown as it is built; leave it out\n")


@pytest.mark.parametrize("name", ["nef-chip", "rolls"])
def test_a_testbench_that_a_chip_has_not_is_refused_with_a_remedy(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert name in CHIPS
    for command in (["op", name], ["simulate", "dpi-synapse", "--at", f"{name}/row[0]"]):
        assert main(command) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"noctule: {name}: has no testbench as one circuit; ")
        assert said.count("\n") == 1
