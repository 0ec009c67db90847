"""The experiment on noise: its rows on a part of what it measures."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from circuits.devices import Source
from circuits.devices.noise import WHITE_ONLY
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.solver.noise.transient import NoiseRun
from system.papers.checks import device_noise
from system.papers.checks.device_noise import (
    Beside,
    behavioural_jitter,
    beside_rows,
    inhibition,
    jitter_rows,
    measure_beside,
    resistor_circuit,
    shot_jitter,
    switch_circuit,
    thermal_ratio,
)
from system.rule import equal
from system.statement import Statement
from system.study.campaign import Numbered
from tests.system.papers.campaigns import goes_on


def test_k_t_over_c() -> None:
    # the grid's ends leave out 1e-4 of the variance each
    assert thermal_ratio(resistor_circuit(), (), 85.0) == pytest.approx(1.0, rel=1e-3)
    gate = Source("g", "g", Constant(0.7))
    assert thermal_ratio(switch_circuit(), (gate,), -20.0) == pytest.approx(1.0, rel=1e-3)


@pytest.mark.usefixtures("ngspice_library")
def test_a_block_beside_ngspice() -> None:
    found = measure_beside("envelope-detector", "microphone", "envelope", 1.0, 85.0, 1003)
    assert 0.0 < found.transfer < 1e-6
    assert 0.0 < found.noise < 1e-5


def test_the_worst_of_all_blocks_decides() -> None:
    near, far = Beside("a", 27.0, None, 1e-9, 2e-9), Beside("b", 27.0, 1003, 0.02, 0.02)
    assert [row.agrees for row in beside_rows([near])] == [True, True]
    assert [(row.shown, row.agrees) for row in beside_rows([near, far])] == [(0.02, False), (0.02, True)]


def test_trials_are_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The noise of every trial is its own, whoever runs it; one whose inhibition does not end is kept too."""

    def run(machine: None, noise: NoiseRun, trial: int) -> float | None:
        drawn = np.random.default_rng((noise.seed, trial)).standard_normal()
        return None if trial == 2 else 27.4e-3 + 1e-5 * drawn

    monkeypatch.setattr(device_noise, "BESIDE_NGSPICE", ())
    monkeypatch.setattr(device_noise, "beside_rows", lambda _: [])
    monkeypatch.setattr(device_noise, "_integrated_row", lambda: Statement("kTC", 1.0, 1.0, equal()))
    monkeypatch.setattr(device_noise, "_transient_row", lambda: Statement("variance", 1.0, 1.0, equal()))
    monkeypatch.setattr(device_noise, "_machine", lambda: None)
    monkeypatch.setattr(device_noise, "simulate_noisy", run)
    monkeypatch.setattr(device_noise.rebound_neuron, "measures", lambda found: {"t_inh_s": found})
    done: list[float] = []
    goes_on(
        lambda execution: device_noise.run(done.append, execution, trials=4),
        lambda execution: device_noise.run(done.append, execution, trials=8),
        tmp_path,
    )
    assert done[-1] == pytest.approx(1.0)
    with pytest.raises(ParameterError, match="trials: 3, must be at least 4"):
        device_noise.run(done.append, trials=3)


def test_jitter_rows_hold_both_grids_to_theory() -> None:
    sigma = shot_jitter(27.4e-3)
    assert sigma == pytest.approx(10.5e-6, rel=5e-3)
    spread = np.array([-1.0, 1.0]) / np.sqrt(2.0)  # deviation 1
    right, wrong = 27.4e-3 + sigma * spread, 27.4e-3 + 1.2 * sigma * spread
    flicker = 27.4e-3 + behavioural_jitter(None) * spread
    rows = {row.name: row.agrees for row in jitter_rows(right, wrong, flicker)}
    assert rows == {
        "t_inh_jitter_over_theory": True,
        "t_inh_jitter_half_step_over_theory": False,
        "t_inh_jitter_with_flicker_s": None,
        "behavioural_jitter_white": True,
        "behavioural_jitter_flicker": True,
    }
    device_noise.draw(right, flicker, Figure())


def test_neuron_12_scatters_as_its_bias_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(device_noise.NOISES, device_noise.WHITE, NoiseRun(3, 8e-6, WHITE_ONLY))
    trials = (inhibition(Numbered(device_noise.WHITE, k)).t_inh for k in range(24))
    times = np.array(list(trials), dtype=float)
    # 24 trials know a deviation to 15 %: three of these. A coarse grid of 8 us moves the mean, not the spread
    assert times.std(ddof=1) == pytest.approx(shot_jitter(float(times.mean())), rel=0.45)
    assert times.mean() == pytest.approx(27.37e-3, rel=5e-3)
