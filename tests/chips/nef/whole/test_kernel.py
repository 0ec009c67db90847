"""Membranes of neurons under the whole law against exact solutions."""

from __future__ import annotations

import numpy as np
import pytest

from chips.nef.kernel import climb, fall
from chips.nef.network.kernel import DT
from chips.nef.whole.kernel import risen, risen_little, since
from circuits.compiled import compiled


@compiled()
def _rises(slope, g, time, exact, little):
    for i in range(g.size):
        exact[i] = risen(slope[i], g[i], time[i])
        little[i] = risen_little(slope[i], g[i], time[i])


@compiled()
def _since(slope, g, height):
    return since(slope, g, height)


def test_a_membrane_rises_as_its_equation_says() -> None:
    """du/dt = slope - g u from 0 on, in long doubles; both forms, where each is used."""
    x = np.concatenate([[0.0], np.logspace(-9.0, 0.0, 400)])
    slope, time = np.full(x.size, 70.0), np.full(x.size, 0.6e-3)
    exact, little = np.empty((2, x.size))
    _rises(slope, x / time, time, exact, little)
    long = (x / time * time).astype(np.longdouble)
    share = np.ones_like(long)
    np.divide(-np.expm1(-long), long, out=share, where=long > 0.0)
    wanted = (slope * time * share).astype(np.float64)
    np.testing.assert_allclose(little, wanted, rtol=6e-16)
    np.testing.assert_allclose(exact, wanted, rtol=2e-9)  # its series below 1e-4


@pytest.mark.parametrize("steepest", [0.9, 5.0])
def test_a_population_steps_exactly_however_steep_its_neurons_are(steepest: float) -> None:
    rise, speed = np.array([0.01, 0.2, steepest]), np.full(3, 1.0 / DT)
    g = np.array([0.0, 0.02, 0.0])  # what mirrors draw, at first
    steep = fall(rise, 0.5, speed, g)
    assert steep == (steepest > 1.0)
    np.testing.assert_allclose(g, np.array([0.01, 0.21, steepest]) / DT)
    u, rest = np.array([0.2, 0.7, 0.4]), np.array([-1.0, 0.25 * DT, 0.0])
    current, leak, floor = np.array([0.9, 0.6, 2.0]), np.full(3, 0.3), np.full(3, -1.0)
    free = np.array([DT, 0.75 * DT, DT])
    slope = (current - leak) * speed - g * (u - 0.5)
    wanted = u + slope * -np.expm1(-g * free) / g
    climb(u, rest, (current, leak, speed, floor), g, steep)
    np.testing.assert_allclose(u, wanted, rtol=1e-14)
    np.testing.assert_allclose(rest, [-1.0 - DT, -0.75 * DT, -DT])


def test_a_spike_is_placed_where_the_membrane_reached_its_threshold() -> None:
    slope, g, time = 120.0, 300.0, 0.7e-3  # 1/s at the end, 1/s, s
    before = slope * np.exp(g * time)  # slope where it began
    height = before * -np.expm1(-g * time) / g
    assert _since(slope, g, height) == pytest.approx(time, rel=1e-12)
