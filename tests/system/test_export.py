"""`noctule export --mapping`: a block on a foundry's process."""

import json
from pathlib import Path

import pytest

from netlists import ngspice
from netlists.foundry import DeviceMapping
from system.command_line import main
from tests.netlists.conftest import ngspice_library
from tests.netlists.test_foundry import mapping

__all__ = ["mapping", "ngspice_library"]  # fixtures

EXPORT = ("export", "rebound-neuron", "--mapping", "gf180mcu")


@pytest.mark.usefixtures("ngspice_library")
def test_the_deck_runs_by_itself_and_spikes(
    mapping: DeviceMapping, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "neuron.cir"
    assert main([*EXPORT, "--stimulus", "delay=4ms", "-o", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mapping"] == "gf180mcu"
    run = ngspice.run(path.read_text(), vectors=("spike",))
    assert run.values["spike"].max() > 0.9 * mapping.v_dd


@pytest.mark.parametrize(
    ("more", "words"),
    [(("--die", "3"), "must be the nominal die"), (("--corner", "ss"), "must be the nominal die")],
)
def test_a_die_of_ours_is_refused(
    more: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*EXPORT, *more, "-o", "-"]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_an_unknown_process_lists_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "rebound-neuron", "--mapping", "sky999", "-o", "-"]) == 2
    assert "one of gf180mcu" in capsys.readouterr().err
