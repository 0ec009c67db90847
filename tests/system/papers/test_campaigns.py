"""Experiments that are campaigns: what they take, and that a killed one goes on with other workers."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from inspect import signature
from pathlib import Path

import pytest

from system.cli.command_line import main
from system.registry import EXPERIMENTS, load_experiment
from system.study.campaign import ALONE

COMMAND = [sys.executable, "-c", "import sys; from system.cli.command_line import main; sys.exit(main())"]
# those that can be kept and gone on with: of minutes and more, three of them of 19 to 105 s of a core
KEPT = {
    *(f"wen2022-{name}" for name in ("fig11a", "fig11b", "fig11d", "fig11e", "fig13", "fig15")),
    *(f"latency-{name}" for name in ("agreement", "forests", "dies", "loops")),
    *(f"stockel2017-{name}" for name in ("chip", "fig8", "campaign")),
    *(f"rolls-{name}" for name in ("calibration", "field", "learning")),
    *(n for n in EXPERIMENTS if n.startswith("milde2017-") and n not in {"milde2017-fig5", "milde2017-fig6"}),
    "forest-silicon", "forest-weights", "chip-noise",
}  # fmt: skip
CAMPAIGNS = [name for name in EXPERIMENTS if load_experiment(name).counts]


def test_every_experiment_that_is_kept_is_a_campaign() -> None:
    assert set(CAMPAIGNS) >= KEPT


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_a_campaign_takes_its_counts_and_who_makes_it(name: str) -> None:
    chosen = load_experiment(name)
    taken = signature(chosen.run).parameters
    assert {n: taken[n].default for n in chosen.counts} == dict(chosen.counts)
    assert taken["execution"].default is ALONE


def test_a_killed_campaign_goes_on_with_other_workers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Rows, notes and the lines of the file are those of a campaign that nobody disturbed."""
    wanted = ["reproduce", "forest-weights", "--param", "collisions=1", "--json"]
    whole, part = tmp_path / "whole.jsonl", tmp_path / "part.jsonl"
    main([*wanted, "-o", str(whole)])
    expected = json.loads(capsys.readouterr().out)
    child = subprocess.Popen([*COMMAND, *wanted, "-o", str(part)], stdout=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 120.0
        while not part.exists() or part.read_bytes().count(b"\n") < 3:
            assert time.monotonic() < deadline
            time.sleep(0.02)
        os.kill(child.pid, signal.SIGKILL)
    finally:
        child.kill()
        child.wait()
    assert main([*wanted, "-o", str(part), "--resume", "--workers", "2"]) in {0, 1}
    assert json.loads(capsys.readouterr().out) == expected
    assert part.read_bytes() == whole.read_bytes()
