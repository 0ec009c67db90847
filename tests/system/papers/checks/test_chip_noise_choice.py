"""Noise of the selection beside that of transistors: short runs; and the isolation's, which is negligible."""

import pytest

from circuits.silicon.process import BOLTZMANN, kelvin
from system.papers.checks.chip_noise_choice import _isolation, isolation_rows, level_wander, selection_beside


def test_a_selection_beside_its_transistors() -> None:
    found = selection_beside(0.1, 0.1e-6, 12)
    assert found.count == 12
    assert found.mean == pytest.approx(10.8e-6, rel=0.02)
    assert found.model == pytest.approx(51.6e-9, rel=0.05)  # the linear theory of the circuit
    assert found.ratio == pytest.approx(1.0, abs=3.0 * found.known + 0.05)  # 12 trials know 20 %


def test_the_isolations_noise_is_far_below_its_models_error() -> None:
    made = isolation_rows()
    assert [row.agrees for row in made] == [True] * 3
    assert all(0.0 < row.shown < 0.01 for row in made)


def test_the_mean_of_a_level_is_white_noise_over_twice_the_time() -> None:
    """`sqrt(4 k T R / 2 T)` for the gate's R at its bias, some hundred ohm to some kiloohm, and T = 10 us."""
    found = level_wander(_isolation())
    resistance = found**2 * 2.0 * 10e-6 / (4.0 * BOLTZMANN * kelvin(27.0))
    assert 100.0 < resistance < 5e3
