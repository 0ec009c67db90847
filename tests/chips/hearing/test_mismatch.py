"""Deviations of the hearing's devices are the die's own, and move the model's thresholds as the circuits'."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from chips.hearing.mismatch import DEVICES, PARAMETERS, deviations
from chips.hearing.mismatch_measure import Deviating, rest_margin, threshold
from chips.hearing.model import Deafened, hearing_on, rest_margin_on
from chips.record import kept_record
from circuits.blocks.sonar import onset_neuron
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

ONE_DIE = Silicon(AMI_1500_IDEAL, die=Die(number=1000, process=False))
SILENT = Silicon(
    AMI_1500_IDEAL, die=Die(number=1004, process=False)
)  # of dies A/1000 on the first whose onset neuron is


def test_the_nominal_die_has_no_deviation() -> None:
    assert not deviations(Silicon(AMI_1500_IDEAL)).any()
    assert deviations(ONE_DIE).size == len(PARAMETERS) == 2 * sum(map(len, DEVICES.values()))


def test_the_deviations_are_those_of_the_lowered_circuit() -> None:
    circuit = onset_neuron.build()
    stimuli = onset_neuron.BLOCK.defaults
    bench = onset_neuron.BLOCK.testbench(circuit, stimuli, 5.0)
    ours, nominal = (to_kernel(bench, s).kernel.transistors for s in (ONE_DIE, Silicon(AMI_1500_IDEAL)))
    found = dict(zip(PARAMETERS, deviations(ONE_DIE), strict=True))
    shifts = np.abs(ours.v_t0 - nominal.v_t0)
    ratios = np.log(ours.specific_current / nominal.specific_current)
    for device in DEVICES["onset_neuron"]:
        k = np.argmin(np.abs(shifts - abs(found[f"onset_neuron/{device}.v_t0"])))
        assert shifts[k] == pytest.approx(abs(found[f"onset_neuron/{device}.v_t0"]), abs=1e-12)
        assert ratios[k] == pytest.approx(found[f"onset_neuron/{device}.beta"], abs=1e-12)


@pytest.mark.parametrize(
    ("name", "neuron"), [("onset", "onset_neuron"), ("high_threshold", "high_threshold_neuron")]
)
def test_a_threshold_moves_with_the_die(name: str, neuron: str) -> None:
    exact = threshold(Deviating(ONE_DIE), neuron)
    model, nominal = (getattr(hearing_on(s), name).threshold for s in (ONE_DIE, Silicon(AMI_1500_IDEAL)))
    error = kept_record("hearing").errors[f"{name}_threshold_max"]
    assert abs(math.log(model / exact)) < error + 1e-3  # a bisection's share
    assert abs(math.log(nominal / model)) > 1e-4


def test_a_die_that_is_silent_at_rest_is_told_with_its_path() -> None:
    assert rest_margin(Deviating(SILENT)) == pytest.approx(rest_margin_on(SILENT), abs=2e-3)
    assert rest_margin_on(SILENT) < 0.0
    assert threshold(Deviating(SILENT), "onset_neuron") == math.inf
    with pytest.warns(Deafened, match=r"board/hearing\.onset: rest margin .* use the transistor level"):
        hearing_on(SILENT, "board/hearing")


def test_a_die_that_hears_is_not_warned_of() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for silicon in (Silicon(AMI_1500_IDEAL), ONE_DIE):
            assert rest_margin(Deviating(silicon)) == pytest.approx(rest_margin_on(silicon), abs=2e-3)
            hearing_on(silicon)
