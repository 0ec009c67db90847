"""Shares of shot noise and flicker in moderate inversion, against the law's own noise."""

import numpy as np
import pytest
from scipy.integrate import quad

from chips.noise import SiliconNoise
from chips.shot_noise import current_wander, gate_wander, shot_share, steepness
from circuits.devices.noise import WHITE_ONLY
from circuits.silicon.silicon import Silicon


@pytest.mark.parametrize("root", [1e-3, 0.049, 0.051, 0.7, 3.0, 20.0])
def test_the_share_is_the_integral_of_the_laws_noise(root):
    """S = 4 k T G with G of `circuits.devices.noise`, over 2 q I, at L_r = 0."""
    mean = quad(lambda t: (root * t) ** 2 * -np.expm1(-root * t), 0.0, 1.0)[0]
    assert shot_share(root**2, 1.0) == pytest.approx(4.0 * mean / root**3, rel=1e-5)


def test_steepness_is_the_slope_of_the_law():
    u, step = np.array([-8.0, 0.0, 6.0]), 1e-5
    law = lambda v: np.log1p(np.exp(0.5 * v)) ** 2  # noqa: E731 - F of the transistor law
    slope = (np.log(law(u + step)) - np.log(law(u - step))) / (2.0 * step)
    assert steepness(law(u), 1.0) == pytest.approx(slope, rel=1e-6)


def test_wander_falls_with_area_and_is_none_without_flicker():
    silicon = Silicon()
    small, large = (gate_wander(silicon, SiliconNoise(), "p", a, 3e-3) for a in (1e-10, 4e-10))
    assert small == pytest.approx(4.0 * large)
    assert gate_wander(silicon, SiliconNoise(), "n", 1e-10, 3e-3) > 10.0 * small  # K_F of nFETs is 20 times
    assert gate_wander(silicon, SiliconNoise(flicker=WHITE_ONLY), "p", 1e-10, 3e-3) == 0.0
    slope = silicon.law("p").kappa / silicon.thermal_voltage
    assert current_wander(silicon, SiliconNoise(), "p", 1e-10, 3e-3, 0.5) == pytest.approx(
        (0.5 * slope) ** 2 * small
    )
