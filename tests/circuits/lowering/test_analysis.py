"""Closed forms: device equations as text."""

from __future__ import annotations

import pytest

from circuits.devices import DEVICE_TYPES, Transistor
from circuits.lowering.analysis import to_equation
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


@pytest.mark.parametrize("device", DEVICE_TYPES, ids=lambda d: d.__name__)
def test_every_device_type_has_an_equation(device: type) -> None:
    assert device in to_equation.registry


def test_a_transistor_s_equation_has_its_numbers() -> None:
    device = Transistor("m", "n", "d", "g", "s", "0", 3e-6, 1.5e-6)
    # 2 mu Cox U_T^2 / kappa * W/L with U_T = 25.865 mV
    assert "2.752e-07" in to_equation(device, Silicon(AMI_1500_IDEAL))
    assert "0.7 ((v_g - v_b) - 0.6)" in to_equation(device, Silicon(AMI_1500_IDEAL))
