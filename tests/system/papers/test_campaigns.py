"""Experiments that are campaigns: what they take, and that it does not matter who makes their runs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from inspect import signature
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

from system.cli.command_line import main
from system.registry import EXPERIMENTS, load_experiment
from system.study.campaign import ALONE
from tests.killed import kill_when
from tests.walks import Walk, install

WANTED = ["reproduce", "coins", "--param", "tosses=40", "--json"]
COMMAND = [sys.executable, "-c", "import sys; from system.cli.command_line import main; sys.exit(main())"]
# those that can be kept and gone on with: of minutes and more, three of them of 19 to 105 s of a core
SHORT = {f"milde2017-{name}" for name in ("fig5", "fig6", "power")}  # of the Pushbot, none of many drives
KEPT = {
    *(f"wen2022-{name}" for name in ("fig11a", "fig11b", "fig11d", "fig11e", "fig13", "fig15")),
    *(f"latency-{name}" for name in ("agreement", "forests", "dies", "loops")),
    *(f"stockel2017-{name}" for name in ("chip", "fig8", "campaign")),
    *(f"rolls-{name}" for name in ("calibration", "depression", "field", "learning")),
    *(n for n in EXPERIMENTS if n.startswith("milde2017-") and n not in SHORT),
    "forest-silicon", "forest-weights", "chip-noise", "device-noise", "agreement", "ngspice-dies",
    "random-circuits",
}  # fmt: skip
CAMPAIGNS = [name for name in EXPERIMENTS if load_experiment(name).counts is not None]


def test_every_experiment_that_is_kept_is_a_campaign() -> None:
    assert set(CAMPAIGNS) >= KEPT


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_a_campaign_takes_its_counts_and_who_makes_it(name: str) -> None:
    chosen = load_experiment(name)
    taken = signature(chosen.run).parameters
    counts = dict(chosen.counts or {})
    assert {n: taken[n].default for n in counts} == counts
    assert taken["execution"].default is ALONE


# As small as a campaign can be, so that what is paid is the processes alone; a toss waits, to be interrupted.
COINS = Walk(
    "Coins",
    {
        "coins.py": """
import hashlib, time
from contextlib import closing

from system.experiment import Experiment, Report, with_progress
from system.rule import within
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Numbered


def toss(key: Numbered) -> float:
    time.sleep(0.05)
    return hashlib.sha256(f"{key.condition} {key.number}".encode()).digest()[0] / 255.0


def run(progress, execution=ALONE, tosses=40):
    keys = [Numbered("fair", k) for k in range(tosses)]
    with closing(execution.results(Campaign("coins", toss, Numbered, float), keys)) as results:
        found = [next(results) for _ in with_progress(keys, progress)]
    row = Statement("mean", None, sum(found) / tosses, within(0.2, of=0.5))
    return Report((row,), draw=lambda figure: None, notes=tuple(map(str, found)))


EXPERIMENT = Experiment("coins", "where coins come to lie", run, counts={"tosses": 40})
"""
    },
    {"noctule.experiments": {"coins": "coins:EXPERIMENT"}},
    (),
)


@dataclass(frozen=True, slots=True)
class Whole:
    """A campaign that nobody disturbed: its document, and its file."""

    document: Any
    file: bytes


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Whole]:
    """The campaign of coins, which this process and those that it starts know then."""
    folder = tmp_path_factory.mktemp("whole")
    install([COINS], folder)
    file = folder / "whole.jsonl"
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        patch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
        with redirect_stdout(StringIO()) as out:
            assert main([*WANTED, "-o", str(file)]) == 0
        document = json.loads(out.getvalue())
        assert len(document["notes"]) == 40
        yield Whole(document, file.read_bytes())


def test_a_killed_campaign_goes_on_with_other_workers(
    whole: Whole, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = tmp_path / "part.jsonl"
    child = subprocess.Popen([*COMMAND, *WANTED, "-o", str(part)], stdout=subprocess.DEVNULL)
    kill_when(child, lambda: part.exists() and part.read_bytes().count(b"\n") >= 3)
    assert main([*WANTED, "-o", str(part), "--resume", "--workers", "2"]) == 0
    assert json.loads(capsys.readouterr().out) == whole.document
    assert part.read_bytes() == whole.file


def test_a_campaign_on_a_cluster_elsewhere_is_the_same(
    whole: Whole, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "elsewhere.jsonl"
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        assert main([*WANTED, "-o", str(file), "--scheduler", cluster.scheduler_address]) == 0
    assert json.loads(capsys.readouterr().out) == whole.document
    assert file.read_bytes() == whole.file
