"""Linearity of the axonal delay over its 31 codes, and the metrics that studies take from it."""

import math

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront.axon_linearity import (
    CODES,
    DELAY,
    INL,
    UNIT_DELAY,
    Linearity,
    delay_at,
    delay_machine,
    linearity,
)
from circuits.circuit import BiasKind
from circuits.errors import SolverError
from circuits.lowering.kernel import on_die
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

CIRCUIT = axon_delay.build()


@pytest.mark.parametrize(("temperature", "kind"), [(27.0, "gate"), (-10.0, "gate"), (65.0, "ideal")])
def test_the_delay_is_monotone_and_straight_within_a_thousandth(temperature: float, kind: BiasKind) -> None:
    found = linearity(
        delay_machine(rebias(CIRCUIT, kind=kind), Silicon(AMI_1500_IDEAL, temperature_c=temperature))
    )
    assert found.reason == ""
    assert (np.diff(found.delays) > 0.99 * found.unit).all()
    # 1 % is asked for; the comparator's delay bends it by 0.04 % at most
    assert found.non_linearity < 1e-3
    assert abs(found.offset) < 0.03 * found.unit


def test_the_nominal_unit_is_100_us() -> None:
    found = linearity(delay_machine(CIRCUIT, Silicon(AMI_1500_IDEAL)))
    assert found.unit == pytest.approx(100e-6, rel=1e-3)
    assert abs(found.offset) < 0.2e-6
    assert DELAY.value is not None
    assert DELAY.value(found) == pytest.approx(1.6e-3, rel=1e-3)


def test_a_line_has_no_non_linearity_and_a_kink_has() -> None:
    line = 2.0 + 3.0 * np.array(CODES)
    assert Linearity(line).non_linearity == pytest.approx(0.0, abs=1e-12)
    assert (Linearity(line).unit, Linearity(line).offset) == pytest.approx((3.0, 2.0))
    line[15] += 1.0
    assert Linearity(line).non_linearity == pytest.approx(1.0 / 95.0, rel=0.05)  # D(31) is 95


def test_the_die_moves_the_unit() -> None:
    machine = on_die(delay_machine(CIRCUIT, Silicon(AMI_1500_IDEAL)), Die(number=7, process=False))
    found = linearity(machine)
    assert UNIT_DELAY.value is not None
    assert INL.value is not None
    assert abs(UNIT_DELAY.value(found) / 100e-6 - 1.0) > 1e-3
    assert INL.value(found) < 1e-3


def test_a_delay_beyond_all_patience_is_told() -> None:
    silent = rebias(CIRCUIT, {"i_delay": 1e-14})
    machine = delay_machine(silent, Silicon(AMI_1500_IDEAL, temperature_c=-10.0))
    with pytest.raises(SolverError, match="no step within 10 s; raise i_delay"):
        delay_at(machine, 31)
    found = linearity(machine)
    assert "raise i_delay" in found.reason
    assert math.isnan(found.delays[0])
