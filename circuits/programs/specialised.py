"""A kernel worked out for one structure: straight code, in which what is known beforehand is done already.

    program = specialise(run, wiring, jobs, team, found)

takes a kernel as it stands in Python (`circuits.compiled`) and what is known of its arguments, and works
through its source: what depends on known values alone is computed, loops over known ranges are written out,
branches that are not taken vanish, and the kernels that it calls stand where they were called. What is left
are sums and products of numbers in named variables and in elements of arrays at known places, with the few
loops and branches that depend on the run: a `Program`, whose statements are Python's (`python_text`), and
which `circuits.programs.c_text` writes as C.

So one source has what a processor's lanes do (numba compiles it, with loops over tables) and what a thread of
a graphics processor does, whose registers take no index that is computed.

Arguments are given as what they are, where they are known (numbers, arrays, named tuples of them), and as one
of these where they are not (`circuits.programs.program`):

| | |
|---|---|
| `Argument(name)` | a number |
| `Memory(name, shape)` | an array that the run alone has, an element a variable where all places are known |
| `Shared(name, shape)` | an array that all runs share |

Elements of both may be known to be a number of another name: these are read there, and are never written.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import textwrap
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from types import FunctionType
from typing import Any, final

import numpy as np

from circuits.compiled import Instructions, Kernel
from circuits.errors import ParameterError
from circuits.programs.algebra import (
    all_of,
    chosen,
    combined,
    compared,
    flat,
    is_code,
    is_number,
    name_of,
    negated,
    node,
)
from circuits.programs.program import Argument, Function, Memory, Program, Shared

_WRITTEN_OUT = 8  # turns of a loop whose turn number is unused that are written out; ours
_OF_ONE = (
    math.sqrt,
    math.isfinite,
    np.isfinite,
    abs,
    float,
    int,
    bool,
)  # what a program calls by its own name


def specialise(
    kernel: Kernel,
    *known: Any,
    calls: Mapping[Kernel, str] | None = None,
    functions: Collection[Kernel] = (),
) -> Program:
    """Work a kernel out for its arguments; what `return` gives is dropped.

    calls: kernels that the program calls without arguments, and by which names. functions: kernels that take
    numbers and give numbers, and that stay functions, so that the program has them once.

    Raises ParameterError, with the line, for what such a kernel must not hold.
    """
    work = _Work(calls or {}, functions)
    work.top(kernel.py_func, known)
    return work.program()


@dataclass(frozen=True, slots=True)
class _Pinned:
    """A variable that a branch or a loop of the run changes."""

    name: str


@final
class _Frame:
    """What a function knows while it is worked through.

    early: whether it returns elsewhere than at its end, and so stands in a loop that it leaves. top: whether
    it is what is called from outside.
    """

    def __init__(
        self, function: FunctionType, names: dict[str, Any], *, early: bool = False, top: bool = False
    ) -> None:
        self.function, self.names, self.early, self.top = function, names, early, top
        self.value: Any = None
        self.result = ""  # variable of what it gives, where it returns early

    def find(self, name: str) -> Any:
        """What a name stands for."""
        if name in self.names:
            return self.names[name]
        return self.function.__globals__.get(name, getattr(builtins, name, None))

    def refused(self, part: ast.AST) -> ParameterError:
        """The error of what cannot be worked out."""
        place = f"{self.function.__module__}.{self.function.__qualname__}"
        return ParameterError(
            f"{place}: `{ast.unparse(part)}` cannot be worked out beforehand; write it with numbers, loops "
            "over known ranges, branches, and calls of kernels"
        )


@cache
def _source(function: FunctionType) -> ast.FunctionDef:
    """A function's definition."""
    (found,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    if not isinstance(found, ast.FunctionDef):
        raise ParameterError(f"{function.__qualname__}: no function with a name")
    return found


@cache
def _leaves_early(function: FunctionType) -> bool:
    """Whether a function returns elsewhere than at its end."""
    body = _source(function).body
    count = sum(isinstance(n, ast.Return) for s in body for n in ast.walk(s))
    return count > isinstance(body[-1], ast.Return)


def _bound(function: FunctionType, given: Sequence[Any], named: Mapping[str, Any]) -> dict[str, Any]:
    bound = inspect.signature(function).bind(*given, **named)
    bound.apply_defaults()
    return dict(bound.arguments)


def _assigned(statements: Sequence[ast.stmt]) -> list[str]:
    """Names that statements assign to, but for those that loops count with, in the order in which they do."""
    inside = [n for s in statements for n in ast.walk(s)]
    counted = {n.target.id for n in inside if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}
    found = (n.id for n in inside if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
    return [name for name in dict.fromkeys(found) if name not in counted]


@final
class _Work:
    """The kernel on the way.

    Methods `_on_...` write a statement, and say whether what stands behind it is reached; methods `_of_...`
    tell what an expression is: a known value, or an expression.
    """

    def __init__(self, calls: Mapping[Kernel, str], functions: Collection[Kernel]) -> None:
        self._calls, self._stay = calls, functions
        self.body: list[ast.stmt] = []
        self._variables: list[str] = []
        self._memory: dict[str, Memory] = {}
        self._arguments: dict[str, None] = {}
        self._shared: dict[str, Shared] = {}
        self._tables: dict[str, tuple[float, ...]] = {}
        self._functions: dict[str, Function] = {}
        self._steady: set[str] = set()  # names that are given a value once

    def top(self, function: FunctionType, known: Sequence[Any]) -> None:
        """Work through the kernel that is called from outside."""
        frame = _Frame(function, _bound(function, known, {}), top=True)
        self._statements(frame, _source(function).body)

    def whole(self, function: FunctionType, names: dict[str, Any]) -> Any:
        """Work through a function whose arguments have names; what it gives."""
        frame = _Frame(function, names)
        self._statements(frame, _source(function).body)
        return frame.value

    def program(self) -> Program:
        """What has been written; arrays whose every element is a number of another name are none."""
        memory = [m for m in self._memory.values() if len(m.held) < m.size]
        return Program(
            self.body, self._variables, memory, list(self._arguments), list(self._shared.values()),
            self._tables, list(self._functions.values()),
        )  # fmt: skip

    # What is written.

    def _variable(self, like: str) -> str:
        """A new variable."""
        name = f"{like}_{len(self._variables) + 1}"
        self._variables.append(name)
        return name

    def _put(self, name: str, value: Any) -> None:
        """Give a variable a value."""
        self.body.append(ast.Assign([ast.Name(name, ast.Store())], node(value), lineno=0))

    def _kept(self, value: Any, like: str = "t") -> Any:
        """A value that nothing written later changes."""
        if isinstance(value, tuple):
            return _tuple_like(value, [self._kept(x, like) for x in value])
        if not is_code(value) or isinstance(value, ast.Constant):
            return value
        if isinstance(value, ast.Name) and value.id in self._steady:
            return value
        name = self._variable(like)
        self._put(name, value)
        self._steady.add(name)
        return name_of(name)

    @contextmanager
    def _inside(self) -> Iterator[list[ast.stmt]]:
        """Statements that are written inside go into a list of their own."""
        outer, self.body = self.body, []
        try:
            yield self.body
        finally:
            self.body = outer

    # Functions.

    def _inlined(self, function: FunctionType, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
        """What a function gives, its statements being written here."""
        early, body = _leaves_early(function), _source(function).body
        names = {k: self._kept(v, k) for k, v in _bound(function, given, named).items()}
        frame = _Frame(function, names, early=early)
        if isinstance(body[0], ast.Return) and body[0].value is not None:
            return self._value(frame, body[0].value)  # what stands for it is read where it is used
        if not early:
            self._statements(frame, body)
            return frame.value
        with self._inside() as inner:
            if self._statements(frame, body):
                self.body.append(ast.Break())
        self.body.append(ast.While(ast.Constant(value=True), inner, []))
        return name_of(frame.result) if frame.result else None

    def _called(self, function: FunctionType, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
        """What a function gives that stays one."""
        bound = _bound(function, given, named)
        numbers = [x for value in bound.values() for x in (value if isinstance(value, tuple) else (value,))]
        name = function.__name__
        if name not in self._functions:
            self._functions[name] = _function(function, bound)
        made = [self._variable("given") for _ in self._functions[name].given]
        self._steady.update(made)
        targets: list[ast.expr] = [ast.Name(each, ast.Store()) for each in made]
        call = ast.Call(name_of(name), [node(x) for x in numbers], [])
        self.body.append(ast.Assign([ast.Tuple(targets, ast.Store())], call, lineno=0))
        return tuple(map(name_of, made))

    # Statements.

    def _statements(self, frame: _Frame, body: Sequence[ast.stmt]) -> bool:
        """Write statements; whether what stands behind them is reached."""
        return all(self._statement(frame, statement) for statement in body)

    def _statement(self, frame: _Frame, s: ast.stmt) -> bool:
        method = getattr(self, f"_on_{type(s).__name__.lower()}", None)
        if method is None:
            raise frame.refused(s)
        return method(frame, s) is not False

    def _on_pass(self, frame: _Frame, s: ast.Pass) -> None:
        pass

    def _on_expr(self, frame: _Frame, s: ast.Expr) -> None:
        if not isinstance(s.value, ast.Constant):  # a docstring
            self._value(frame, s.value)

    def _on_assign(self, frame: _Frame, s: ast.Assign) -> None:
        value = self._value(frame, s.value)
        value = value if len(s.targets) == 1 else self._kept(value)
        for target in s.targets:
            self._assign(frame, target, value)

    def _on_annassign(self, frame: _Frame, s: ast.AnnAssign) -> None:
        if s.value is not None:
            self._assign(frame, s.target, self._value(frame, s.value))

    def _on_augassign(self, frame: _Frame, s: ast.AugAssign) -> None:
        now = ast.parse(ast.unparse(s.target), mode="eval").body
        self._assign(frame, s.target, self._value(frame, ast.BinOp(now, s.op, s.value)))

    def _on_break(self, frame: _Frame, s: ast.Break) -> bool:
        self.body.append(ast.Break())
        return False

    def _on_continue(self, frame: _Frame, s: ast.Continue) -> bool:
        self.body.append(ast.Continue())
        return False

    def _on_return(self, frame: _Frame, s: ast.Return) -> bool:
        value = None if s.value is None else self._value(frame, s.value)
        if frame.top:
            self.body.append(ast.Return(None))
        elif not frame.early:
            frame.value = self._kept(value)
        else:
            if value is not None:
                frame.result = frame.result or self._variable("given")
                self._put(frame.result, value)
            self.body.append(ast.Break())
        return False

    def _on_if(self, frame: _Frame, s: ast.If) -> bool:
        test = self._value(frame, s.test)
        if not is_code(test):
            return self._statements(frame, s.body if test else s.orelse)
        self._pin(frame, [s])
        with self._inside() as yes:
            first = self._statements(frame, s.body)
        with self._inside() as no:
            second = self._statements(frame, s.orelse)
        if yes or no:
            self.body.append(ast.If(test, yes or [ast.Pass()], no))
        return first or second

    def _on_for(self, frame: _Frame, s: ast.For) -> bool:
        over = self._value(frame, s.iter)
        if not isinstance(over, range | tuple | list):
            raise frame.refused(s.iter)
        if isinstance(s.target, ast.Name) and s.target.id == "_" and len(over) > _WRITTEN_OUT:
            self._pin(frame, s.body)
            with self._inside() as inner:
                self._statements(frame, s.body)
            turn = ast.Name(self._variable("turn"), ast.Store())
            count = ast.Call(name_of("range"), [ast.Constant(len(over))], [])
            self.body.append(ast.For(turn, count, inner, [], lineno=0))
            return True
        for value in over:
            self._assign(frame, s.target, value)
            if not self._statements(frame, s.body):
                return False
        return True

    def _on_while(self, frame: _Frame, s: ast.While) -> None:
        self._pin(frame, s.body)
        with self._inside() as inner:
            test = self._value(frame, s.test)
            if is_code(test):
                self.body.append(ast.If(ast.UnaryOp(ast.Not(), test), [ast.Break()], []))
            elif not test:
                return
            self._statements(frame, s.body)
        self.body.append(ast.While(ast.Constant(value=True), inner, []))

    def _pin(self, frame: _Frame, statements: Sequence[ast.stmt]) -> None:
        """Give names that the run may change, or may not, a variable each."""
        for name in _assigned(statements):
            now = frame.names.get(name)
            if isinstance(now, _Pinned) or (name in frame.names and not is_number(now)):
                continue  # a known array or the like stays what it is
            variable = self._variable(name)
            if name in frame.names:
                self._put(variable, now)
            frame.names[name] = _Pinned(variable)

    def _assign(self, frame: _Frame, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Tuple):
            for t, v in zip(target.elts, self._kept(tuple(value)), strict=True):
                self._assign(frame, t, v)
        elif isinstance(target, ast.Name):
            now = frame.names.get(target.id)
            if isinstance(now, _Pinned) and is_number(value):
                self._put(now.name, value)
            else:
                frame.names[target.id] = self._kept(value, target.id)
        elif isinstance(target, ast.Subscript):
            self._store(frame, target, value)
        else:
            raise frame.refused(target)

    def _store(self, frame: _Frame, target: ast.Subscript, value: Any) -> None:
        """Write an element of an array, unless it is a number of another name."""
        array, index = self._value(frame, target.value), self._value(frame, target.slice)
        if not isinstance(array, Memory | Shared):
            raise frame.refused(target)
        place = self._place(array, index)
        if isinstance(place, ast.Subscript) and ast.unparse(place.value) == array.name:
            self.body.append(ast.Assign([place], node(value), lineno=0))

    def _place(self, array: Memory | Shared, index: Any) -> ast.expr:
        """An element of an array."""
        at = index if isinstance(index, tuple) else (index,)
        if isinstance(array, Memory):
            self._memory[array.name] = array
            where = flat(array.shape, at)
            if not is_code(where) and where in array.held:
                return array.held[where]
            return ast.Subscript(name_of(array.name), node(where), ast.Load())
        self._shared[array.name] = array
        if array.place is None:
            where = flat(array.shape, at)
        else:
            kept = array.place[flat(array.shape[1:], at[1:])]
            if isinstance(kept, ast.expr):
                return kept
            width = sum(isinstance(each, int) for each in array.place.values())
            where = combined(ast.Add, combined(ast.Mult, at[0], width), kept)
        return ast.Subscript(name_of(array.name), node(where), ast.Load())

    # Expressions.

    def _value(self, frame: _Frame, e: ast.expr) -> Any:
        """What an expression is: a known value, or an expression of what is not known."""
        method = getattr(self, f"_of_{type(e).__name__.lower()}", None)
        if method is None:
            raise frame.refused(e)
        return method(frame, e)

    def told(self, found: Any) -> Any:
        """A value, an argument being the name that it has."""
        if isinstance(found, Argument):
            self._arguments[found.name] = None
            self._steady.add(found.name)
            return name_of(found.name)
        return found

    def _of_constant(self, frame: _Frame, e: ast.Constant) -> Any:
        return e.value

    def _of_tuple(self, frame: _Frame, e: ast.Tuple) -> Any:
        return tuple(self._value(frame, each) for each in e.elts)

    def _of_slice(self, frame: _Frame, e: ast.Slice) -> Any:
        return slice(*(each and self._value(frame, each) for each in (e.lower, e.upper, e.step)))

    def _of_name(self, frame: _Frame, e: ast.Name) -> Any:
        found = frame.find(e.id)
        return name_of(found.name) if isinstance(found, _Pinned) else self.told(found)

    def _of_attribute(self, frame: _Frame, e: ast.Attribute) -> Any:
        return self.told(getattr(self._value(frame, e.value), e.attr))

    def _of_subscript(self, frame: _Frame, e: ast.Subscript) -> Any:
        array, index = self._value(frame, e.value), self._value(frame, e.slice)
        if isinstance(array, Memory | Shared):
            return self._place(array, index)
        if not is_code(index):
            found = array[index]
            return found.item() if isinstance(found, np.generic) else found
        numbers = tuple(float(x) for x in array)
        names = (name for name, known in self._tables.items() if known == numbers)
        name = next(names, f"table_{len(self._tables)}")
        self._tables[name] = numbers
        return ast.Subscript(name_of(name), index, ast.Load())

    def _of_binop(self, frame: _Frame, e: ast.BinOp) -> Any:
        return combined(type(e.op), self._value(frame, e.left), self._value(frame, e.right))

    def _of_unaryop(self, frame: _Frame, e: ast.UnaryOp) -> Any:
        return negated(e.op, self._value(frame, e.operand))

    def _of_boolop(self, frame: _Frame, e: ast.BoolOp) -> Any:
        return all_of([self._value(frame, each) for each in e.values], e.op)

    def _of_compare(self, frame: _Frame, e: ast.Compare) -> Any:
        values = [self._value(frame, each) for each in (e.left, *e.comparators)]
        values = values if len(e.ops) == 1 else [self._kept(v) for v in values]
        tests = [compared(op, a, b) for op, a, b in zip(e.ops, values[:-1], values[1:], strict=True)]
        return all_of(tests, ast.And())

    def _of_ifexp(self, frame: _Frame, e: ast.IfExp) -> Any:
        test = self._value(frame, e.test)
        if not is_code(test):
            return self._value(frame, e.body if test else e.orelse)
        return chosen(test, self._value(frame, e.body), self._value(frame, e.orelse))

    def _of_call(self, frame: _Frame, e: ast.Call) -> Any:
        function = self._value(frame, e.func)
        given = [self._value(frame, each) for each in e.args]
        named = {k.arg: self._value(frame, k.value) for k in e.keywords if k.arg}
        if isinstance(function, Kernel | Instructions):
            return self._of_kernel(frame, e, function, given, named)
        if isinstance(function, type) and hasattr(function, "_fields"):
            return function(*map(self._kept, given), **{k: self._kept(v) for k, v in named.items()})
        if not any(map(is_code, given)):
            return function(*given, **named)
        if function in (min, max):
            a, b = map(self._kept, given)
            return chosen(compared(ast.Lt() if function is min else ast.Gt(), b, a), b, a)
        if function in _OF_ONE:
            return ast.Call(name_of(function.__name__), [node(x) for x in given], [])
        if not isinstance(function, FunctionType):
            raise frame.refused(e)
        return self._inlined(function, given, named)

    def _of_kernel(
        self, frame: _Frame, e: ast.Call, kernel: Kernel | Instructions, given: Sequence[Any],
        named: Mapping[str, Any],
    ) -> Any:  # fmt: skip
        if isinstance(kernel, Instructions):
            if isinstance(kernel.alone, str):
                return ast.Call(name_of(kernel.alone), [node(x) for x in given], [])
            if not isinstance(kernel.alone, FunctionType):
                raise frame.refused(e)
            return self._inlined(kernel.alone, given, named)
        if kernel in self._calls:
            return ast.Call(name_of(self._calls[kernel]), [], [])
        if kernel in self._stay:
            return self._called(kernel.py_func, given, named)
        return self._inlined(kernel.py_func, given, named)


def _function(function: FunctionType, like: Mapping[str, Any]) -> Function:
    """A function of as many numbers as in `like`, each of them unknown."""
    work = _Work({}, ())
    count = 0
    known: dict[str, Any] = {}
    for name, value in like.items():
        each = value if isinstance(value, tuple) else (value,)
        names = [work.told(Argument(f"argument{count + k}")) for k in range(len(each))]
        count += len(each)
        known[name] = _tuple_like(value, names) if isinstance(value, tuple) else names[0]
    given = work.whole(function, known)
    return Function(function.__name__, work.program(), [node(x) for x in given])


def _tuple_like(like: tuple[Any, ...], values: Sequence[Any]) -> tuple[Any, ...]:
    """A tuple of the kind of another one."""
    made: Any = type(like)
    return made(*values) if hasattr(like, "_fields") else tuple(values)
