"""The sonar head's chip of a die, calibrated: spikes a decibel come to the design's, and its sides agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.codes import Codes
from chips.lso.calibration import Design, calibrate, currents_of, designed
from chips.lso.model import head_on
from chips.validity import OutsideBoxError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.head.scenario import CALIBRATION, Scenario, design_of

SILICON = Silicon(AMI_1500, die=Die(number=104))
DESIGN = design_of(Scenario().head)


@pytest.fixture(scope="module")
def codes() -> Codes:
    return calibrate(SILICON, "generator", DESIGN)


def test_step_and_slope_come_to_the_design(codes: Codes) -> None:
    step, slope, *even = codes.measured
    assert codes.failed == ""
    # a step is told by whole spikes, a slope by whole spikes of 91 bursts a neuron
    assert abs(step.after / step.wanted - 1.0) < 0.05 < abs(step.before / step.wanted - 1.0)
    assert abs(slope.after / slope.wanted - 1.0) < 0.08 < abs(slope.before / slope.wanted - 1.0)
    assert np.mean([m.after for m in even]) == pytest.approx(0.0, abs=1e-12)
    assert [m.name for m in even] == [f"even[{3 * k}dB]" for k in range(-3, 4)]


def test_the_chip_has_the_currents_of_its_codes(codes: Codes) -> None:
    usual, own = head_on(SILICON), head_on(SILICON, currents=currents_of(codes))
    longer = codes.measured[0].after / codes.measured[0].before
    assert own.excite_step.mean() / usual.excite_step.mean() == pytest.approx(longer, rel=0.05)
    # the same lines: what tells inhibition from excitation stays
    assert own.inhibit / own.excite == pytest.approx(usual.inhibit / usual.excite, rel=0.01)


def test_the_design_is_the_nominal_chip_of_the_ideal_law() -> None:
    wanted = designed(SILICON, DESIGN)
    assert wanted.balance == 0.0
    assert not wanted.deaf.any()
    nominal = head_on(Silicon(SILICON.process.under("ideal")), "gate")
    # told by whole spikes of some 23
    assert wanted.step == pytest.approx(float(nominal.excite_step.mean()), rel=1.0 / 23.0)


def test_deaf_level_units_are_told() -> None:
    found = calibrate(SILICON, "generator", Design((10e-3, *DESIGN.thresholds[1:])))
    assert [text for text in found.unmended if "level unit 0" in text]


def test_a_chip_outside_of_its_record_is_refused_and_none_that_failed() -> None:
    hot = replace(SILICON, temperature_c=120.0)
    with pytest.raises(OutsideBoxError, match="120 degC, must be -10 to 65 degC"):
        calibrate(hot, "generator", DESIGN)


def test_it_is_calibrated_for_the_usual_head() -> None:
    assert CALIBRATION.setup == DESIGN
