"""A program of `circuits.machine_code.specialised` as C, for a processor's compiler or a graphics processor's."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import final

from circuits.errors import ParameterError
from circuits.machine_code.specialised import Program

REAL, WHOLE = "double", "long long"

_OPERATORS: Mapping[type, str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.LShift: "<<", ast.RShift: ">>",
    ast.BitAnd: "&", ast.BitOr: "|", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==",
    ast.NotEq: "!=", ast.And: "&&", ast.Or: "||", ast.USub: "-", ast.Not: "!",
}  # fmt: skip
_CALLED: Mapping[str, tuple[str, str]] = {
    "abs": ("fabs", REAL), "sqrt": ("sqrt", REAL), "isfinite": ("isfinite", WHOLE), "int": ("(long long)", WHOLE),
    "float": ("(double)", REAL), "bits_of": ("bits_of", WHOLE), "of_bits": ("of_bits", REAL),
}  # fmt: skip


def c_text(program: Program, wholes: Sequence[str] = ()) -> tuple[list[str], list[str]]:
    """Lines that declare what a program has for itself, and its statements.

    wholes: names of whole numbers that it has from outside, functions without arguments among them.
    """
    return _Text(program, wholes).lines()


@final
class _Text:
    """The text on the way."""

    def __init__(self, program: Program, wholes: Sequence[str]) -> None:
        self._program = program
        self._kind = {"same": REAL} | dict.fromkeys(wholes, WHOLE)
        self._kind |= {m.name: WHOLE for m in (*program.memory, *program.shared) if m.whole}
        known = {m.name for m in (*program.memory, *program.shared)} | set(program.arguments)
        self._kind |= {name: REAL for name in (known | set(program.tables)) - set(self._kind)}

    def lines(self) -> tuple[list[str], list[str]]:
        """Declarations and statements."""
        self._settle()
        body = [line for statement in self._program.body for line in self._statement(statement)]
        tables = [
            f"const {REAL} {name}[] = {{{', '.join(map(_number, values))}}};"
            for name, values in self._program.tables.items()
        ]
        arrays = [f"{self._kind[m.name]} {m.name}[{m.size}];" for m in self._program.memory]
        numbers = [f"{self._kind[v]} {v};" for v in self._program.variables if v in self._kind]
        return tables + arrays + numbers, body

    def _settle(self) -> None:
        """Find of each variable whether it is a whole number: so where it is given nothing else."""
        given: dict[str, list[ast.expr]] = {}
        for node in ast.walk(ast.Module(self._program.body, [])):
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                given.setdefault(node.targets[0].id, []).append(node.value)
            elif isinstance(node, ast.For) and isinstance(node.target, ast.Name):
                self._kind[node.target.id] = WHOLE
        self._kind |= dict.fromkeys(given, WHOLE)
        changed = True
        while changed:
            changed = False
            for name, values in given.items():
                if self._kind[name] == WHOLE and any(self._kind_of(v) == REAL for v in values):
                    self._kind[name], changed = REAL, True

    def _kind_of(self, e: ast.expr) -> str:
        if isinstance(e, ast.Constant):
            return REAL if isinstance(e.value, float) else WHOLE
        if isinstance(e, ast.Name):
            return self._kind[e.id]
        if isinstance(e, ast.Subscript):
            return self._kind_of(e.value)
        if isinstance(e, ast.Compare | ast.BoolOp) or (isinstance(e, ast.UnaryOp) and isinstance(e.op, ast.Not)):
            return WHOLE
        if isinstance(e, ast.UnaryOp):
            return self._kind_of(e.operand)
        if isinstance(e, ast.Call) and isinstance(e.func, ast.Name):
            return _CALLED[e.func.id][1] if e.func.id in _CALLED else self._kind[e.func.id]
        parts = (e.left, e.right) if isinstance(e, ast.BinOp) else (e.body, e.orelse) if isinstance(e, ast.IfExp) else ()
        return REAL if isinstance(e, ast.BinOp) and isinstance(e.op, ast.Div) or REAL in map(self._kind_of, parts) else WHOLE

    def _statement(self, s: ast.stmt) -> Iterator[str]:
        if isinstance(s, ast.Assign):
            yield f"{self._text(s.targets[0])} = {self._text(s.value)};"
        elif isinstance(s, ast.If):
            yield f"if ({self._text(s.test)}) {{"
            yield from self._block(s.body)
            if s.orelse:
                yield "} else {"
                yield from self._block(s.orelse)
            yield "}"
        elif isinstance(s, ast.While):
            yield "for (;;) {"
            yield from self._block(s.body)
            yield "}"
        elif isinstance(s, ast.For) and isinstance(s.iter, ast.Call):
            turn, (count,) = self._text(s.target), s.iter.args
            yield f"for ({turn} = 0; {turn} < {self._text(count)}; {turn}++) {{"
            yield from self._block(s.body)
            yield "}"
        elif isinstance(s, ast.Break | ast.Continue | ast.Return):
            yield f"{type(s).__name__.lower()};"
        elif not isinstance(s, ast.Pass):
            raise ParameterError(f"`{ast.unparse(s)}` has no form in C")

    def _block(self, body: Sequence[ast.stmt]) -> Iterator[str]:
        return (line for s in body for line in self._statement(s))

    def _text(self, e: ast.expr) -> str:
        if isinstance(e, ast.Constant):
            return _number(e.value) if isinstance(e.value, float) else str(int(e.value))  # type: ignore[call-overload]
        if isinstance(e, ast.Name):
            return e.id
        if isinstance(e, ast.Subscript):
            return f"{self._text(e.value)}[{self._text(e.slice)}]"
        if isinstance(e, ast.BinOp) and type(e.op) in _OPERATORS:
            left = self._text(e.left)
            if isinstance(e.op, ast.Div):
                left = f"({REAL}) {left}"
            return f"({left} {_OPERATORS[type(e.op)]} {self._text(e.right)})"
        if isinstance(e, ast.UnaryOp):
            return f"({_OPERATORS[type(e.op)]}{self._text(e.operand)})"
        if isinstance(e, ast.Compare):
            return f"({self._text(e.left)} {_OPERATORS[type(e.ops[0])]} {self._text(e.comparators[0])})"
        if isinstance(e, ast.BoolOp):
            return "(" + f" {_OPERATORS[type(e.op)]} ".join(map(self._text, e.values)) + ")"
        if isinstance(e, ast.IfExp):
            return f"({self._text(e.test)} ? {self._text(e.body)} : {self._text(e.orelse)})"
        if isinstance(e, ast.Call) and isinstance(e.func, ast.Name):
            called = _CALLED[e.func.id][0] if e.func.id in _CALLED else e.func.id
            return f"{called}({', '.join(map(self._text, e.args))})"
        raise ParameterError(f"`{ast.unparse(e)}` has no form in C")


def _number(value: float) -> str:
    return repr(value) if math.isfinite(value) else "NAN" if math.isnan(value) else ("-" if value < 0 else "") + "INFINITY"
