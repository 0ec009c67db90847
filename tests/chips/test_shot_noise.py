"""Shares of shot noise and flicker in moderate inversion, against the law's own noise."""

import numpy as np
import pytest
from scipy.integrate import quad

from chips.noise import SiliconNoise
from chips.shot_noise import current_wander, gate_wander, shot_share, steepness, steepness_under
from circuits.blocks.mos import mos
from circuits.circuit import Circuit, Port
from circuits.devices.noise import WHITE_ONLY
from circuits.lowering.on_die import on_die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
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


@pytest.mark.parametrize("polarity", ["n", "p"])
def test_under_the_full_law_steepness_is_the_slope_of_a_device(polarity):
    """Of a device of the full law, against its ideal one, of which it is `steepness` to the bit."""
    circuit = Circuit("one", (Port("g", "bias"),), (mos("m", polarity, "d", "g", "s", 6, 24),))
    device = on_die(circuit, Silicon(AMI_1500))
    law, specific = device.fet["m"].law, device.fet["m"].current
    gates = np.array([0.5, 0.7, 0.9, 1.1])
    slope = np.log(device.saturated("m", gates + 1e-4) / device.saturated("m", gates - 1e-4)) / 2e-4
    # of the current without mobility reduction, which moves psi by up to 2 %
    found = steepness_under(law, device.saturated("m", gates), specific) * law.kappa / law.u_t
    assert found == pytest.approx(slope, rel=0.02)
    plain = steepness(device.saturated("m", gates), specific) * law.kappa / law.u_t
    assert np.abs(plain / found - 1.0).max() > 0.02
    ideal = Silicon(AMI_1500_IDEAL).law(polarity)
    assert np.array_equal(steepness_under(ideal, gates * 1e-9, 1e-9), steepness(gates * 1e-9, 1e-9))


def test_wander_falls_with_area_and_is_none_without_flicker():
    silicon = Silicon(AMI_1500_IDEAL)
    small, large = (gate_wander(silicon, SiliconNoise(), "p", a, 3e-3) for a in (1e-10, 4e-10))
    assert small == pytest.approx(4.0 * large)
    assert gate_wander(silicon, SiliconNoise(), "n", 1e-10, 3e-3) > 10.0 * small  # K_F of nFETs is 20 times
    assert gate_wander(silicon, SiliconNoise(flicker=WHITE_ONLY), "p", 1e-10, 3e-3) == 0.0
    slope = silicon.law("p").kappa / silicon.thermal_voltage
    assert current_wander(silicon, SiliconNoise(), "p", 1e-10, 3e-3, 0.5) == pytest.approx(
        (0.5 * slope) ** 2 * small
    )
