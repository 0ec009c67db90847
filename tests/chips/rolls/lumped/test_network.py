"""Small networks at rest against the law of their single transistors."""

from __future__ import annotations

import numpy as np
import pytest

from chips.rolls.lumped.network import (
    amplifier,
    degenerated_sum,
    diode,
    pair,
    pair_share,
    sink_over_line,
    stack,
    stack_current,
)

F64 = np.ndarray
SPECIFIC = np.array([3e-7, 5e-7, 2e-6])
PINCH = np.array([-12.0, -1.0, 8.0])  # weak, moderate and strong inversion, U_T


def law(u: F64) -> F64:
    return np.logaddexp(0.0, 0.5 * u) ** 2


def test_series_of_two_equal_halves_is_one_of_twice_the_length() -> None:
    drain = np.array([0.5, 3.0, 20.0])
    out = np.empty(3)
    stack(SPECIFIC, PINCH, SPECIFIC, PINCH, drain, out)
    assert out == pytest.approx(0.5 * SPECIFIC * (law(PINCH) - law(PINCH - drain)), rel=1e-9)


def test_series_where_the_drain_is_below_the_source() -> None:
    out = np.empty(3)
    stack(SPECIFIC, PINCH, SPECIFIC, PINCH, np.full(3, -0.5), out)
    assert out == pytest.approx(0.5 * SPECIFIC * (law(PINCH) - law(PINCH + 0.5)), rel=1e-9)


def test_diode_carries_its_current() -> None:
    kappa, threshold, current = 0.66, np.full(3, 19.0), np.array([1e-12, 1e-9, 1e-5])
    v = np.empty(3)
    diode(SPECIFIC, threshold, kappa, current, 70.0, v)
    p = kappa * (v - threshold)
    assert SPECIFIC * (law(p) - law(p - v)) == pytest.approx(current, rel=1e-8)


def test_pair_divides_its_current_and_loses_none() -> None:
    one, other = np.empty(3), np.empty(3)
    a, b, total = np.array([-3.0, 2.0, 0.0]), np.array([-2.0, -6.0, 0.0]), np.array([1e-12, 1e-8, 1e-5])
    pair(SPECIFIC, a, SPECIFIC, b, total, one)
    pair(SPECIFIC, b, SPECIFIC, a, total, other)
    assert one + other == pytest.approx(total, rel=1e-8)
    # weak inversion: by the exponential; alike: in half
    assert one[0] / other[0] == pytest.approx(np.exp(1.0), rel=2e-3)
    assert one[2] == pytest.approx(0.5 * total[2], rel=1e-8)
    pair(SPECIFIC, a, SPECIFIC, b, np.zeros(3), one)
    assert not one.any()


def test_amplifier_is_high_below_its_balance_and_low_above() -> None:
    drop = np.empty(2)
    one = np.full(2, 5e-7)
    p1, p2 = np.array([-6.0, 0.0]), np.full(2, -3.0)
    amplifier(one, p1, one, p2, 70.0, drop)
    assert law(p2) - law(p2 - drop) == pytest.approx(law(p1) - law(p1 - 70.0 + drop), rel=1e-8)
    assert drop[0] < 0.1
    assert drop[1] > 65.0


def test_sum_on_a_switch_is_less_than_the_sum() -> None:
    lines = np.array([[5e-7], [2.0], [5e-7], [2.0], [5e-7], [-30.0]])
    out = np.empty(1)
    degenerated_sum(np.array([1e-5]), np.array([40.0]), lines, 70.0, out)
    free = 1e-6 * law(np.array([2.0]))
    assert 0.9 * free < out < free
    degenerated_sum(np.array([1e-1]), np.array([40.0]), lines, 70.0, out)
    assert out == pytest.approx(free, rel=1e-4)


def test_sink_is_that_of_its_devices_behind_a_wide_switch() -> None:
    lines = np.array([[5e-7], [2.0], [5e-7], [4.0], [5e-7], [-30.0]])
    grid = np.array([0.0, 2.0, 40.0])
    out = np.empty((1, 3))
    sink_over_line(np.array([1e-1]), np.array([80.0]), lines, grid, out)
    expected = [sum(5e-7 * (law(np.array(p)) - law(p - y)) for p in (2.0, 4.0, -30.0)) for y in grid]
    assert out[0] == pytest.approx(expected, rel=1e-4)


def test_a_network_has_the_bits_that_it_has_by_itself() -> None:
    draw = np.random.default_rng(1000)
    n = 150  # more than a team
    i1, i2, i3 = 10.0 ** draw.uniform(-8.0, -6.0, (3, n))
    p1, p2, p3, p4 = draw.uniform(-20.0, 15.0, (4, n))
    total, drain = 10.0 ** draw.uniform(-14.0, -6.0, n), draw.uniform(-1.0, 70.0, n)
    lines = np.stack((i1, p2, i2, p3, i3, p4))
    for solve in (
        lambda k, out: stack(i1[k], p1[k], i2[k], p2[k], drain[k], out),
        lambda k, out: diode(i1[k], 20.0 + 0.1 * p1[k], 0.7, total[k], 70.0, out),
        lambda k, out: amplifier(i1[k], p1[k], i2[k], p2[k], 70.0, out),
        lambda k, out: pair(i1[k], p1[k], i2[k], p2[k], total[k], out),
        lambda k, out: degenerated_sum(i3[k], p1[k], np.ascontiguousarray(lines[:, k]), 70.0, out),
    ):
        together, alone = np.empty(n), np.empty((n, 1))
        solve(slice(None), together)
        for k in range(n):
            solve(slice(k, k + 1), alone[k])
        np.testing.assert_array_equal(together, alone[:, 0])


def test_a_team_of_series_is_each_by_the_scalar_law() -> None:
    draw = np.random.default_rng(1001)
    i1, i2 = 10.0 ** draw.uniform(-8.0, -6.0, (2, 100))
    p1, p2 = draw.uniform(-20.0, 15.0, (2, 100))
    drain, out = draw.uniform(-1.0, 70.0, 100), np.empty(100)
    stack(i1, p1, i2, p2, drain, out)
    each = [stack_current(*x) for x in zip(i1, p1, i2, p2, drain, strict=True)]
    assert out == pytest.approx(each, rel=1e-13, abs=0.0)  # laws that differ in their last place
    pair(i1, p1, i2, p2, i1, out)
    each = [pair_share(*x) for x in zip(i1, p1, i2, p2, i1, strict=True)]
    assert out == pytest.approx(each, rel=1e-13, abs=0.0)
