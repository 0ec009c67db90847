"""The library's distance is the discrete one of Eiter and Mannila: held against their recursion."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.rover.frechet import discrete_frechet


def by_recursion(p: np.ndarray, q: np.ndarray) -> float:
    """Their Table 1, for short lines."""

    @cache
    def c(i: int, j: int) -> float:
        here = float(np.hypot(*(p[i] - q[j])))
        before = [c(a, b) for a, b in ((i - 1, j), (i - 1, j - 1), (i, j - 1)) if a >= 0 and b >= 0]
        return max(here, min(before)) if before else here

    return c(len(p) - 1, len(q) - 1)


@pytest.mark.parametrize("seed", range(20))
def test_it_is_their_distance(seed: int) -> None:
    random = np.random.default_rng(seed)
    n, m = random.integers(1, 15, 2)
    p, q = random.normal(size=(n, 2)), random.normal(size=(m, 2))
    assert discrete_frechet(p, q) == pytest.approx(by_recursion(p, q), rel=1e-12)


def test_only_vertices_count_and_order_matters() -> None:
    straight = np.array([[0.0, 0.0], [100.0, 0.0]])
    bent = np.array([[0.0, 0.0], [50.0, 50.0], [100.0, 0.0]])
    assert discrete_frechet(straight, bent) == pytest.approx(np.hypot(50.0, 50.0))
    assert discrete_frechet(straight, straight[::-1]) == pytest.approx(100.0)


def test_repeated_vertices_change_nothing() -> None:
    line = np.array([[0.0, 0.0], [3.0, 4.0]])
    assert discrete_frechet(np.repeat(line, 3, axis=0), line) == 0.0
    assert discrete_frechet(line[:1], line) == pytest.approx(5.0)


@pytest.mark.parametrize("bad", [np.zeros((0, 2)), np.zeros(2), np.zeros((2, 3)), np.array([[0.0, np.nan]])])
def test_bad_lines_are_refused(bad: np.ndarray) -> None:
    with pytest.raises(ParameterError, match=r"^second: "):
        discrete_frechet(np.zeros((1, 2)), bad)
