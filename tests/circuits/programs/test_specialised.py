"""Kernels that are worked out beside themselves in Python."""

import ast
import math
from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np
import pytest

from circuits.compiled import Kernel, compiled
from circuits.errors import ParameterError
from circuits.programs.c_text import c_text, functions_text
from circuits.programs.ordered import ordered
from circuits.programs.program import Argument, Memory, Program, Shared, python_text
from circuits.programs.specialised import specialise


class Table(NamedTuple):
    start: Any
    value: Any
    scale: float


TABLE = Table(np.array([0, 2, 2, 5]), np.array([1.0, -1.0, 2.0, 0.5, 3.0]), 1.0)
CHOICE = (10.0, 20.0, 30.0)


@compiled()
def squared(x: float) -> float:
    """A number's square."""
    return x * x


@compiled()
def both(x: float, y: float) -> tuple[float, float]:
    """A sum and a difference."""
    return x + y, x - y


@compiled()
def clipped(x: float) -> float:
    """A number, no larger than 2."""
    if x > 2.0:
        return 2.0
    return x


@compiled()
def sums(t: Table, x: Any, out: Any) -> None:
    """Sums of rows of a table, with what a branch makes of them."""
    for i in range(t.start.size - 1):
        total = 0.0
        for p in range(t.start[i], t.start[i + 1]):
            total = total + t.scale * t.value[p] * x[p]
        if total > 1.0:
            total = -total
        out[i] = squared(total) + clipped(total)


@compiled()
def halved(x: Any, out: Any, most: float) -> None:
    """How often a number can be halved until it is small, and which choice that is."""
    count, left = 0, x[0]
    while left > most and count < 2:
        left = 0.5 * left
        count += 1
    a, b = both(left, max(most, 0.25))
    out[0] = CHOICE[count]
    out[1] = a * b if math.isfinite(left) else 0.0


def run(program: Program, **arrays: Any) -> None:
    names: dict[str, Any] = {
        "abs": abs,
        "sqrt": math.sqrt,
        "isfinite": math.isfinite,
        **program.tables,
        **arrays,
    }
    for name, inner, given in program.functions:
        names[name] = _function(inner, given)
    exec(compile(python_text(program), "program", "exec"), names)  # noqa: S102 - a program of ours


def _function(inner: Program, given: Any) -> Callable[..., tuple[float, ...]]:
    def call(*numbers: float) -> tuple[float, ...]:
        names: dict[str, Any] = dict(zip(inner.arguments, numbers, strict=True))
        exec(compile(python_text(inner), "function", "exec"), names)  # noqa: S102
        return tuple(names[g.id] if hasattr(g, "id") else g.value for g in given)

    return call


def worked(kernel: Callable[..., Any], *known: Any, **options: Any) -> Program:
    return specialise(cast("Kernel", kernel), *known, **options)


def python(kernel: Callable[..., Any]) -> Callable[..., Any]:
    return cast("Callable[..., Any]", cast("Any", kernel).py_func)


@pytest.mark.parametrize("seed", range(4))
def test_a_table_s_loops_are_written_out_and_mean_the_same(seed: int) -> None:
    x, out = np.random.default_rng(seed).standard_normal(5), np.zeros(3)
    program = worked(sums, TABLE, Memory("x", (5,)), Memory("out", (3,)))
    text = python_text(program)
    assert "range" not in text
    assert "start" not in text
    for each in (program, ordered(program)):
        mine = np.zeros(3)
        run(each, x=x, out=mine)
        python(sums)(TABLE, x, out)
        np.testing.assert_array_equal(mine, out)


@pytest.mark.parametrize("x", [0.1, 3.0, 9.0, math.inf])
def test_loops_and_branches_of_the_run_stay(x: float) -> None:
    program = worked(halved, Shared("x", (1,)), Memory("out", (2,)), Argument("most"), functions=[both])
    assert [f.name for f in program.functions] == ["both"]
    mine, out = np.zeros(2), np.zeros(2)
    run(program, x=np.array([x]), out=mine, most=1.0)
    python(halved)(np.array([x]), out, 1.0)
    np.testing.assert_array_equal(mine, out)


def test_what_is_held_is_read_by_its_name_and_never_written() -> None:
    held: dict[int, ast.expr] = {1: ast.Constant(7.0)}
    program = worked(copy_all, Memory("a", (2,), held=held), Memory("b", (2,)))
    assert python_text(program) == "b[0] = a[0]\na[0] = 0.0\nb[1] = 7.0"


@compiled()
def copy_all(a: Any, b: Any) -> None:
    """Copy, and clear."""
    for i in range(2):
        b[i] = a[i]
        a[i] = 0.0


@compiled()
def lists(out: Any) -> None:
    """What no program holds."""
    out[0] = sum([x for x in out])  # noqa: C416


def test_what_cannot_be_worked_out_is_named_with_its_place() -> None:
    told = (
        r"test_specialised.lists: `\[x for x in out\]` cannot be worked out beforehand; write it with numbers"
    )
    with pytest.raises(ParameterError, match=told):
        worked(lists, Memory("out", (1,)))


@compiled()
def far_apart(x: Any, out: Any) -> None:
    """Two sums, of numbers that are all there before the first is taken."""
    a, b, c = x[0] * x[1], x[1] * x[2], x[2] * x[3]
    out[0] = a + x[3]
    out[1] = b + c


def test_a_sum_is_taken_as_soon_as_it_can_be() -> None:
    program = worked(far_apart, Memory("x", (4,)), Memory("out", (2,)))
    lines = python_text(ordered(program)).splitlines()
    assert sorted(lines) == sorted(python_text(program).splitlines())
    assert lines.index(next(line for line in lines if line.startswith("out[0]"))) == 1


@compiled()
def numbers(out: Any) -> None:
    """Numbers that C writes in its own way."""
    out[0] = -np.inf
    out[1] = out[0] / 2 + 1e300
    out[2] = np.nan


def test_numbers_have_c_s_form() -> None:
    program = worked(numbers, Memory("out", (3,)))
    declared, body = c_text(program)
    assert declared == ["double out[3];"]
    assert body == ["out[0] = (-INFINITY);", "out[1] = (((double) out[0] / 2) + 1e+300);", "out[2] = NAN;"]


def test_functions_have_their_text() -> None:
    program = worked(halved, Shared("x", (1,)), Memory("out", (2,)), Argument("most"), functions=[both])
    text = functions_text(program, "static")
    assert text[:2] == [
        "struct given_by_both { double x0; double x1; };",
        "static given_by_both both(double argument0, double argument1) {",
    ]
    assert text[-1] == "}"
