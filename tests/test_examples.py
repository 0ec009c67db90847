"""Every example runs and prints what it is about."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
SAYS = {
    "cartpole": "of shares of 1.0, 1.5, 0.2, 2.0",
    "device_noise": "noise analysis 64.2 uV",
    "facilitation": "fires for echoes from 6.5 to 8.0 ms",
    "latch": "unstable",
    "pushbot_program": "written as read: True",
    "learn_a_map": "unknown cells taken for 5: 26 26",
    "policies_on_a_die": "steps outside [500, 500]",
    "light_seeker": "die A/1001: at the lamp",
    "winner_take_all": "die A/1003: left then right wins",
    "working_memory": "2.3 s: holds 0.50",
    "spiral": "% right",
    "stream_client": "spikes, the first of neuron",
    "topological_map": "34 places, cost 186; networkx's Dijkstra: 186",
}


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_the_example_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)  # where some write
    monkeypatch.syspath_prepend(path.parent)  # as of a script
    runpy.run_path(str(path), run_name="__main__")
    assert SAYS.get(path.stem, "") in capsys.readouterr().out


def test_every_example_has_its_statement() -> None:
    assert {p.stem for p in EXAMPLES} >= set(SAYS)
