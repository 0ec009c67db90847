"""Sums of a fixed order solve what a library solves."""

import numpy as np
import pytest

from chips.nef.network.solve import gram, moment, solve


@pytest.mark.parametrize("n", [1, 3, 4, 30])
def test_they_are_the_librarys_to_rounding(n: int) -> None:
    random = np.random.default_rng(n)
    a, f = random.normal(size=(57, n)), random.normal(size=(57, 2))
    assert gram(a) == pytest.approx(a.T @ a, rel=1e-12, abs=1e-12)
    assert moment(a, f) == pytest.approx(a.T @ f, rel=1e-12, abs=1e-12)
    regularised = gram(a) + 0.3 * np.eye(n)
    expected = np.linalg.solve(regularised, a.T @ f)
    assert solve(regularised.copy(), moment(a, f)) == pytest.approx(expected, rel=1e-9, abs=1e-12)
