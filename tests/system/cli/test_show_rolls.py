"""`noctule show rolls`: a die's portrait in print, JSON and picture."""

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from chips.rolls import portrait as rolls_portrait
from chips.rolls import power
from chips.rolls.plastic import power as plastic_power
from chips.rolls.program.bias_file import BiasTable, default_biases, write_biases
from system.cli import show_rolls
from system.cli.command_line import main
from system.files import kept
from tests.refusals import command_refusals

MEASURED = ("portrait", "energies", "plastic_energies", "depression_energies")


@pytest.fixture(scope="module", autouse=True)
def once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Two points of each curve, and each die measured once."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("answers")  # of fewer points than others keep
        patch.setattr(kept, "answers_folder", lambda: folder)
        for module in (rolls_portrait, show_rolls):
            patch.setattr(module, "MULTIPLES", np.array([3.0, 9.0]))
        patch.setattr(power, "MULTIPLES", (3.0, 40.0))
        patch.setattr(plastic_power, "SPIKE_RATES", (5.0, 300.0))
        for name in MEASURED:
            patch.setattr(show_rolls, name, cache(getattr(show_rolls, name)))
        yield


OPTIONS = ["show", "rolls", "--die", "1003", "--bias-kind", "ideal", "--temperature", "35"]


def test_json_and_picture_tell_of_one_die(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "die.png"
    assert main([*OPTIONS, "--json", "--plot", str(path)]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert np.array(found["fi_rate_Hz"]).shape == (256, 2)
    assert len(found["refractory_period_s"]) == len(found["pulse_length_s"]) == 256
    assert [w["level"] for w in found["weights"]] == [1, 2, 3, 4, -1, -2, -3, -4]
    power = found["power"]
    assert power["paper_typical_W"] == 4e-3
    rest = power["at_rest"]
    assert rest["bias_W"] == pytest.approx(power["biases_W"] + power["generator_W"])
    assert rest["static_W"] == pytest.approx(sum(power["static_W"].values()))
    assert rest["static_W"] == pytest.approx(power["rest_W"])
    assert rest["dynamic_W"] == 0.0
    assert rest["total_W"] == pytest.approx(rest["static_W"] + rest["bias_W"])
    assert power["at_rate"][0]["unconnected_W"] == pytest.approx(rest["total_W"])
    # no reference, buses or pads are counted, and neurons rest
    assert 0.1e-3 < power["at_rate"][0]["unconnected_W"] < 4e-3
    assert path.stat().st_size > 10_000
    check_plastic(found["plastic_power"])
    # the default file has the step off: leaks and the gates of switches
    assert 0.0 < found["depression_power"]["rest_W"] < 2e-6
    assert 20e-15 < found["depression_power"]["event_energy_J"] < 100e-15


def check_plastic(power: dict[str, Any]) -> None:
    """Rest is that of 65,536 weights and the learning circuits, and each event adds its energy."""
    rest, event = power["weight_rest_W"], power["weight_event_energy_J"]
    for name in ("low", "high"):
        rows = {row["rate_Hz"]: row[f"all_{name}_W"] for row in power["at_rate"]}
        assert rows[0.0] == pytest.approx(power["learning_circuits_rest_W"] + 65536 * rest[name])
        spike = np.interp(np.log(10.0), np.log(power["spike_rate_Hz"]), power["spike_energy_J"])
        once = 65536 * event[name] + 256 * (power["column_event_energy_J"] + spike)
        assert rows[10.0] - rows[0.0] == pytest.approx(10.0 * once)
    # a comparator's branch of 41 pA at 1.8 V, and leaks at 35 degC; all weights far below the paper's 4 mW
    assert 70e-12 < rest["low"] < 0.2e-9
    assert 70e-12 < rest["high"] < 0.2e-9
    assert event["high"] > 10.0 * event["low"]


def test_print_has_a_table_of_each(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(OPTIONS) == 0
    printed = capsys.readouterr().out
    for title in (
        "neurons and filters",
        "f-I curve (Hz)",
        "weights",
        "power; the paper's typical figure is",
        "power of the plastic array, beside the above",
    ):
        assert title in printed
    assert "at rest: learning circuits " in printed
    assert "energy of an event: of a column " in printed
    assert "cells of depression, where a program has them: rest " in printed
    assert "256 of 256 neurons fire by the bias I_dc of 87.5nA alone" in printed


def test_a_die_is_measured_once_a_machine(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main([*OPTIONS, "--json"]) == 0
    first = capsys.readouterr().out
    for name in MEASURED:
        monkeypatch.setattr(show_rolls, name, lambda *_: pytest.fail("measured again"))
    assert main([*OPTIONS, "--json"]) == 0
    assert capsys.readouterr().out == first


def without_plastic_biases() -> BiasTable:
    """The default biases but for those of plastic weights and of depression."""
    lacking = ("PA_W", "NPA_WEIGHT_STD")
    return BiasTable(tuple(e for e in default_biases().entries if not e.name.startswith(lacking)))


def test_a_bias_file_without_the_array_s_biases_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_biases(tmp_path / "few.csv", without_plastic_biases())
    assert main([*OPTIONS, "--bias-file", str(tmp_path / "few.csv")]) == 0
    printed = capsys.readouterr().out
    assert "the plastic array: not told, the bias file lacks PA_WDRIFTUP_P, PA_WDRIFTDN_N" in printed
    assert "cells of depression: not told, the bias file lacks NPA_WEIGHT_STD_N" in printed


test_bad_options_are_one_line = command_refusals(
    "show",
    rows=[
        ("rolls --plot die.txt", "--plot: die.txt"),
        ("rolls --bias i_tau=1nA", "--bias: rolls has its biases by code"),
        ("rolls --at 'rolls/row[3]'", "--at"),
        ("rolls --temperature 200", "temperature: 200 degC"),
        ("rolls --bias-file none.csv", "none.csv: No such file"),
        ("dpi-synapse --bias-file x.csv", "--bias-file: x.csv, of rolls only"),
    ],
)
