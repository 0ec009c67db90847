"""The step against the equations as they are written, and its exponentials against the library's."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from system.spiking_bat.network import hodgkin_huxley as hh

STEP = 0.02e-3


def slopes(_: float, y: np.ndarray, current: float) -> list[float]:
    v, m, h, n = y
    u = 1e3 * v + 65.0
    alpha = (
        0.1 * (25.0 - u) / math.expm1((25.0 - u) / 10.0),
        0.07 * math.exp(-u / 20.0),
        0.01 * (10.0 - u) / math.expm1((10.0 - u) / 10.0),
    )
    beta = (4.0 * math.exp(-u / 18.0), 1.0 / (math.exp((30.0 - u) / 10.0) + 1.0), 0.125 * math.exp(-u / 80.0))
    flow = 1200.0 * m**3 * h * (v - 50e-3) + 360.0 * n**4 * (v + 77e-3) + 3.0 * (v + 54.387e-3)
    gates = [1e3 * (a * (1.0 - x) - b * x) for a, b, x in zip(alpha, beta, (m, h, n), strict=True)]
    return [(current - flow) / 1e-2, *gates]


def lane(blocks: np.ndarray, row: int, k: int = 0) -> float:
    return float(blocks.reshape(-1, hh.ROWS, hh.LANES)[k // hh.LANES, row, k % hh.LANES])


def test_polynomials_are_as_near_as_they_say() -> None:
    y = np.linspace(-0.2, 0.2, 401)
    assert max(abs(hh.exp_small(float(x)) / math.exp(x) - 1.0) for x in y) < 2e-12
    z = np.linspace(1e-6, 0.3, 301)
    assert max(abs(hh.relaxation(float(x)) / (-math.expm1(-x) / x) - 1.0) for x in z) < 3e-10
    z = np.linspace(1e-6, 2.4, 301)
    assert max(abs(hh.relaxation_wide(float(x)) / (-math.expm1(-x) / x) - 1.0) for x in z) < 1e-9


@pytest.mark.parametrize("v", [-0.085, -0.065, -0.055, -0.04, -0.0399999, -0.0550001, 0.0, 0.045])
def test_rates_are_the_published_ones(v: float) -> None:
    found = hh.rates(v)
    # the slope of a gate at 0 is alpha, and at 1 it is -beta; off the removable points by 1 nV
    shifted = v + 1e-9
    opening = slopes(0.0, np.array([shifted, 0.0, 0.0, 0.0]), 0.0)[1:]
    closing = slopes(0.0, np.array([shifted, 1.0, 1.0, 1.0]), 0.0)[1:]
    # 1 nV moves a rate by 1e-7 at most; the division near a removable point loses 1e-8
    assert found[:3] == pytest.approx(opening, rel=1e-6)
    assert found[3:] == pytest.approx([a - b for a, b in zip(opening, closing, strict=True)], rel=1e-6)


def test_a_spike_comes_when_the_equations_have_it() -> None:
    current = 0.15
    blocks = hh.new_blocks(1)
    blocks.reshape(-1, hh.ROWS, hh.LANES)[:, hh.CURRENT] = current
    exact = solve_ivp(
        slopes, (0.0, 5e-3), [hh.REST, *hh.rest_gates()], args=(current,), rtol=1e-9, atol=1e-12,
        events=lambda _, y, __: y[0] - hh.THRESHOLD,
    )  # fmt: skip
    steps = 0
    while lane(blocks, hh.SPIKED) == 0.0:
        hh.step_blocks(blocks, STEP)
        steps += 1
        assert steps < 250
    # a method of first order: the upstroke of 100 V/s is late by 0.06 ms at 0.02 ms, half at half of it
    late = steps * STEP - float(exact.t_events[0][0])
    assert 0.0 < late < 4.0 * STEP


def test_halving_the_step_halves_the_error() -> None:
    ends = []
    for step in (STEP, 0.5 * STEP, 0.25 * STEP):
        blocks = hh.new_blocks(1)
        blocks.reshape(-1, hh.ROWS, hh.LANES)[:, hh.CURRENT] = 0.05
        for _ in range(round(2e-3 / step)):
            hh.step_blocks(blocks, step)
        ends.append(lane(blocks, hh.V))
    assert (ends[0] - ends[1]) / (ends[1] - ends[2]) == pytest.approx(2.0, rel=0.1)


def test_a_conductance_is_the_alpha_function() -> None:
    tau, peak = 1e-3, 0.1
    blocks = hh.new_blocks(1)
    rows = blocks.reshape(-1, hh.ROWS, hh.LANES)
    rows[:, hh.DECAY_E] = math.exp(-STEP / tau)
    rows[:, hh.X_E] = peak * math.e / tau
    for k in range(1, 200):
        hh.step_blocks(blocks, STEP)
        t = k * STEP
        # exact but for rounding
        assert lane(blocks, hh.G_E) == pytest.approx(peak * t * math.e / tau * math.exp(-t / tau), rel=1e-12)


def test_lanes_do_not_touch_each_other() -> None:
    alone, among = hh.new_blocks(1), hh.new_blocks(2 * hh.LANES)
    alone.reshape(-1, hh.ROWS, hh.LANES)[0, hh.CURRENT, 0] = 0.12
    rows = among.reshape(-1, hh.ROWS, hh.LANES)
    rows[:, hh.CURRENT] = np.linspace(0.0, 0.3, 2 * hh.LANES).reshape(2, -1)
    rows[1, hh.CURRENT, 5] = 0.12
    for _ in range(500):
        hh.step_blocks(alone, STEP)
        hh.step_blocks(among, STEP)
    assert lane(alone, hh.V, 0) == lane(among, hh.V, hh.LANES + 5)
