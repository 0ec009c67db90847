"""A sample of a study again is that sample."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError
from system.command_line import main
from system.silicon_choice import SiliconChoice
from system.study.engine import SAMPLES, on_threads, run_study
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.replay import replay
from system.study.table import Condition, read_table, write_table
from system.study.target import Subject

CONDITIONS = (Condition("typical", 27.0, 0), Condition("ss", 35.0, 0))
STUDY = Study(
    Subject("rebound-neuron", ("best_delay",), silicon=SiliconChoice()),
    Plan("lhs", 0, 1000, 3),
    CONDITIONS,
    2,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("study")
    with on_threads(1) as (submit, ahead):
        run_study(STUDY, path, submit=submit, ahead=ahead)
    return path


def test_every_sample_comes_out_as_it_was_kept(folder: Path) -> None:
    for number in STUDY.dies:
        for condition in CONDITIONS:
            found = replay(folder, number, condition.corner, condition.temperature_c)
            assert found.identical
            assert found.condition == condition
            assert found.die.sampling is not None


def test_a_changed_sample_is_told(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "study.json").write_bytes((folder / "study.json").read_bytes())
    table = read_table(folder / SAMPLES)
    write_table(tmp_path / SAMPLES, replace(table, values=table.values * 1.001), ("s",))
    found = [replay(tmp_path, number) for number in STUDY.dies]
    defined = [f for f in found if not np.isnan(f.again.values).any()]
    assert defined
    assert not any(f.identical for f in defined)


def test_what_the_study_does_not_have_is_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="--die: 1003, must be 1000 to 1002"):
        replay(folder, 1003)
    with pytest.raises(ParameterError, match="the study has typical 27 degC trial 0, ss 35 degC trial 0"):
        replay(folder, 1000, "ff")
    with pytest.raises(DataError, match=r"no study, there is no study\.json"):
        replay(tmp_path, 1000)


def test_the_command_replays_with_waveforms(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture, raw = tmp_path / "a.png", tmp_path / "a.raw"
    files = ["--plot", str(picture), "--raw", str(raw)]
    assert main(["replay", str(folder), "--die", "1001", "--temperature", "35", *files, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["identical"]
    assert (document["die"], document["corner"], document["temperature_C"]) == (1001, "ss", 35.0)
    assert picture.stat().st_size > 1000
    assert raw.read_bytes().startswith(b"Title:")


def test_a_die_of_a_study_is_the_same_in_other_commands(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen = ["--study", str(folder), "--die", "1001"]
    assert main(["simulate", "rebound-neuron", *chosen, "--corner", "typical", "--json"]) == 0
    simulated = json.loads(capsys.readouterr().out)
    assert main(["replay", str(folder), "--die", "1001", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert simulated["spikes_s"] == again["spikes_s"]["spike"]
    assert simulated["measures"] == again["measures"]
    assert main(["export", "rebound-neuron", *chosen, "-o", "-"]) == 0
    assert "plan lhs/0" in capsys.readouterr().out
    assert main(["simulate", "rebound-neuron", "--study", str(folder)]) == 2
    assert "must come with --die" in capsys.readouterr().err
