"""Draws of a chip's noise: their moments, their keys, and the density of slow processes."""

import numpy as np
import pytest

from chips.noise_draw import bring, draw, new_draws, new_slow, octave_weight
from circuits.devices.noise import WHITE_ONLY, NoiseModel

ONE = NoiseModel(1e-24, 1e-24)


def test_draws_have_the_normals_moments():
    t = new_draws(1, 0, "a place", 256)
    found = []
    for number in range(400):
        draw(t, number, 0)
        found.append(t.normal.copy())
    x = np.concatenate(found).astype(np.float64)
    # 102,400 draws: 0.3 % of the mean, 0.4 % of the variance, 0.8 % of the third moment are one deviation
    assert abs(x.mean()) < 0.013
    assert x.var() == pytest.approx(1.0, abs=0.018)
    assert abs((x**3).mean()) < 0.03
    # four bytes: 3 - 6 / (5 * 4)
    assert (x**4).mean() == pytest.approx(2.7, abs=0.06)
    lag = np.concatenate(found[1:]) * np.concatenate(found[:-1])
    assert abs(lag.mean()) < 0.013


def test_places_of_a_draw_are_their_own():
    few, many = new_draws(1, 0, "a place", 6), new_draws(1, 0, "a place", 8)
    for d in (few, many):
        draw(d, 5, 2)
    assert (few.normal == many.normal).all()
    for other in (new_draws(2, 0, "a place", 8), new_draws(1, 1, "a place", 8), new_draws(1, 0, "b", 8)):
        draw(other, 5, 2)
        assert (other.normal != many.normal).any()
    before = many.normal.copy()
    draw(many, 5 + 2**32, 2)
    assert (many.normal != before).any()


def test_flickers_octaves_have_its_density():
    """Values held for T have the density `2 s^2 T sinc^2(f T)`; their sum is K / f."""
    assert octave_weight(1.0) == pytest.approx(np.log(2.0), rel=1e-12)
    times = 1e-3 * 2.0 ** np.arange(14)
    for exponent in (0.8, 1.0, 1.2):
        s2 = octave_weight(exponent) * times ** (exponent - 1.0)
        f = np.geomspace(1.0, 10.0, 60)
        density = (2.0 * s2[:, None] * times[:, None] * np.sinc(f * times[:, None]) ** 2).sum(axis=0)
        # the sum over octaves ripples, ends of the band take off some per cent
        assert (density * f**exponent).mean() == pytest.approx(1.0, abs=0.06)


def test_slow_processes_are_those_of_their_step():
    d = new_draws(1, 0, "a place", 64)
    whole, late = (new_slow(np.array([1e-8, 4e-8]), ONE, 1e-3, 64) for _ in range(2))
    found = []
    for number in range(4096):
        bring(whole, d, number)
        if number % 64 == 0:
            found.append(whole.value.copy())
    bring(late, d, 4095)
    assert (late.value == whole.value).all()
    # 10 octaves of ln 2 K each; the fast ones are seen 64 times, the slow ones once at 64 places
    deviation = np.array(found).std(axis=(0, 2))
    expected = np.sqrt(whole.deviation.shape[1] * np.log(2.0) * np.array([1e-8, 4e-8]))
    assert whole.deviation.shape[1] == 11
    assert deviation == pytest.approx(expected, rel=0.15)
    assert new_slow(np.array([1e-8]), WHITE_ONLY, 1e-3, 64).deviation.shape == (1, 0)
