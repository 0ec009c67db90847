"""Rules of the depression experiment, on made-up runs; runs themselves are tested with the chip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from chips.rolls.chip import RollsChip
from chips.rolls.depression.trains import Response, Train
from system.experiment import Report
from system.papers.checks import rolls_depression
from system.study.campaign import ALONE, Execution
from tests.system.papers.campaigns import goes_on

KAPPA = 0.66


def made_up(
    monkeypatch: pytest.MonkeyPatch,
    *,
    off: float = 0.0,
    power: float = KAPPA,
    execution: Execution = ALONE,
    dies: int = 1,
) -> Report:
    """The experiment on trains that fall as the closed form; off: error of the chip's last charges."""

    def one(_: RollsChip, rate: float = 100.0) -> Train:
        gone = np.exp(-1.0 / (rate * 0.054))
        closed = float((1.0 - gone) / (1.0 - gone * np.exp(-0.48)))
        circuit = {k: np.array([1.0, closed**power]) for k in rolls_depression.LEVELS}
        chip = {k: q + np.array([0.0, off]) for k, q in circuit.items()}
        return Train(1000, 27.0, rate, np.array([0.0, 1.0 / rate]), circuit, chip, closed, closed, KAPPA)

    def response(die: int, rows: int) -> Response:
        falling = np.concatenate(([100.0], np.full(9, 50.0)))
        spikes = tuple(np.linspace(0.0, 0.5, 20) for _ in range(rows))
        return Response(die, falling, np.full(10, 100.0), spikes, spikes, 0.1)

    for name, replacement in (("train", one), ("rate_step", one), ("response", response)):
        monkeypatch.setattr(rolls_depression, name, replacement)
    monkeypatch.setattr(rolls_depression, "_chip", lambda *_: None)
    monkeypatch.setattr(rolls_depression, "ROWS", 1)
    done: list[float] = []
    report = rolls_depression.run(done.append, execution, dies, dies)
    assert done[-1] == 1.0
    return report


def test_runs_are_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    goes_on(
        lambda execution: made_up(monkeypatch, execution=execution),
        lambda execution: made_up(monkeypatch, execution=execution, dies=2),
        tmp_path,
    )


def test_what_follows_the_law_agrees_and_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    report = made_up(monkeypatch)
    assert report.agrees
    named = {row.name: row.shown for row in report.rows}
    # 500 to 1000 Hz is not yet the end of the law
    assert named["slope of R over the rate, logarithms, 500 to 1000 Hz"] == pytest.approx(-0.946, abs=0.01)
    report.draw(Figure())


@pytest.mark.parametrize(
    ("off", "power", "row"),
    [(0.02, KAPPA, "settled charge over the first one"), (0.0, 1.0, "the same of the charge of level 1")],
)
def test_a_chip_that_is_off_and_another_power_disagree(
    monkeypatch: pytest.MonkeyPatch, off: float, power: float, row: str
) -> None:
    report = made_up(monkeypatch, off=off, power=power)
    assert any(row in each.name for each in report.rows if each.agrees is False)
