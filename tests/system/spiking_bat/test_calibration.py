"""The latency chip of a die, calibrated: its times come to those of the design."""

from __future__ import annotations

import numpy as np

from chips.codes import Codes
from chips.latency.calibration import Sized, biases_of, calibrate, designed
from chips.latency.model import lumped
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.openspace.law import Bat, arcs_of
from system.spiking_bat.chip_brain import CALIBRATION, design_of
from system.spiking_bat.numbers import Numbers

SILICON = Silicon(AMI_1500, die=Die(number=1003))
SETUP = Sized(design_of(arcs_of(Bat()), Numbers()))


def _off(codes: Codes, which: str, when: str) -> float:
    """Root mean square of the logarithm of time over what is wanted."""
    found = [np.log(getattr(m, when) / m.wanted) for m in codes.measured if m.name.startswith(which)]
    return float(np.sqrt(np.mean(np.square(found))))


def test_times_of_a_die_come_to_the_design() -> None:
    codes = calibrate(SILICON, "generator", SETUP)
    assert codes.failed == ""
    for which in ("tap", "integrating", "race"):
        assert _off(codes, which, "before") > 0.1
        assert _off(codes, which, "after") < 0.04
    # what the codes say is what the chip has
    chip = lumped(SETUP.design, biases_of(codes, SETUP.design, AMI_1500), SILICON)
    assert [m.after for m in codes.measured if m.name.startswith("tap")] == chip.tap.tolist()


def test_the_setup_is_that_of_a_usual_run() -> None:
    assert CALIBRATION.setup == SETUP


def test_the_design_is_reached_by_the_chip_that_it_was_made_for() -> None:
    """Under the ideal law nothing is off: the hop of a tap is what the design states, to a percent."""
    wanted = designed(SETUP.design, AMI_1500)
    assert np.allclose(wanted.tap[1:], SETUP.design.hop, rtol=0.01)
