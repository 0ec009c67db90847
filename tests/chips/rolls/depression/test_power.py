"""Power of the cells of depression: the step's current flows in each, an event costs switches and a step."""

from __future__ import annotations

import pytest

from chips.rolls.depression.power import depression_energies
from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.program.bias_file import default_biases
from circuits.blocks.rolls.depressing_synapse import STEP
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

TABLE = default_biases().with_code(STEP_BIAS, *STEP)
PULSE = 20.8e-6  # s, of the nominal extender
WARM = 47.0


def test_a_cell_takes_its_step_s_current_and_an_event_its_step() -> None:
    on, off = (
        depression_energies(ShortTermDepression(), t, Silicon(ROLLS_180_IDEAL))
        for t in (TABLE, default_biases())
    )
    three = 3.0 * TABLE.current(STEP_BIAS) * ROLLS_180_IDEAL.v_dd
    # a mirror in weak inversion: 0.1 % seen
    assert on.rest - off.rest == pytest.approx(three, rel=0.01)
    # without the step leaks are left, and the gates of the switches: six of 0.5 um^2 with 4 fF each
    assert 0.0 < off.rest < 0.03 * on.rest
    assert 20e-15 < off.event < 100e-15
    # what the recovery gives back to the bias is not lost
    assert 0.0 < on.event - off.event < three * PULSE
    assert on.power(1e6) == pytest.approx(65536 * on.rest + 1e6 * on.event)


def test_a_generator_s_current_grows_with_temperature() -> None:
    warm, usual = (
        depression_energies(ShortTermDepression(), TABLE, Silicon(ROLLS_180_IDEAL, celsius), "ideal").rest
        for celsius in (WARM, 27.0)
    )
    # PTAT, and leaks; fixed gates would be 2.3
    assert warm / usual == pytest.approx((WARM + 273.15) / 300.15, rel=0.05)
