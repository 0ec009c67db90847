"""Sums of a fixed order solve what a library solves."""

import math

import numpy as np
import pytest

from chips.nef.network.solve import factor, gram, missed, moment, solve
from circuits.arrays import F64


@pytest.mark.parametrize("n", [1, 3, 4, 30, 53])
def test_they_are_the_librarys_to_rounding(n: int) -> None:
    random = np.random.default_rng(n)
    a, f = random.normal(size=(57, n)), random.normal(size=(57, 2))
    assert gram(a) == pytest.approx(a.T @ a, rel=1e-12, abs=1e-12)
    assert moment(a, f) == pytest.approx(a.T @ f, rel=1e-12, abs=1e-12)
    regularised = gram(a) + 0.3 * np.eye(n)
    expected = np.linalg.solve(regularised, a.T @ f)
    lower = factor(regularised)
    assert lower[:, :n][np.tril_indices(n)] == pytest.approx(
        np.linalg.cholesky(regularised)[np.tril_indices(n)], rel=1e-9, abs=1e-12
    )
    assert solve(lower, moment(a, f)) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_nothing_that_is_given_is_overwritten() -> None:
    matrix, right = np.array([[4.0]]), np.array([[2.0]])
    assert solve(factor(matrix), right)[0, 0] == 0.5
    assert matrix[0, 0] == 4.0
    assert right[0, 0] == 2.0


@pytest.mark.parametrize("points", [3, 7, 16, 41])
def test_sums_have_the_order_that_is_told(points: int) -> None:
    """Each lane of 16 by itself, then lanes four apart, then halves, then what is left, four at a time."""
    random = np.random.default_rng(points)
    # whole numbers whose products are exact, but not all of their sums, so that their order tells
    a = np.rint(random.normal(size=(points, 3)) * 2.0**26)
    found = gram(a)
    for i in range(3):
        for j in range(3):
            assert found[i, j] == _in_order(a[:, i], a[:, j])


def test_what_is_missed_is_the_root_of_the_mean_square() -> None:
    random = np.random.default_rng(8)
    a, d, f = random.normal(size=(57, 21)), random.normal(size=(21, 2)), random.normal(size=(57, 2))
    assert missed(a, d, f) == pytest.approx(np.sqrt(((a @ d - f) ** 2).mean(axis=0)), rel=1e-12)


def test_whole_numbers_have_exact_sums() -> None:
    for points, n in ((103, 17), (8000, 260)):  # the second by the library
        a = np.random.default_rng(4).integers(0, 400, (points, n)).astype(np.float64)
        columns = a.astype(np.int64).T
        assert (gram(a) == columns @ columns.T).all()


def _in_order(a: F64, b: F64) -> float:
    whole = len(a) - len(a) % 16
    products = [int(x) * int(y) for x, y in zip(a, b, strict=True)]
    lanes = [0.0] * 16
    for k in range(whole):
        lanes[k % 16] = _plus(lanes[k % 16], products[k])
    t = [lanes[q] + lanes[q + 4] + lanes[q + 8] + lanes[q + 12] for q in range(4)]
    total, k = (t[0] + t[2]) + (t[1] + t[3]), whole
    if len(a) - k >= 4:
        t = [total, 0.0, 0.0, 0.0]
        while k + 4 <= len(a):
            t = [_plus(x, p) for x, p in zip(t, products[k : k + 4], strict=True)]
            k += 4
        total = (t[0] + t[2]) + (t[1] + t[3])
    for product in products[k:]:
        total = _plus(total, product)
    return total


def _plus(total: float, product: int) -> float:
    """Rounded once; both are whole numbers."""
    assert math.floor(total) == total
    return float(int(total) + product)
