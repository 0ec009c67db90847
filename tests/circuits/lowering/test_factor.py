"""The sparse factorisation's program against dense linear algebra."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.lowering.factor import elimination_order, factor_and_solve, factor_program


def solve_sparse(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Order, lay out and solve `matrix x = right` through the program."""
    n = right.size
    rows, columns = np.nonzero(matrix)
    order = elimination_order(n, rows, columns)
    assert sorted(order.tolist()) == list(range(n))
    place = np.argsort(order)
    pattern = {(int(place[i]), int(place[j])) for i, j in zip(rows, columns, strict=True)}
    program, position = factor_program(n, pattern)
    entries = np.zeros(program.entries)
    for i, j in zip(rows, columns, strict=True):
        entries[position[int(place[i]), int(place[j])]] = matrix[i, j]
    solution = right[order].copy()
    factor_and_solve(program, entries, solution)
    return solution[place]


@settings(deadline=None, max_examples=150)
@given(
    n=st.integers(1, 25),
    density=st.floats(0.0, 1.0),
    seed=st.integers(0, 2**32 - 1),
    decades=st.floats(0.0, 6.0),
)
def test_diagonally_dominant_matrices(n: int, density: float, seed: int, decades: float) -> None:
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(n, n)) * (rng.random((n, n)) < density)
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, np.abs(matrix).sum(axis=1) + rng.uniform(0.1, 1.0, n))
    matrix *= 10.0 ** rng.uniform(-decades, 0.0, (n, 1))  # rows of different scale, as in circuits
    right = rng.normal(size=n) * np.abs(matrix).max(axis=1)
    found = solve_sparse(matrix, right)
    # row dominance bounds the growth of elimination by 2; condition of the scaled rows is below 100
    expected = np.linalg.solve(matrix, right)
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max())


def test_minimum_degree_keeps_an_arrow_sparse() -> None:
    # eliminating the hub first would fill the matrix: 400 entries instead of 3 n - 2
    n = 20
    rows = np.concatenate([np.arange(n), np.zeros(n, dtype=np.int64)])
    columns = np.concatenate([np.zeros(n, dtype=np.int64), np.arange(n)])
    order = elimination_order(n, rows, columns)
    place = np.argsort(order)
    program, _ = factor_program(
        n, {(int(place[i]), int(place[j])) for i, j in zip(rows, columns, strict=True)}
    )
    assert program.entries == 3 * n - 2


def test_a_missing_diagonal_entry_is_part_of_the_program() -> None:
    program, position = factor_program(2, {(0, 1), (1, 0)})
    assert program.entries == 4
    assert set(position) == {(0, 0), (0, 1), (1, 0), (1, 1)}


def test_an_unsymmetric_pattern() -> None:
    matrix = np.array([[2.0, 0.0, 1.0], [0.5, 3.0, 0.0], [0.0, 1.0, 4.0]])
    right = np.array([1.0, 2.0, 3.0])
    assert solve_sparse(matrix, right) == pytest.approx(np.linalg.solve(matrix, right), rel=1e-14)
