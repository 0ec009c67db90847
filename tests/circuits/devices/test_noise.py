"""Densities of noise: shot in weak inversion, 4 k T g at rest, two thirds in strong inversion."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.devices import noise
from circuits.devices.transistor import drain_currents, transistor_arrays, transistor_work
from circuits.errors import ParameterError
from circuits.silicon.process import (
    AMI_1500_IDEAL,
    BOLTZMANN,
    ELEMENTARY_CHARGE,
    PROCESSES,
    at_temperature,
    kelvin,
)

GATES = np.array([0.3, 0.5, 0.6, 0.8, 1.0, 2.0, 5.0])


def _channels(drain: float, temperature_c: float = 27.0, leakage: float = 0.0):  # type: ignore[no-untyped-def]
    """Arrays, law and white densities of square nFETs at GATES, source and bulk at ground."""
    model = replace(AMI_1500_IDEAL.n, junction_leakage=leakage)
    law = at_temperature(model, AMI_1500_IDEAL, temperature_c)
    n = GATES.size
    terminal = np.stack([np.full(n, n), np.arange(n), np.full(n, n + 1), np.full(n, n + 1)]).astype(np.int32)
    side = np.full(n, 3e-6)
    a, w = transistor_arrays(terminal, "n", law, side, side, np.ones(n)), transistor_work(n)
    v = np.array([*GATES, drain, 0.0])
    drain_currents(a, v, w)
    out = np.zeros(n)
    noise.channel_noise(a, w, out)
    return a, w, out


@pytest.mark.parametrize("temperature_c", [-40.0, 27.0, 125.0])
def test_without_a_current_the_channel_makes_the_noise_of_its_conductance(temperature_c: float) -> None:
    _, w, white = _channels(0.0, temperature_c)
    # Nyquist's theorem holds for the law itself: both sides are the same function of u, up to rounding
    np.testing.assert_allclose(white, 4.0 * BOLTZMANN * kelvin(temperature_c) * w.conductance[0], rtol=1e-9)


def test_weak_inversion_is_shot_noise_of_both_components() -> None:
    for drain in (5.0, 0.02):
        a, w, white = _channels(drain)
        forward, reverse = (a.specific_current * w.value[s] ** 2 for s in (slice(7), slice(7, None)))
        # at 0.3 V the channel is 8 U_T below threshold; the next term of the law is e^-4 of it over three
        assert white[0] == pytest.approx(2.0 * ELEMENTARY_CHARGE * (forward + reverse)[0], rel=0.02)


def test_strong_inversion_is_two_thirds_of_the_source_conductance() -> None:
    _, w, white = _channels(5.0)
    ratio = white / (4.0 * BOLTZMANN * kelvin(27.0) * -w.conductance[2])
    # one half in weak inversion, two thirds in strong, and nothing but a rise between them
    assert (np.diff(ratio) > 0.0).all()
    assert ratio[0] == pytest.approx(0.5, rel=0.02)
    assert ratio[-1] == pytest.approx(2.0 / 3.0, rel=0.02)


def test_the_mean_over_the_channel_is_converged() -> None:
    a, w, white = _channels(0.1)
    share = (np.arange(20000) + 0.5) / 20000
    for k in range(GATES.size):
        f, r = w.value[k], w.value[GATES.size + k]
        x = r + (f - r) * share
        mean = 2.0 / (f + r) * np.mean(x**2 * -np.expm1(-x))
        # the midpoint rule of 20,000 points is good to 1e-8 here, the kernel's eight nodes to 1e-6
        assert white[k] == pytest.approx(4.0 * ELEMENTARY_CHARGE * a.specific_current[k] * mean, rel=2e-6)


def test_a_junction_makes_shot_noise_of_its_leakage() -> None:
    a, w, _ = _channels(3.0, leakage=1e-9)
    shot = np.zeros((2, a.sign.size))
    noise.junction_noise(a, w, shot.reshape(-1))
    drain, source = shot
    # reverse biased by 116 U_T only the leakage flows; at 0 V both components do
    np.testing.assert_allclose(drain, 2.0 * ELEMENTARY_CHARGE * a.leakage, rtol=1e-9)
    np.testing.assert_allclose(source, 4.0 * ELEMENTARY_CHARGE * a.leakage, rtol=1e-9)


def test_flicker_falls_with_area_and_follows_the_polarity() -> None:
    model = noise.noise_model(AMI_1500_IDEAL)
    found = noise.gate_flicker(
        model, AMI_1500_IDEAL, np.array([True, True, False]), np.array([9e-12, 36e-12, 9e-12])
    )
    assert found[0] == pytest.approx(4.0 * found[1])
    assert found[0] / found[2] == pytest.approx(model.flicker_n / model.flicker_p)
    assert found[0] == pytest.approx(model.flicker_n / AMI_1500_IDEAL.n.oxide_capacitance / 9e-12)


def test_every_process_has_its_flicker_and_another_name_the_usual_one() -> None:
    assert set(noise.NOISE_MODELS) == set(PROCESSES)
    assert noise.noise_model(replace(AMI_1500_IDEAL, name="mine")) == noise.noise_model(AMI_1500_IDEAL)


def test_a_resistor() -> None:
    # 4 k T / R of 1 kOhm at 300 K: 1.657e-23 A^2/Hz
    assert noise.resistor_noise(np.array([1e3]), 300.0)[0] == pytest.approx(1.6568e-23, rel=1e-4)


@pytest.mark.parametrize("wrong", [(-1e-25, 0.0), (1e-25, 1e-10), (float("nan"), 0.0)])
def test_a_wrong_coefficient_is_refused(wrong: tuple[float, float]) -> None:
    with pytest.raises(ParameterError, match="must be 0 to 1e-18"):
        noise.NoiseModel(*wrong)
    with pytest.raises(ParameterError, match="exponent: 2"):
        noise.NoiseModel(0.0, 0.0, 2.0)
