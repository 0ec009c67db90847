"""Sparse LU factorisation of a matrix whose pattern is known, as a program that is run at every step.

The circuit fixes which entries of the matrix are not zero, so that the order of elimination and the entries
that fill in are found once. The program lists, in order, which entry is updated by which product; to run it
takes two short loops over integers. There is no pivoting: in a transient every node has capacitance, and the
step is made shorter where a factorisation is not good enough. The order of elimination is the minimum degree
of SuperLU.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, U32
from circuits.catalogue import later
from circuits.compiled import compiled

linalg, sparse = later("scipy.sparse.linalg"), later("scipy.sparse")


class Factor(NamedTuple):
    """A factorisation program over the entries of an n by n matrix, which is stored as float64[entries].

    Positions have no sign, or kernels look at each whether it counts from the end.
    """

    diagonal: U32  # [n] position of each pivot
    lower_start: U32  # [n + 1] range of the pivot's column below the diagonal
    lower: U32  # positions, l_ik
    lower_row: U32  # rows i
    update_start: U32  # [n + 1] range of the pivot's updates a_ij -= l_ik u_kj
    update: U32  # [3, updates] positions of a_ij, l_ik, u_kj
    upper_start: U32  # [n + 1] range of the pivot's row right of the diagonal
    upper: U32  # positions, u_kj
    upper_column: U32  # columns j
    entries: int


def elimination_order(n: int, rows: I64, columns: I64) -> I64:
    """Order in which to eliminate an n by n pattern, int64[n]: `order[k]` is the k-th pivot.

    rows, columns: int64[entries] each, positions of the entries that are not zero.
    """
    both = (np.concatenate([rows, columns, np.arange(n)]), np.concatenate([columns, rows, np.arange(n)]))
    matrix = sparse.csc_array((np.ones(both[0].size), both), shape=(n, n))
    matrix.data[:] = 1.0
    matrix.setdiag(float(n + 1))
    factors = linalg.splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    return np.argsort(factors.perm_c).astype(np.int64)


def factor_program(n: int, pattern: set[tuple[int, int]]) -> tuple[Factor, dict[tuple[int, int], int]]:
    """The program for a pattern whose rows and columns are already in the order of elimination.

    Returns the program and the position of every entry by its row and column, entries that fill in included.
    """
    row_sets: list[set[int]] = [{k} for k in range(n)]
    for i, j in pattern:
        row_sets[i].add(j)
    columns: list[set[int]] = [set() for _ in range(n)]
    for i, row in enumerate(row_sets):
        for j in row:
            columns[j].add(i)
    for k in range(n):
        right = {j for j in row_sets[k] if j > k}
        for i in [i for i in columns[k] if i > k]:
            for j in right - row_sets[i]:
                row_sets[i].add(j)
                columns[j].add(i)
    position = {(i, j): p for p, (i, j) in enumerate((i, j) for i in range(n) for j in sorted(row_sets[i]))}
    lower: list[list[int]] = []
    upper: list[list[int]] = []
    updates: list[list[tuple[int, int, int]]] = []
    for k in range(n):
        lower.append(sorted(i for i in columns[k] if i > k))
        upper.append(sorted(j for j in row_sets[k] if j > k))
        updates.append([(position[i, j], position[i, k], position[k, j]) for i in lower[k] for j in upper[k]])
    flat_updates = np.array([u for row in updates for u in row], dtype=np.uint32).reshape(-1, 3)
    program = Factor(
        diagonal=np.array([position[k, k] for k in range(n)], dtype=np.uint32),
        lower_start=_starts(lower),
        lower=np.array([position[i, k] for k in range(n) for i in lower[k]], dtype=np.uint32),
        lower_row=np.array([i for k in range(n) for i in lower[k]], dtype=np.uint32),
        update_start=_starts(updates),
        update=np.ascontiguousarray(flat_updates.T),
        upper_start=_starts(upper),
        upper=np.array([position[k, j] for k in range(n) for j in upper[k]], dtype=np.uint32),
        upper_column=np.array([j for k in range(n) for j in upper[k]], dtype=np.uint32),
        entries=len(position),
    )
    return program, position


def _starts(rows: list[list[int]] | list[list[tuple[int, int, int]]]) -> U32:
    return np.concatenate([[0], np.cumsum([len(r) for r in rows])]).astype(np.uint32)


@compiled()
def factor_and_solve(f: Factor, a: F64, b: F64) -> None:
    """Factor the entries `a` in place, and replace the right-hand side `b`, float64[n], by the solution."""
    n = f.diagonal.size
    for k in range(n):
        inverse = 1.0 / a[f.diagonal[k]]
        a[f.diagonal[k]] = inverse
        bk = b[k]
        for p in range(f.lower_start[k], f.lower_start[k + 1]):
            factor = a[f.lower[p]] * inverse
            a[f.lower[p]] = factor
            b[f.lower_row[p]] -= factor * bk
        for p in range(f.update_start[k], f.update_start[k + 1]):
            a[f.update[0, p]] -= a[f.update[1, p]] * a[f.update[2, p]]
    for k in range(n - 1, -1, -1):
        total = b[k]
        for p in range(f.upper_start[k], f.upper_start[k + 1]):
            total -= a[f.upper[p]] * b[f.upper_column[p]]
        b[k] = total * a[f.diagonal[k]]
