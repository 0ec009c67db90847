"""A kernel worked out for one structure: straight code, in which what is known beforehand is done already.

    program = specialise(run, Known...)

takes a kernel as it stands in Python (`circuits.compiled`) and what is known of its arguments, and works
through its source: what depends on known values alone is computed, loops over known ranges are written out,
branches that are not taken vanish, and the kernels that it calls stand where they were called. What is left
are sums and products of numbers in named variables and in elements of arrays at known places, with the few
loops and branches that depend on the run: a `Program`, whose statements are Python's, for `python_text`, and
which `circuits.machine_code.c_text` writes as C.

So one source has what a processor's lanes do (numba compiles it, with loops over tables) and what a thread of
a graphics processor does, whose registers take no index that is computed.

Arguments are given as what they are, where they are known (numbers, arrays, named tuples of them), and as one
of these where they are not:

| | |
|---|---|
| `Argument(name)` | a number |
| `Memory(name, shape)` | an array that the run alone has: an element a variable where all its places are known |
| `Shared(name, place)` | an array that all runs share; `place` makes one index of those of an element |

A `Memory` may have elements that are known to be a number of another name (`held`): these are read there, and
are never written.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import operator
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from types import FunctionType
from typing import Any, NamedTuple, final

import numpy as np

from circuits.compiled import Instructions, Kernel
from circuits.errors import ParameterError

Index = tuple[Any, ...]  # of each dimension a number, or an expression


@dataclass(frozen=True, slots=True)
class Argument:
    """A number that is not known beforehand."""

    name: str


@dataclass(frozen=True, slots=True)
class Memory:
    """An array that a run has for itself.

    Attributes
    ----------
    name : str
        Its name in the program.
    shape : tuple of int
        Its shape.
    whole : bool
        Whether its elements are whole numbers.
    held : mapping
        Elements, by their place in the flat array, that are numbers of another name.
    """

    name: str
    shape: tuple[int, ...]
    whole: bool = False
    held: Mapping[int, ast.expr] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """How many elements it has."""
        return math.prod(self.shape)


@dataclass(frozen=True, slots=True)
class Shared:
    """An array that all runs share.

    Attributes
    ----------
    name : str
        Its name in the program.
    shape : tuple of int
        Its shape; what is not known of it is -1, and must not be asked.
    whole : bool
        Whether its elements are whole numbers.
    place : mapping or None
        Of the elements behind the first index, by their place in the flat array, where each is kept, or what
        number it is of another name; None where all are kept in their order.
    """

    name: str
    shape: tuple[int, ...]
    whole: bool = False
    place: Mapping[int, int | ast.expr] | None = None

    @property
    def size(self) -> int:
        """How many elements it has."""
        return math.prod(self.shape)


class Program(NamedTuple):
    """What is left of a kernel.

    body: statements. variables: names of all numbers that it makes. memory: arrays of its own. arguments:
    names of numbers that it is given. shared: arrays that it is given. tables: known numbers among which it
    chooses.
    """

    body: list[ast.stmt]
    variables: list[str]
    memory: list[Memory]
    arguments: list[str]
    shared: list[Shared]
    tables: dict[str, tuple[float, ...]]


def specialise(kernel: Kernel, *known: Any, calls: Mapping[Kernel, str] | None = None) -> Program:
    """Work a kernel out for its arguments; what `return` gives is dropped.

    calls: kernels that are called in the program too, without arguments, and the names that they have there.

    Raises ParameterError, with the line, for what such a kernel must not hold.
    """
    work = _Work(calls or {})
    work.top(kernel.py_func, known)
    work.release()
    return Program(
        work.body, work.variables, list(work.memory.values()), list(work.arguments),
        list(work.shared.values()), work.tables,
    )  # fmt: skip


def python_text(program: Program) -> str:
    """The statements as Python has them."""
    return ast.unparse(ast.fix_missing_locations(ast.Module(program.body, [])))


@dataclass(frozen=True, slots=True)
class _Pinned:
    """A variable that a branch or a loop changes."""

    name: str


@final
class _Frame:
    """What a function knows while it is worked through."""

    def __init__(self, function: FunctionType, names: dict[str, Any], *, loop: bool) -> None:
        self.function, self.names, self.loop = function, names, loop
        self.value: Any = None
        self.pinned: dict[str, str] = {}
        self.depth = 0  # branches and loops of the run that stand around the statement

    def find(self, name: str) -> Any:
        """What a name stands for."""
        if name in self.names:
            return self.names[name]
        return self.function.__globals__.get(name, getattr(builtins, name, None))


_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow, ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod,
    ast.LShift: operator.lshift, ast.RShift: operator.rshift, ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
}  # fmt: skip
_COMPARED: dict[type, Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip
_MADE_OF_ONE = (math.sqrt, math.isfinite, abs, float, int)


def _is_code(value: Any) -> bool:
    return isinstance(value, ast.expr)


def _is_number(value: Any) -> bool:
    return isinstance(value, ast.expr | bool | int | float | np.generic)


def _node(value: Any) -> ast.expr:
    """A known value or an expression, as an expression."""
    if isinstance(value, ast.expr):
        return value
    if isinstance(value, np.generic):
        value = value.item()
    if not isinstance(value, bool | int | float):
        raise ParameterError(f"a kernel's {value!r} is no number")
    return ast.Constant(value)


def _name(name: str) -> ast.Name:
    return ast.Name(name, ast.Load())


@cache
def _source(function: FunctionType) -> ast.FunctionDef:
    """A function's definition."""
    (found,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    if not isinstance(found, ast.FunctionDef):
        raise ParameterError(f"{function.__qualname__}: not a function with a name")
    return found


def _assigned(nodes: Sequence[ast.stmt]) -> list[str]:
    """Names that statements assign to, but for those that loops count with, in the order in which they do."""
    inside = [n for s in nodes for n in ast.walk(s)]
    counted = {n.target.id for n in inside if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}
    found = (n.id for n in inside if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
    return [name for name in dict.fromkeys(found) if name not in counted]


@cache
def _leaves_early(function: FunctionType) -> bool:
    """Whether a function returns elsewhere than at its end."""
    body = _source(function).body
    count = sum(isinstance(n, ast.Return) for s in body for n in ast.walk(s))
    return count > isinstance(body[-1], ast.Return)


@final
class _Work:
    """The kernel on the way."""

    def __init__(self, calls: Mapping[Kernel, str]) -> None:
        self.calls = calls
        self.body: list[ast.stmt] = []
        self.variables: list[str] = []
        self.memory: dict[str, Memory] = {}
        self.arguments: dict[str, None] = {}
        self.shared: dict[str, Shared] = {}
        self.tables: dict[str, tuple[float, ...]] = {}
        self._count = 0

    # -- what is written

    def variable(self, like: str) -> str:
        """A new variable."""
        self._count += 1
        name = f"{like}_{self._count}"
        self.variables.append(name)
        return name

    def write(self, statement: ast.stmt) -> None:
        """Put a statement at the end."""
        self.body.append(statement)

    def put(self, name: str, value: Any) -> None:
        """Give a variable a value."""
        self.write(ast.Assign([ast.Name(name, ast.Store())], _node(value), lineno=0))

    def kept(self, value: Any, like: str = "t") -> Any:
        """A value that nothing written later changes."""
        if isinstance(value, tuple):
            each = [self.kept(x, like) for x in value]
            return type(value)(*each) if hasattr(value, "_fields") else tuple(each)
        if not _is_code(value) or isinstance(value, ast.Constant):
            return value
        if isinstance(value, ast.Name) and value.id in self._steady:
            return value
        name = self.variable(like)
        self.put(name, value)
        self._steady.add(name)
        return _name(name)

    @contextmanager
    def inside(self) -> Iterator[list[ast.stmt]]:
        """Statements that are written inside go into a list of their own."""
        outer, self.body = self.body, []
        try:
            yield self.body
        finally:
            self.body = outer

    _steady: set[str]

    def top(self, function: FunctionType, known: Sequence[Any]) -> None:
        """Work through the kernel that is called from outside."""
        self._steady = set()
        frame = _Frame(function, self._bound(function, known, {}), loop=False)
        self._statements(frame, _source(function).body, top=True)

    def release(self) -> None:
        """Forget arrays whose every element is a number of another name."""
        self.memory = {k: m for k, m in self.memory.items() if len(m.held) < m.size}

    # -- functions

    def _bound(self, function: FunctionType, given: Sequence[Any], named: Mapping[str, Any]) -> dict[str, Any]:
        bound = inspect.signature(function).bind(*given, **named)
        bound.apply_defaults()
        return dict(bound.arguments)

    def _inlined(self, function: FunctionType, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
        """What a function gives, its statements being written here."""
        early = _leaves_early(function)
        names = {k: self.kept(v, k) for k, v in self._bound(function, given, named).items()}
        frame = _Frame(function, names, loop=early)
        body = _source(function).body
        if isinstance(body[0], ast.Return) and body[0].value is not None:
            return self._value(frame, body[0].value)  # what stands for it is read where it is used
        if not early:
            self._statements(frame, body)
            return frame.value
        with self.inside() as inner:
            self._statements(frame, body)
            if not inner or not isinstance(inner[-1], ast.Break):
                self.write(ast.Break())
        self.write(ast.While(ast.Constant(value=True), inner, []))
        return _name(frame.pinned["return"]) if "return" in frame.pinned else None

    def _statements(self, frame: _Frame, body: Sequence[ast.stmt], *, top: bool = False) -> bool:
        """Write statements; whether what stands behind them is reached."""
        for statement in body:
            if not self._statement(frame, statement, top=top):
                return False
        return True

    def _statement(self, frame: _Frame, s: ast.stmt, *, top: bool) -> bool:
        if isinstance(s, ast.Expr):
            if not isinstance(s.value, ast.Constant):
                self._value(frame, s.value)
        elif isinstance(s, ast.Assign):
            value = self._value(frame, s.value)
            value = value if len(s.targets) == 1 else self.kept(value)
            for target in s.targets:
                self._assign(frame, target, value)
        elif isinstance(s, ast.AnnAssign) and s.value is not None:
            self._assign(frame, s.target, self._value(frame, s.value))
        elif isinstance(s, ast.AugAssign):
            whole = ast.BinOp(_loaded(s.target), s.op, s.value)
            self._assign(frame, s.target, self._value(frame, whole))
        elif isinstance(s, ast.If):
            return self._branch(frame, s, top=top)
        elif isinstance(s, ast.For):
            return self._for(frame, s, top=top)
        elif isinstance(s, ast.While):
            self._while(frame, s, top=top)
        elif isinstance(s, ast.Return):
            return self._return(frame, s, top=top)
        elif isinstance(s, ast.Break | ast.Continue):
            self.write(type(s)())
            return False
        elif not isinstance(s, ast.Pass):
            raise self._refused(frame, s)
        return True

    def _refused(self, frame: _Frame, node: ast.AST) -> ParameterError:
        place = f"{frame.function.__module__}.{frame.function.__qualname__}"
        return ParameterError(
            f"{place}: `{ast.unparse(node)}` cannot be worked out beforehand; write it with numbers, loops over "
            "known ranges, branches, and calls of kernels"
        )

    def _return(self, frame: _Frame, s: ast.Return, *, top: bool) -> bool:
        value = None if s.value is None else self._value(frame, s.value)
        if top:
            self.write(ast.Return(None))
        elif not frame.loop:
            frame.value = self.kept(value)
        else:
            if value is not None:
                if "return" not in frame.pinned:
                    frame.pinned["return"] = self.variable("given")
                self.put(frame.pinned["return"], value)
            self.write(ast.Break())
        return False

    # -- branches and loops

    def _pin(self, frame: _Frame, nodes: Sequence[ast.stmt]) -> None:
        """Give names that the run may change, or may not, a variable each."""
        for name in _assigned(nodes):
            now = frame.names.get(name)
            if isinstance(now, _Pinned):
                continue
            variable = self.variable(name)
            if name in frame.names and not _is_number(now):
                continue  # a known array or the like, which stays what it is
            if name in frame.names:
                self.put(variable, now)
            frame.names[name] = _Pinned(variable)

    def _branch(self, frame: _Frame, s: ast.If, *, top: bool) -> bool:
        test = self._value(frame, s.test)
        if not _is_code(test):
            return self._statements(frame, s.body if test else s.orelse, top=top)
        self._pin(frame, [s])
        with self.inside() as yes:
            first = self._statements(frame, s.body, top=top)
        with self.inside() as no:
            second = self._statements(frame, s.orelse, top=top)
        if not yes and not no:
            return True
        self.write(ast.If(test, yes or [ast.Pass()], no))
        return first or second

    def _for(self, frame: _Frame, s: ast.For, *, top: bool) -> bool:
        over = self._value(frame, s.iter)
        if _is_code(over) or not isinstance(over, range | tuple | list):
            raise self._refused(frame, s.iter)
        unused = isinstance(s.target, ast.Name) and s.target.id == "_"
        if unused and len(over) > _WRITTEN_OUT:
            self._pin(frame, s.body)
            with self.inside() as inner:
                self._statements(frame, s.body, top=top)
            count = [ast.Constant(len(over))]
            turn = ast.Name(self.variable("turn"), ast.Store())
            self.write(ast.For(turn, ast.Call(_name("range"), count, []), inner, [], lineno=0))
            return True
        for value in over:
            self._assign(frame, s.target, value)
            if not self._statements(frame, s.body, top=top):
                return False
        return True

    def _while(self, frame: _Frame, s: ast.While, *, top: bool) -> None:
        self._pin(frame, s.body)
        with self.inside() as inner:
            test = self._value(frame, s.test)
            if _is_code(test):
                self.write(ast.If(ast.UnaryOp(ast.Not(), test), [ast.Break()], []))
            elif not test:
                return
            self._statements(frame, s.body, top=top)
        self.write(ast.While(ast.Constant(value=True), inner, []))

    # -- assignments

    def _assign(self, frame: _Frame, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Tuple):
            for t, v in zip(target.elts, self.kept(tuple(value)), strict=True):
                self._assign(frame, t, v)
        elif isinstance(target, ast.Name):
            now = frame.names.get(target.id)
            if isinstance(now, _Pinned) and _is_number(value):
                self.put(now.name, value)
            else:
                frame.names[target.id] = self.kept(value, target.id)
        elif isinstance(target, ast.Subscript):
            place = self._element(frame, target)
            if place is not None:
                place.ctx = ast.Store()
                self.write(ast.Assign([place], _node(value), lineno=0))
        else:
            raise self._refused(frame, target)

    def _element(self, frame: _Frame, target: ast.Subscript) -> ast.Subscript | None:
        """An element of an array that is written; None where it is a number of another name."""
        array, index = self._value(frame, target.value), self._value(frame, target.slice)
        place = self._place(frame, target, array, index)
        of_array = isinstance(place, ast.Subscript) and isinstance(place.value, ast.Name)
        return place if of_array and place.value.id == array.name else None

    def _place(self, frame: _Frame, node: ast.expr, array: Any, index: Any) -> Any:
        """An element of an array."""
        at = index if isinstance(index, tuple) else (index,)
        if isinstance(array, Memory):
            self.memory[array.name] = array
            flat = _flat(array.shape, at)
            if not _is_code(flat) and flat in array.held:
                return array.held[flat]
            return ast.Subscript(_name(array.name), _node(flat), ast.Load())
        if isinstance(array, Shared):
            self.shared[array.name] = array
            if array.place is None:
                flat = _flat(array.shape, at)
            else:
                kept = array.place[_flat(array.shape[1:], at[1:])]
                if isinstance(kept, ast.expr):
                    return kept
                width = sum(isinstance(each, int) for each in array.place.values())
                flat = _combined(ast.Add, _combined(ast.Mult, at[0], width), kept)
            return ast.Subscript(_name(array.name), _node(flat), ast.Load())
        raise self._refused(frame, node)

    # -- expressions

    def _value(self, frame: _Frame, node: ast.expr) -> Any:
        """What an expression is: a known value, or an expression of what is not known."""
        name = f"_{type(node).__name__.lower()}"
        method = getattr(self, name, None)
        if method is None:
            raise self._refused(frame, node)
        return method(frame, node)

    def _constant(self, frame: _Frame, node: ast.Constant) -> Any:  # noqa: ARG002
        return node.value

    def _tuple(self, frame: _Frame, node: ast.Tuple) -> Any:
        return tuple(self._value(frame, each) for each in node.elts)

    def _slice(self, frame: _Frame, node: ast.Slice) -> Any:
        return slice(*(n and self._value(frame, n) for n in (node.lower, node.upper, node.step)))

    def _name(self, frame: _Frame, node: ast.Name) -> Any:
        found = frame.find(node.id)
        return _name(found.name) if isinstance(found, _Pinned) else self._told(found)

    def _told(self, found: Any) -> Any:
        if isinstance(found, Argument):
            self.arguments[found.name] = None
            self._steady.add(found.name)
            return _name(found.name)
        return found

    def _attribute(self, frame: _Frame, node: ast.Attribute) -> Any:
        return self._told(getattr(self._value(frame, node.value), node.attr))

    def _subscript(self, frame: _Frame, node: ast.Subscript) -> Any:
        array, index = self._value(frame, node.value), self._value(frame, node.slice)
        if isinstance(array, Memory | Shared):
            return self._place(frame, node, array, index)
        if not _is_code(index):
            found = array[index]
            return found.item() if isinstance(found, np.generic) else found
        numbers = tuple(float(x) for x in array)
        name = f"table_{len(self.tables)}"
        name = next((k for k, v in self.tables.items() if v == numbers), name)
        self.tables[name] = numbers
        return ast.Subscript(_name(name), index, ast.Load())

    def _binop(self, frame: _Frame, node: ast.BinOp) -> Any:
        return _combined(type(node.op), self._value(frame, node.left), self._value(frame, node.right))

    def _unaryop(self, frame: _Frame, node: ast.UnaryOp) -> Any:
        value = self._value(frame, node.operand)
        if isinstance(node.op, ast.USub):
            return ast.UnaryOp(ast.USub(), value) if _is_code(value) else -value
        # of a mask, which is a yes or no here, `~` is `not`
        return ast.UnaryOp(ast.Not(), value) if _is_code(value) else not value

    def _boolop(self, frame: _Frame, node: ast.BoolOp) -> Any:
        every = isinstance(node.op, ast.And)
        left: list[ast.expr] = []
        for each in node.values:
            value = self._value(frame, each)
            if _is_code(value):
                left.append(value)
            elif bool(value) != every:
                if left:
                    return ast.BoolOp(node.op, [*left, ast.Constant(bool(value))])
                return bool(value)
        if not left:
            return every
        return left[0] if len(left) == 1 else ast.BoolOp(node.op, left)

    def _compare(self, frame: _Frame, node: ast.Compare) -> Any:
        values = [self._value(frame, each) for each in (node.left, *node.comparators)]
        if len(values) > 2:
            values = [self.kept(v) for v in values]
        found = []
        for op, a, b in zip(node.ops, values[:-1], values[1:], strict=True):
            if _is_code(a) or _is_code(b):
                found.append(ast.Compare(_node(a), [op], [_node(b)]))
            elif not _COMPARED[type(op)](a, b):
                return False
        if not found:
            return True
        return found[0] if len(found) == 1 else ast.BoolOp(ast.And(), found)

    def _ifexp(self, frame: _Frame, node: ast.IfExp) -> Any:
        test = self._value(frame, node.test)
        if not _is_code(test):
            return self._value(frame, node.body if test else node.orelse)
        return _chosen(test, self._value(frame, node.body), self._value(frame, node.orelse))

    def _call(self, frame: _Frame, node: ast.Call) -> Any:
        function = self._value(frame, node.func)
        given = [self._value(frame, each) for each in node.args]
        named = {k.arg: self._value(frame, k.value) for k in node.keywords if k.arg}
        if isinstance(function, Kernel):
            if function in self.calls:
                return ast.Call(_name(self.calls[function]), [], [])
            return self._inlined(function.py_func, given, named)
        if isinstance(function, Instructions):
            if function.alone is None:
                raise self._refused(frame, node)
            if isinstance(function.alone, str):
                return ast.Call(_name(function.alone), [_node(x) for x in given], [])
            return self._inlined(function.alone, given, named)
        if isinstance(function, type) and hasattr(function, "_fields"):
            return function(*map(self.kept, given), **{k: self.kept(v) for k, v in named.items()})
        if not any(map(_is_code, given)):
            return function(*given, **named)
        if isinstance(function, FunctionType):
            return self._inlined(function, given, named)
        if function in (min, max):
            a, b = map(self.kept, given)
            return _chosen(ast.Compare(_node(b), [ast.Lt() if function is min else ast.Gt()], [_node(a)]), b, a)
        if function in _MADE_OF_ONE or function is np.isfinite:
            return ast.Call(_name(function.__name__), [_node(x) for x in given], [])
        raise self._refused(frame, node)


_WRITTEN_OUT = 8  # turns of a loop whose turn number is unused that are written out; ours


def _loaded(target: ast.expr) -> ast.expr:
    """What is assigned to, as it is read."""
    if isinstance(target, ast.Name):
        return ast.Name(target.id, ast.Load())
    if isinstance(target, ast.Subscript):
        return ast.Subscript(target.value, target.slice, ast.Load())
    raise ParameterError(f"`{ast.unparse(target)}` is no name and no element of an array")


def _flat(shape: Sequence[int], index: Sequence[Any]) -> Any:
    """The place of an element in the flat array."""
    found: Any = 0
    for size, i in zip(shape, index, strict=True):
        found = _combined(ast.Add, _combined(ast.Mult, found, size), i)
    return found


def _combined(op: type, a: Any, b: Any) -> Any:
    """Two values under an operator; what a 0 or 1 leaves unchanged is left out."""
    if not _is_code(a) and not _is_code(b):
        return _BINARY[op](a, b)
    if op is ast.Add and (_is(a, 0) or _is(b, 0)):
        return b if _is(a, 0) else a
    if op is ast.Sub and _is(b, 0):
        return a
    if op is ast.Mult and (_is(a, 1) or _is(b, 1)):
        return b if _is(a, 1) else a
    if op is ast.Mult and _is(a, -1):
        return ast.UnaryOp(ast.USub(), b)
    if op is ast.Sub and _is(a, 0):
        return ast.UnaryOp(ast.USub(), b)
    return ast.BinOp(_node(a), op(), _node(b))


def _is(value: Any, number: int) -> bool:
    return not _is_code(value) and not isinstance(value, bool) and value == number


def _chosen(test: Any, yes: Any, no: Any) -> Any:
    """One of two values."""
    if not _is_code(test):
        return yes if test else no
    return ast.IfExp(test, _node(yes), _node(no))
