"""The ranging chip: 13 neurons as one array, each tuned to its own delay."""

from __future__ import annotations

import numpy as np
import pytest

from chips.ranging import circuit as ranging_chip
from circuits.lowering.check import check_circuit
from circuits.lowering.flatten import flatten
from circuits.solver.transient import simulate


@pytest.fixture(scope="module")
def stimuli() -> dict[str, float | None]:
    return ranging_chip.CHIP.defaults


def test_the_chip_is_one_array_of_neurons() -> None:
    chip = ranging_chip.build()
    check_circuit(chip)
    flat = flatten(chip)
    # 34 transistors and 6 capacitors a neuron
    assert len(flat.groups) == 40
    assert all(group.nodes.shape[1] == ranging_chip.NEURONS for group in flat.groups)


def test_the_neuron_of_the_delay_fires(stimuli: dict[str, float | None]) -> None:
    chip = ranging_chip.build()
    bench = ranging_chip.testbench(chip, {**stimuli, "delay": 6.4e-3, "duration": 12e-3}, 5.0)
    result = simulate(bench, record=("spike[0]",))
    fired = [k for k in range(ranging_chip.NEURONS) if result.spikes[f"spike[{k}]"].size]
    assert fired == [2]


def test_currents_fall_with_the_best_delay_and_the_papers_are_linear_in_the_index() -> None:
    assert np.all(np.diff(ranging_chip.I_INH_TAU) < 0)
    assert np.all(np.diff(ranging_chip.BEST_DELAYS) > 0)
    assert np.ptp(np.diff(ranging_chip.linear_currents())) < 1e-24


def test_neuron_biases_are_the_chip_s() -> None:
    biases = ranging_chip.neuron_biases(ranging_chip.build(), 12)
    assert biases["i_inh_tau"] == pytest.approx(40.1e-12)
    assert biases["v_rest"] == 1.8
