"""The experiment on noise: its rows on a part of what it measures."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from circuits.devices import Source
from circuits.devices.noise import WHITE_ONLY
from circuits.devices.source import Constant
from circuits.solver.noise.transient import NoiseRun
from netlists.ngspice.library import find_library
from system.papers.checks import device_noise
from system.papers.checks.device_noise import (
    Beside,
    behavioural_jitter,
    beside_rows,
    inhibitions,
    jitter_rows,
    measure_beside,
    neuron_machine,
    resistor_circuit,
    shot_jitter,
    switch_circuit,
    thermal_ratio,
)
from system.registry import load_experiment


def test_it_is_listed() -> None:
    assert load_experiment("device-noise") is device_noise.EXPERIMENT


def test_k_t_over_c() -> None:
    # the grid's ends leave out 1e-4 of the variance each
    assert thermal_ratio(resistor_circuit(), (), 85.0) == pytest.approx(1.0, rel=1e-3)
    gate = Source("g", "g", Constant(0.7))
    assert thermal_ratio(switch_circuit(), (gate,), -20.0) == pytest.approx(1.0, rel=1e-3)


def test_a_block_beside_ngspice() -> None:
    if find_library() is None:
        pytest.skip("no ngspice library")
    found = measure_beside("envelope-detector", "microphone", "envelope", 1.0, 85.0, 1003)
    assert 0.0 < found.transfer < 1e-6
    assert 0.0 < found.noise < 1e-5


def test_the_worst_of_all_blocks_decides() -> None:
    near, far = Beside("a", 27.0, None, 1e-9, 2e-9), Beside("b", 27.0, 1003, 0.02, 0.02)
    assert [row.agrees for row in beside_rows([near])] == [True, True]
    assert [(row.shown, row.agrees) for row in beside_rows([near, far])] == [(0.02, False), (0.02, True)]


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


def test_neuron_12_scatters_as_its_bias_says() -> None:
    machine = neuron_machine(device_noise.NEURON)
    times = inhibitions(machine, NoiseRun(3, 8e-6, WHITE_ONLY), 24)
    # 24 trials know a deviation to 15 %: three of these. A coarse grid of 8 us moves the mean, not the spread
    assert times.std(ddof=1) == pytest.approx(shot_jitter(float(times.mean())), rel=0.45)
    assert times.mean() == pytest.approx(27.37e-3, rel=5e-3)
