"""Named tuples that kernels take: whatever stands in them, kernels read it as Python does."""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np
from numba import typeof

from circuits.arrays import F64, I32
from circuits.compiled import compiled
from circuits.machine_code.structure import Structure


class Inner(NamedTuple):
    """A structure in a structure, in a tuple, and alone."""

    values: F64
    gain: float


class Outer(NamedTuple):
    """One of each kind that has a place in a table."""

    count: int
    inner: Inner
    rows: I32  # [2, n]
    on: bool
    nothing: None
    pair: tuple[F64, I32]
    several: tuple[Inner, ...]
    last: float


@compiled()
def _sum_of(x: Inner) -> float:
    total = 0.0
    for i in range(x.values.size):
        total += x.gain * x.values[i]
    return total


@compiled()
def _everything(x: Outer, y: Inner, out: F64) -> float:
    x.inner.values[0] += y.gain
    for i in range(x.rows.shape[1]):
        out[i] = x.rows[0, i] - x.pair[0][i] + x.pair[1][i]
    total = x.last + x.count + (_sum_of(y) if x.on else 0.0) + _sum_of(x.inner)
    for one in x.several:
        total += _sum_of(one)
    return total + (100.0 if x.nothing is None else 0.0)


def _given() -> tuple[Outer, Inner, F64]:
    inner = Inner(np.array([1.0, 2.0, 4.0]), 0.5)
    other = Inner(np.array([3.0, 5.0]), 2.0)
    rows = np.arange(6, dtype=np.int32).reshape(2, 3)
    pair = (np.array([0.5, 0.25, 0.125]), np.array([7, 8, 9], dtype=np.int32))
    return Outer(3, inner, rows, True, None, pair, (inner, other), 0.0625), other, np.zeros(3)


def test_fields_of_all_kinds_are_what_python_finds() -> None:
    ours, theirs = _given(), _given()
    python: Any = _everything.py_func  # type: ignore[attr-defined]
    assert _everything(*ours) == python(*theirs)
    np.testing.assert_array_equal(ours[2], theirs[2])
    np.testing.assert_array_equal(ours[0].inner.values, theirs[0].inner.values)
    assert ours[0].inner.values[0] == 3.0  # an array is not a copy


def test_it_is_one_address_under_a_short_name() -> None:
    kind = typeof(_given()[0])
    assert isinstance(kind, Structure)
    assert len(str(kind)) < 40
    assert kind != typeof(_given()[0]._replace(last=1))


def test_tuples_of_other_packages_and_of_other_contents_stay_those_of_numba() -> None:
    foreign = namedtuple("foreign", "values")
    foreign.__module__ = "elsewhere.module"
    assert not isinstance(typeof(foreign(np.zeros(1))), Structure)
    assert not isinstance(typeof(Inner(np.zeros(1), "text")), Structure)  # type: ignore[arg-type]
