"""Programs (`circuits.programs.specialised`) as C, for a graphics processor's compiler or another's."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import final

from circuits.errors import ParameterError
from circuits.programs.program import Memory, Program, Shared

REAL, WHOLE = "double", "long long"

_OPERATORS: Mapping[type, str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.LShift: "<<", ast.RShift: ">>",
    ast.BitAnd: "&", ast.BitOr: "|", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==",
    ast.NotEq: "!=", ast.And: "&&", ast.Or: "||", ast.USub: "-", ast.Not: "!",
}  # fmt: skip
_CALLED: Mapping[str, tuple[str, str]] = {
    "abs": ("fabs", REAL), "sqrt": ("sqrt", REAL), "isfinite": ("isfinite", WHOLE),
    "int": (f"({WHOLE})", WHOLE), "bool": (f"({WHOLE})", WHOLE), "float": (f"({REAL})", REAL),
    "bits_of": ("bits_of", WHOLE), "of_bits": ("of_bits", REAL),
}  # fmt: skip
"""What a program calls, as C has it, and what kind of number it gives."""


def c_text(program: Program, wholes: Sequence[str] = ()) -> tuple[list[str], list[str]]:
    """Lines that declare what a program has for itself, and its statements.

    wholes: names of whole numbers that it has from outside, functions without arguments among them.
    """
    return _Text(program, wholes).lines()


def functions_text(program: Program, mark: str) -> list[str]:
    """Functions that a program calls, each behind a mark."""
    found: list[str] = []
    for name, inner, given in program.functions:
        text, made = _Text(inner, ()), f"given_by_{name}"
        declared, body = text.lines()
        numbers = " ".join(f"{REAL} x{k};" for k in range(len(given)))
        arguments = ", ".join(f"{REAL} {a}" for a in inner.arguments)
        values = ", ".join(map(text.expression, given))
        found += [f"struct {made} {{ {numbers} }};", f"{mark} {made} {name}({arguments}) {{"]
        found += [*declared, *body, f"return {{{values}}};", "}"]
    return found


@final
class _Text:
    """The text on the way."""

    def __init__(self, program: Program, wholes: Sequence[str]) -> None:
        self._program = program
        arrays: list[Memory | Shared] = [*program.memory, *program.shared]
        self._kind = dict.fromkeys(("same", *program.arguments, *program.tables), REAL)
        self._kind |= {a.name: WHOLE if a.whole else REAL for a in arrays} | dict.fromkeys(wholes, WHOLE)
        self._settle()

    def lines(self) -> tuple[list[str], list[str]]:
        """Declarations and statements."""
        program = self._program
        declared = [
            f"const {REAL} {name}[] = {{{', '.join(map(_number, values))}}};"
            for name, values in program.tables.items()
        ]
        declared += [f"{self._kind[m.name]} {m.name}[{m.size}];" for m in program.memory]
        declared += [f"{self._kind[v]} {v};" for v in program.variables if v in self._kind]
        return declared, list(self._block(program.body))

    def _settle(self) -> None:
        """Find of each variable whether it is a whole number: so where it is given nothing else."""
        given: dict[str, list[ast.expr]] = {}
        for node in ast.walk(ast.Module(self._program.body, [])):
            if isinstance(node, ast.For) and isinstance(node.target, ast.Name):
                self._kind[node.target.id] = WHOLE
            elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                given.setdefault(node.targets[0].id, []).append(node.value)
            elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
                self._kind |= {t.id: REAL for t in node.targets[0].elts if isinstance(t, ast.Name)}
        self._kind |= dict.fromkeys(given, WHOLE)
        changed = True
        while changed:
            changed = False
            for name, values in given.items():
                if self._kind[name] == WHOLE and any(map(self._is_real, values)):
                    self._kind[name], changed = REAL, True

    def _is_real(self, e: ast.expr) -> bool:
        """Whether an expression is no whole number."""
        if isinstance(e, ast.Constant):
            return isinstance(e.value, float)
        if isinstance(e, ast.Name | ast.Subscript):
            return self._kind[_name_in(e)] == REAL
        if isinstance(e, ast.Call):
            name = _name_in(e.func)
            return (_CALLED[name][1] if name in _CALLED else self._kind[name]) == REAL
        if isinstance(e, ast.BinOp):
            return isinstance(e.op, ast.Div) or self._is_real(e.left) or self._is_real(e.right)
        if isinstance(e, ast.IfExp):
            return self._is_real(e.body) or self._is_real(e.orelse)
        return isinstance(e, ast.UnaryOp) and isinstance(e.op, ast.USub) and self._is_real(e.operand)

    def _block(self, body: Sequence[ast.stmt]) -> Iterator[str]:
        return (line for s in body for line in self._statement(s))

    def _statement(self, s: ast.stmt) -> Iterator[str]:
        if isinstance(s, ast.Assign):
            yield from self._assignment(s.targets[0], s.value)
        elif isinstance(s, ast.If):
            yield f"if ({self.expression(s.test)}) {{"
            yield from self._block(s.body)
            if s.orelse:
                yield "} else {"
                yield from self._block(s.orelse)
            yield "}"
        elif isinstance(s, ast.While):
            yield from ("for (;;) {", *self._block(s.body), "}")
        elif isinstance(s, ast.For) and isinstance(s.iter, ast.Call):
            turn, (count,) = self.expression(s.target), map(self.expression, s.iter.args)
            yield from (f"for ({turn} = 0; {turn} < {count}; {turn}++) {{", *self._block(s.body), "}")
        elif isinstance(s, ast.Break | ast.Continue | ast.Return):
            yield f"{type(s).__name__.lower()};"
        elif not isinstance(s, ast.Pass):
            raise ParameterError(f"`{ast.unparse(s)}` has no form in C")

    def _assignment(self, target: ast.expr, value: ast.expr) -> Iterator[str]:
        if not isinstance(target, ast.Tuple):
            yield f"{self.expression(target)} = {self.expression(value)};"
            return
        yield f"{{ const auto given = {self.expression(value)};"
        for k, each in enumerate(target.elts):
            yield f"{self.expression(each)} = given.x{k};"
        yield "}"

    def expression(self, e: ast.expr) -> str:
        """An expression, within brackets where it has parts."""
        method = getattr(self, f"_{type(e).__name__.lower()}", None)
        if method is None:
            raise ParameterError(f"`{ast.unparse(e)}` has no form in C")
        return str(method(e))

    def _constant(self, e: ast.Constant) -> str:
        if isinstance(e.value, float):
            return _number(e.value)
        return f"{e.value:d}" if isinstance(e.value, int) else "0"

    def _name(self, e: ast.Name) -> str:
        return e.id

    def _subscript(self, e: ast.Subscript) -> str:
        return f"{self.expression(e.value)}[{self.expression(e.slice)}]"

    def _binop(self, e: ast.BinOp) -> str:
        real = f"({REAL}) " if isinstance(e.op, ast.Div) else ""  # of whole numbers too
        return f"({real}{self.expression(e.left)} {_OPERATORS[type(e.op)]} {self.expression(e.right)})"

    def _unaryop(self, e: ast.UnaryOp) -> str:
        return f"({_OPERATORS[type(e.op)]}{self.expression(e.operand)})"

    def _compare(self, e: ast.Compare) -> str:
        (other,) = e.comparators
        return f"({self.expression(e.left)} {_OPERATORS[type(e.ops[0])]} {self.expression(other)})"

    def _boolop(self, e: ast.BoolOp) -> str:
        return "(" + f" {_OPERATORS[type(e.op)]} ".join(map(self.expression, e.values)) + ")"

    def _ifexp(self, e: ast.IfExp) -> str:
        return f"({self.expression(e.test)} ? {self.expression(e.body)} : {self.expression(e.orelse)})"

    def _call(self, e: ast.Call) -> str:
        name = _name_in(e.func)
        called = _CALLED[name][0] if name in _CALLED else name
        return f"{called}({', '.join(map(self.expression, e.args))})"


def _name_in(e: ast.expr) -> str:
    """The name of a variable, or of the array that an element is of."""
    if isinstance(e, ast.Subscript):
        return _name_in(e.value)
    if isinstance(e, ast.Name):
        return e.id
    raise ParameterError(f"`{ast.unparse(e)}` has no name in C")


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    return repr(value) if math.isfinite(value) else "INFINITY" if value > 0 else "(-INFINITY)"
