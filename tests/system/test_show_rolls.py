"""`noctule show rolls`: a die's portrait in print, JSON and picture."""

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from chips import rolls_portrait
from system.command_line import main
from system.commands import show_rolls


@pytest.fixture(scope="module", autouse=True)
def once() -> Iterator[None]:
    """Two points of a curve, and each die measured once."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (rolls_portrait, show_rolls):
            patch.setattr(module, "MULTIPLES", np.array([3.0, 9.0]))
        patch.setattr(show_rolls, "portrait", cache(rolls_portrait.portrait))
        yield


OPTIONS = ["show", "rolls", "--die", "1003", "--bias-kind", "generator", "--temperature", "35"]


def test_json_and_picture_tell_of_one_die(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "die.png"
    assert main([*OPTIONS, "--json", "--plot", str(path)]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert np.array(found["fi_rate_Hz"]).shape == (256, 2)
    assert len(found["refractory_period_s"]) == len(found["pulse_length_s"]) == 256
    assert [w["level"] for w in found["weights"]] == [1, 2, 3, 4, -1, -2, -3, -4]
    power = found["power"]
    assert power["paper_typical_W"] == 4e-3
    assert power["at_rate"][0]["unconnected_W"] == pytest.approx(power["biases_W"] + power["rest_W"])
    # no reference, buses or plastic synapses are counted, and neurons rest
    assert 0.1e-3 < power["at_rate"][0]["unconnected_W"] < 4e-3
    assert path.stat().st_size > 10_000


def test_print_has_a_table_of_each(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(OPTIONS) == 0
    printed = capsys.readouterr().out
    for title in ("neurons and filters", "f-I curve (Hz)", "weights", "power; the paper's typical figure is"):
        assert title in printed
    assert "256 of 256 neurons fire by the bias I_dc of 87.5nA alone" in printed


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["rolls", "--plot", "die.txt"], "--plot: die.txt"),
        (["rolls", "--bias", "i_tau=1nA"], "--bias: rolls has its biases by code"),
        (["rolls", "--at", "rolls/row[3]"], "--at"),
        (["rolls", "--temperature", "200"], "temperature: 200 degC"),
        (["rolls", "--bias-file", "none.csv"], "none.csv: No such file"),
        (["dpi-synapse", "--bias-file", "x.csv"], "--bias-file: x.csv, of rolls only"),
    ],
)
def test_bad_options_are_one_line(options: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", *options]) == 2
    error = capsys.readouterr().err
    assert text in error
    assert error.count("\n") == 1
