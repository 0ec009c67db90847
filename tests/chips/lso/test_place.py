"""Parts stand at their places, and their lines are the chip's."""

import numpy as np
import pytest

from chips.lso.measure import circuits
from chips.lso.place import line_volts
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


def test_every_bias_port_has_a_line() -> None:
    lines = line_volts(Silicon(AMI_1500_IDEAL), "gate")
    ports = {p.name for c in circuits() for p in c.ports if p.kind == "bias"}
    assert set(lines) == ports - {"v_threshold"}


def test_a_fixed_gate_knows_no_die_and_a_generator_does() -> None:
    die = Silicon(AMI_1500_IDEAL, die=Die(number=4))
    assert line_volts(die, "gate") == line_volts(Silicon(AMI_1500_IDEAL), "gate")
    assert line_volts(die, "ideal")["v_exc"] != line_volts(Silicon(AMI_1500_IDEAL), "ideal")["v_exc"]


def test_small_devices_deviate_more_and_share_the_die() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=4))
    small = silicon.of_area(0.25)
    path = (("md", ()),)
    plain, more = (float(np.ravel(s.deviation("x", path, 1e-12).v_t0)[0]) for s in (silicon, small))
    assert more == pytest.approx(2.0 * plain)
    assert small.law("n") == silicon.law("n")
    assert line_volts(small, "gate") == line_volts(silicon, "gate")
