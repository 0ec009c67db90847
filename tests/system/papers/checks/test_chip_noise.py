"""The experiment on the chips' jitter: its rows on made-up figures, and its models on short runs."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from chips.noise import SiliconNoise
from circuits.devices.noise import WHITE_ONLY
from system.papers.checks import chip_noise
from system.papers.checks.chip_noise import (
    Beside,
    draw,
    nef_intervals,
    note,
    rolls_intervals,
    rows,
    tap_beside,
)
from system.study.campaign import Execution


def test_a_row_holds_the_model_to_the_transistors() -> None:
    near, far = (Beside(n, 20e-3, 50e-6, 800, 50e-6 * by) for n, by in (("near", 0.95), ("far", 1.2)))
    made = rows([near, far], far)
    assert [row.agrees for row in made] == [True, False, None]
    assert made[0].shown == pytest.approx(0.95)
    assert "near 50 us of 20 ms (+- 2.5 %), model 47.5 us" in note([near, far])
    figure = Figure()
    draw([near, far], figure)
    assert figure.axes[0].get_yscale() == "log"


def test_every_measurement_is_reported_in_its_place_and_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[tuple[object, ...]] = []

    def measured(*arguments: object) -> Beside:
        asked.append(arguments)
        return Beside(f"m{len(asked)}", 1e-3, 1e-6, 800, 1e-6 * len(asked))

    for name in ("rolls", "nef", "tap", "lso", "step", "level", "hearing", "call", "interval", "selection"):
        monkeypatch.setattr(chip_noise, f"{name}_beside", measured)
    monkeypatch.setattr(chip_noise, "isolation_rows", tuple)
    file = tmp_path / "a.jsonl"
    first = chip_noise.reproduce(lambda _: None, Execution(file), trials=7)
    names = [row.name for row in first.rows]
    count = len(asked)
    # flicker is measured after the other intervals of ROLLS, and told after the measurements of the chips
    chips = [f"jitter_m{k}" for k in (1, 2, 3, 5, 6, 7, 4)]
    assert names == [*chips, *(f"jitter_m{k}" for k in range(8, count + 1))]
    assert asked[3] == (*chip_noise.ROLLS[1], None)
    again = chip_noise.reproduce(lambda _: None, Execution(file, resume=True), trials=7)
    assert (again.rows, again.notes, len(asked)) == (first.rows, first.notes, count)
    chip_noise.reproduce(lambda _: None, Execution(file, resume=True), trials=8)
    assert len(asked) == 2 * count - 7  # those of the chips have lengths of their own


def test_models_scatter_as_expected() -> None:
    mean, deviation = rolls_intervals(71, SiliconNoise(1, flicker=WHITE_ONLY), 0.1)
    assert mean == pytest.approx(10.1e-3, rel=0.02)
    # 12 us at 99 Hz (the experiment), 2,000 intervals; steps of 0.1 ms add 1 us in squares
    assert deviation == pytest.approx(12.0e-6, rel=0.1)
    found = nef_intervals(2.5, 200)
    assert found.size > 500
    # leak alone: sqrt(q I_leak T) / (I - I_leak), and some of reset and refractory period
    shot = np.sqrt(1.602e-19 * 40e-12 * (found.mean() - 1e-3)) / 60e-12
    assert 1.0 < found.std() / shot < 1.4


def test_a_tap_beside_its_transistors() -> None:
    found = tap_beside(4)
    assert found.count == 4
    assert found.mean == pytest.approx(3.05e-3, rel=0.01)
    assert found.model == pytest.approx(0.345e-6, rel=0.03)
