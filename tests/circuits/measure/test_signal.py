"""Waveforms between their points: exact for parabolas, straight where a stimulus bends."""

import math

import numpy as np
import pytest

from circuits.measure.signal import Signal, crossings, extreme, integral, slope_at, value_at

T = np.array([0.0, 0.1, 0.4, 0.5, 1.1, 1.5, 2.0])
NO_KINK = np.zeros(T.size, np.bool_)
PARABOLA = Signal(T, 3.0 * T**2 - 4.0 * T + 1.0, NO_KINK)  # 0 at 1/3 and 1, least -1/3 at 2/3


def test_a_parabola_is_itself_between_its_points() -> None:
    for place in (0.15, 0.6, 1.3, 1.99):  # the first piece has no point before it
        assert value_at(PARABOLA, place) == pytest.approx(3.0 * place**2 - 4.0 * place + 1.0, abs=1e-12)
        assert slope_at(PARABOLA, place) == pytest.approx(6.0 * place - 4.0, abs=1e-11)


def test_crossings_are_the_roots() -> None:
    np.testing.assert_allclose(crossings(PARABOLA, 0.0, "fall", 0.0, 2.0), [1.0 / 3.0], atol=1e-14)
    np.testing.assert_allclose(crossings(PARABOLA, 0.0, "rise", 0.0, 2.0), [1.0], atol=1e-14)
    np.testing.assert_allclose(crossings(PARABOLA, 0.0, "either", 0.5, 2.0), [1.0], atol=1e-14)
    assert crossings(PARABOLA, -1.0, "either", 0.0, 2.0).size == 0


def test_extremes_are_vertices_or_ends() -> None:
    place, value = extreme(PARABOLA, 0.0, 2.0, -1.0)
    assert (place, value) == (pytest.approx(2.0 / 3.0), pytest.approx(-1.0 / 3.0))
    assert extreme(PARABOLA, 0.0, 2.0, 1.0) == (2.0, 5.0)
    assert extreme(PARABOLA, 1.2, 1.4, -1.0)[0] == 1.2


@pytest.mark.parametrize(("low", "high"), [(0.1, 2.0), (0.45, 0.47), (0.2, 1.77)])
def test_integrals_are_exact(low: float, high: float) -> None:
    def whole(t: float) -> float:
        return t**3 - 2.0 * t**2 + t

    def square(t: float) -> float:
        return 9.0 * t**5 / 5.0 - 6.0 * t**4 + 22.0 * t**3 / 3.0 - 4.0 * t**2 + t

    assert integral(PARABOLA, low, high) == pytest.approx(whole(high) - whole(low), abs=1e-13)
    assert integral(PARABOLA, low, high, power=2) == pytest.approx(square(high) - square(low), abs=1e-12)


def test_a_kink_has_a_straight_line_behind_it() -> None:
    kink = NO_KINK.copy()
    kink[3] = True
    bent = Signal(T, np.where(T < 0.5, 0.0, T - 0.5), kink)
    assert value_at(bent, 0.8) == pytest.approx(0.3)
    assert value_at(Signal(T, bent.value, NO_KINK), 0.8) != pytest.approx(0.3)


def test_noise_of_a_sampled_sine_is_third_order() -> None:
    errors = []
    for count in (100, 200):
        t = np.linspace(0.0, 2.0 * math.pi, count + 1)
        sine = Signal(t, np.sin(t), np.zeros(t.size, np.bool_))
        errors.append(abs(float(crossings(sine, 0.5, "rise", 0.0, 7.0)[0]) - math.pi / 6.0))
    assert errors[0] < 2e-5
    assert errors[0] / errors[1] > 4.0
