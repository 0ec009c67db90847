"""Each lab runs from its first cell to its last, and prints the numbers that are asked of a student."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

mpl.use("Agg")
LABS = Path(__file__).parents[1] / "docs" / "labs"
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
ASKED = {
    "transistor": {"threshold_V", "pair_kappa", "pair_offset_V"},
    "amplifier": {"amplifier_switch_V", "slew_V_per_s", "follower_tau_s"},
    "neuron": {"synapse_floor_V", "synapse_recovery_V_per_s", "hillock_jump_V", "neuron_interval_s"},
}


@pytest.mark.parametrize("lab", ASKED)
def test_a_lab_runs_and_prints_its_numbers(lab: str, capsys: pytest.CaptureFixture[str]) -> None:
    cells = CELL.findall((LABS / f"{lab}.md").read_text(encoding="utf-8"))
    assert all(len(cell.splitlines()) <= 20 for cell in cells)
    names: dict[str, Any] = {}
    for cell in cells:
        exec(compile(cell, f"{lab}.md", "exec"), names)  # noqa: S102 - the page's own cells
        plt.close("all")
    said = dict(re.findall(r"^(\w+) = (-?[\d.e+-]+)$", capsys.readouterr().out, re.MULTILINE))
    assert set(said) == ASKED[lab]
    assert all(float(value) for value in said.values())


def test_all_labs_are_here() -> None:
    assert {page.stem for page in LABS.glob("*.md")} == {*ASKED, "index"}
