"""Each figure of Cheely & Horiuchi 2003 is made again, and what was predicted agrees with the paper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from system.experiment import Experiment, Progress, Report
from system.papers.cheely2003 import fig9 as cheely2003_fig9
from system.papers.cheely2003 import fig10 as cheely2003_fig10
from system.plot import save_picture
from system.registry import EXPERIMENTS, load_experiment

FIGURES = ("fig4", "fig5", "fig8", "fig9", "fig10")

# Coarser grids than the experiments' own, for time: 27 delays instead of 53, 5 voltages instead of 15.
QUICK: dict[str, Callable[[Progress], Report]] = {
    "fig9": lambda progress: cheely2003_fig9.run_on_grid(progress, 1e-3),
    "fig10": lambda progress: cheely2003_fig10.run_on_grid(progress, 5),
}


@pytest.fixture(scope="module", params=FIGURES)
def experiment(request: pytest.FixtureRequest) -> Experiment:
    loaded = load_experiment(f"cheely2003-{request.param}")
    return replace(loaded, run=QUICK.get(request.param, loaded.run))


@pytest.fixture(scope="module")
def outcome(experiment: Experiment) -> tuple[Report, list[float]]:
    fractions: list[float] = []
    return experiment.run(fractions.append), fractions


def test_every_row_agrees(outcome: tuple[Report, list[float]]) -> None:
    rows = outcome[0].rows
    assert [row.name for row in rows if not row.agrees] == []
    assert len({row.name for row in rows}) == len(rows)
    assert any(not row.fitted for row in rows)


def test_progress_rises_to_one(outcome: tuple[Report, list[float]]) -> None:
    fractions = outcome[1]
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)


def test_it_draws(outcome: tuple[Report, list[float]], tmp_path: Path) -> None:
    picture = tmp_path / "figure.png"
    save_picture(str(picture), outcome[0].draw)
    assert picture.stat().st_size > 10_000  # an empty figure has 3 kB


def test_the_registry_knows_them() -> None:
    for figure in FIGURES:
        name = f"cheely2003-{figure}"
        assert name in EXPERIMENTS
        assert load_experiment(name).name == name


def test_silent_delays_of_the_linear_chip_are_counted_and_told() -> None:
    fractions: list[float] = []
    report = cheely2003_fig9.run_on_grid(fractions.append, 6.5e-3)
    ours = {row.name: row.shown for row in report.rows}
    # of 2, 8.5, 15, 21.5 and 28 ms those between neuron 11 (11 ms) and neuron 12 (26 ms) have no neuron
    assert ours["linear_silent_delays"] in (2, 3)
    assert any("no neuron fires" in note for note in report.notes)
