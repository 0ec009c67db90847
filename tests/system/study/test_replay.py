"""A sample of a study again is that sample."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError
from system.cli.command_line import main
from system.options.silicon import SiliconChoice
from system.study.engine import on_threads, run_study
from system.study.folder import SAMPLES, study_table
from system.study.manifest import Study, read_manifest, study_key
from system.study.plan import Plan
from system.study.replay import replay
from system.study.table import Condition, write_table
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
    with on_threads(1) as workers:
        run_study(STUDY, path, workers=workers)
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
    table, key = study_table(folder), study_key(read_manifest(folder))
    write_table(tmp_path / SAMPLES, replace(table, values=table.values * 1.001), ("s",), key)
    found = [replay(tmp_path, number) for number in STUDY.dies]
    defined = [f for f in found if not np.isnan(f.again.values).any()]
    assert defined
    assert not any(f.identical for f in defined)


def test_what_the_study_does_not_have_is_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="die: 1003, must be 1000 to 1002"):
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


@pytest.fixture(scope="module")
def classes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Neurons of three classes, under biases of their own."""
    path = tmp_path_factory.mktemp("classes")
    options = ["-n", "6", "--metric", "best_delay", "--bias", "i_lim=5uA", "-o", str(path)]
    assert main(["montecarlo", "rebound-neuron", *options]) == 0
    return path


def test_a_replay_runs_what_the_study_measured(classes: Path, capsys: pytest.CaptureFixture[str]) -> None:
    seen = set()
    for number in range(1000, 1006):
        assert main(["replay", str(classes), "--die", str(number), "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        word, stimuli, spikes = found["kept"]["class"], found["stimuli"], found["spikes_s"]["spike"]
        assert found["identical"]
        if word == "works":  # silent without one of the two, and fires at its best delay
            assert stimuli["delay"] == found["kept"]["best_delay"]
            assert (stimuli["call"], stimuli["echo"]) == (1.0, 1.0)
        elif word == "call-alone":
            assert (stimuli["call"], stimuli["echo"]) == (1.0, None)
        elif word == "echo-alone":
            assert (stimuli["call"], stimuli["echo"]) == (None, 1.0)
        assert bool(spikes) == (word != "never")
        seen.add(word)
        if {"works", "call-alone"} <= seen:
            return
    pytest.fail(f"only {seen} among the dies")


def test_a_replay_of_the_testbench_has_the_study_s_stimuli(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["-n", "1", "--metric", "v_mem_peak_V", "--stimulus", "delay=9.9ms", "-o", str(tmp_path)]
    assert main(["montecarlo", "rebound-neuron", *options, "--bias", "i_rtau=40pA"]) == 0
    capsys.readouterr()
    assert main(["replay", str(tmp_path), "--die", "1000", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["stimuli"]["delay"] == 9.9e-3
    assert found["measures"]["v_mem_peak_V"] == found["kept"]["v_mem_peak_V"]
    assert main(["replay", str(tmp_path), "--die", "1000"]) == 0
    assert "stimuli: delay=9.9ms" in capsys.readouterr().out


def test_a_die_of_a_study_is_the_same_in_other_commands(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen = ["--study", str(folder), "--die", "1001"]
    assert main(["replay", str(folder), "--die", "1001", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    shown = [x for n in ("delay", "duration") for x in ("--stimulus", f"{n}={again['stimuli'][n]!r}s")]
    assert main(["simulate", "rebound-neuron", *chosen, *shown, "--corner", "typical", "--json"]) == 0
    simulated = json.loads(capsys.readouterr().out)
    # the study's run is in lanes, and differs by roundings
    assert simulated["spikes_s"] == pytest.approx(again["spikes_s"]["spike"], rel=0.0, abs=1e-9)
    assert simulated["measures"] == pytest.approx(again["measures"], rel=1e-6)
    assert main(["export", "rebound-neuron", *chosen, "-o", "-"]) == 0
    assert "plan lhs/0" in capsys.readouterr().out
    assert main(["simulate", "rebound-neuron", "--study", str(folder)]) == 2
    assert "must come with --die" in capsys.readouterr().err
