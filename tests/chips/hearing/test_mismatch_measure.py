"""What mismatch does to the hearing, as the record has it, is what the circuits do."""

from __future__ import annotations

import numpy as np
import pytest

from chips.hearing import mismatch_measure as m
from chips.hearing.mismatch import PARAMETERS
from chips.measured.table_record import TEMPERATURES
from chips.record import kept_record
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

WARM = TEMPERATURES.index(27.0)


@pytest.mark.parametrize("device", ["mt", "generator.comparator.mc6"])
def test_a_gradient_of_the_rest_margin_is_the_central_difference(device: str) -> None:
    parameter, h = f"onset_neuron/{device}.v_t0", 2e-3
    low, high = (m.rest_margin(m.Deviating(Silicon(AMI_1500_IDEAL), parameter, s * h)) for s in (-1.0, 1.0))
    gradient = kept_record("hearing")["onset_rest_margin_gradient"][WARM, PARAMETERS.index(parameter)]
    # the bisection's 20 uV on each side
    assert (high - low) / (2.0 * h) == pytest.approx(gradient, abs=0.03)
    assert abs(gradient) > 0.5


def test_a_gradient_of_a_threshold_is_the_central_difference() -> None:
    parameter, h = "onset_neuron/generator.comparator.mc1.v_t0", 3e-3
    low, high = (
        m.threshold(m.Deviating(Silicon(AMI_1500_IDEAL), parameter, s * h), "onset_neuron", (0.03, 0.05))
        for s in (-1.0, 1.0)
    )
    gradient = kept_record("hearing")["onset_threshold_gradient"][WARM, PARAMETERS.index(parameter)]
    assert np.log(high / low) / (2.0 * h) == pytest.approx(gradient, rel=0.02)  # its curvature


def test_what_a_neuron_does_not_contain_does_not_move_it() -> None:
    data = kept_record("hearing")
    for name, other in (
        ("onset_threshold", "high_threshold_neuron/"),
        ("high_threshold_threshold", "onset_neuron/"),
        ("onset_rest_margin", "envelope_detector/"),
    ):
        columns = [k for k, p in enumerate(PARAMETERS) if p.startswith(other)]
        assert not data[f"{name}_gradient"][:, columns].any()
        assert data[f"{name}_gradient"].any()


def test_a_deviation_moves_only_the_circuit_that_has_the_device() -> None:
    silent = m.Deviating(
        Silicon(AMI_1500_IDEAL), "high_threshold_neuron/generator.comparator.mc1.v_t0", 50e-3
    )
    assert m.rest_margin(silent) == m.rest_margin(m.Deviating(Silicon(AMI_1500_IDEAL)))
