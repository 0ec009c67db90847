"""Parts stand at their places, and their lines are the chip's."""

import pytest

from chips.lso_measurement import circuits
from chips.lso_place import area_of, line_volts, square_of
from circuits.die import Die
from circuits.errors import ParameterError
from circuits.silicon import Silicon


def test_every_bias_port_has_a_line() -> None:
    lines = line_volts(Silicon(), "gate")
    ports = {p.name for c in circuits() for p in c.ports if p.kind == "bias"}
    assert set(lines) == ports - {"v_threshold"}


def test_a_fixed_gate_knows_no_die_and_a_generator_does() -> None:
    die = Silicon(die=Die(number=4))
    assert line_volts(die, "gate") == line_volts(Silicon(), "gate")
    assert line_volts(die, "generator")["v_exc"] != line_volts(Silicon(), "generator")["v_exc"]


def test_sizes_are_the_circuits() -> None:
    lso = circuits()[0]
    assert area_of(lso, "excite3.me") == pytest.approx(6e-6 * 24e-6)
    assert square_of(lso, "md") == pytest.approx(1.0)
    with pytest.raises(ParameterError, match=r"sonar_head\.cell\.cm: must be a transistor"):
        area_of(lso, "cell.cm")
