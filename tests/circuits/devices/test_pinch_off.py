"""The pinch-off voltage is the one of the solver's law: a device whose source is there carries F(0) I_S."""

import math

import numpy as np
import pytest

from circuits.devices.pinch_off import pinch_off
from circuits.devices.transistor import drain_current
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


@pytest.mark.parametrize("gate", [0.3, 0.7, 2.0])
def test_a_source_at_pinch_off_takes_the_square_of_ln_2(gate: float) -> None:
    law = Silicon(AMI_1500_IDEAL).law("n")
    source = pinch_off(law.kappa, gate, law.v_t0)
    found = drain_current(law, "n", 3e-6, 3e-6, source + 3.0, gate, source)
    # the solver's law is within 1e-9 of the closed form, and the drain 3 V up takes none of it
    assert float(found.item()) == pytest.approx(law.square_current * math.log(2.0) ** 2, rel=1e-8)


def test_arrays_broadcast_and_kappa_may_be_over_the_thermal_voltage() -> None:
    found = pinch_off(np.array([[0.5], [0.25]]), np.array([1.0, 2.0, 3.0]), 0.5)
    assert found.tolist() == [[0.25, 0.75, 1.25], [0.125, 0.375, 0.625]]
    assert pinch_off(0.5 / 0.025, 1.0, 0.5) == pytest.approx(0.25 / 0.025)
