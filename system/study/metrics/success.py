"""Success in a user's words: `collided == 0 and distance_m >= 20`.

    success    := both { "or" both }
    both       := each { "and" each }
    each       := "not" each | "(" success ")" | number [ comparison number ]

A number is a metric of the system or written down, in the unit that ends the metric's name: `20`, `20m`. A
metric alone is true where it is 1, as those that say yes or no. Comparisons are `<`, `<=`, `==`, `!=`, `>=`
and `>`. lark parses the text; nothing of it is ever evaluated as code. A metric that is not defined in a run
makes that run no success, whatever the rest says.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError, UnknownNameError, unknown_name
from circuits.units import parse_quantity

GRAMMAR = r"""
?success   : both ("or" both)*               -> either
?both      : each ("and" each)*              -> both
?each      : "not" each                      -> negated
           | "(" success ")"
           | value COMPARISON value          -> compared
           | NAME                            -> said
?value     : NAME | NUMBER

NAME       : /(?!(and|or|not)\b)[A-Za-z_]\w*/
NUMBER     : /-?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?([A-Za-z%\/\u00b5\u03bc]+)?/
COMPARISON : "<=" | ">=" | "==" | "!=" | "<" | ">"
%ignore /\s+/
"""
_COMPARISONS: Mapping[str, Callable[[F64, F64], Bools]] = {
    "<": operator.lt, "<=": operator.le, "==": operator.eq, "!=": operator.ne, ">=": operator.ge,
    ">": operator.gt,
}  # fmt: skip
_HELP = 'write as "collided == 0 and distance_m >= 20"'
_LONGEST = 1000  # characters of a text; ours


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a run must be to count as a success.

    text : the user's words.
    metrics : metrics that it asks for, each once.
    """

    text: str
    metrics: tuple[str, ...]
    tree: Tree[Token]
    units: Mapping[str, str]

    def met(self, values: Mapping[str, F64]) -> Bools:
        """Say of each run whether it is a success, bool[n], from its metrics by name, float64[n] in SI."""
        known = np.all([~np.isnan(values[name]) for name in self.metrics], axis=0)
        return np.asarray(known & self._holds(self.tree, values))

    def met_by(self, summary: Mapping[str, Any]) -> bool:
        """Say whether one run is a success, from its summary, where None is a metric that is not defined."""
        values = {name: summary[name] for name in self.metrics}
        known = {k: np.array([np.nan if v is None else float(v)]) for k, v in values.items()}
        return bool(self.met(known)[0])

    def undefined(self, values: Mapping[str, F64]) -> Bools:
        """Say of each run whether a metric is not defined in it, bool[n]."""
        return np.asarray(np.any([np.isnan(values[name]) for name in self.metrics], axis=0))

    def _holds(self, node: Tree[Token], values: Mapping[str, F64]) -> Bools:
        if node.data == "said":
            return np.asarray(values[str(node.children[0])] == 1.0)
        if node.data == "compared":
            left, sign, right = (child for child in node.children if isinstance(child, Token))
            unit = next((self.units[t] for t in (left, right) if t.type == "NAME"), "")
            return _COMPARISONS[sign](self._value(left, unit, values), self._value(right, unit, values))
        parts = [self._holds(child, values) for child in node.children if isinstance(child, Tree)]
        if node.data == "negated":
            return ~parts[0]
        return np.asarray(np.all(parts, axis=0) if node.data == "both" else np.any(parts, axis=0))

    def _value(self, token: Token, unit: str, values: Mapping[str, F64]) -> F64:
        if token.type == "NAME":
            return values[str(token)]
        return np.asarray(_number(token, unit))


def read_success(text: str, units: Mapping[str, str]) -> Wanted:
    """Read a text.

    Parameters
    ----------
    text
        The text, as the module says.
    units
        Unit of each metric that it may name; empty for a plain number.

    Raises
    ------
    ParameterError
        The text is none, or compares two numbers, or a number has another unit than the metric.
    UnknownNameError
        It names a metric that the system does not have.
    """
    tree = _parsed(text)
    names = [str(t) for t in tree.scan_values(lambda t: isinstance(t, Token) and t.type == "NAME")]
    for name in names:
        if name not in units:
            raise UnknownNameError(f"success: {unknown_name('metric', name, list(units))}")
    for each in tree.find_data("compared"):
        _check_compared(text, [child for child in each.children if isinstance(child, Token)], units)
    return Wanted(text, tuple(dict.fromkeys(names)), tree, units)


def _check_compared(text: str, tokens: Sequence[Token], units: Mapping[str, str]) -> None:
    left, _, right = tokens
    named = [t for t in (left, right) if t.type == "NAME"]
    if not named:
        raise _wrong(text, left.column or 1, f"{left} beside {right}, must compare a metric")
    for token in (left, right):
        if token.type == "NUMBER":
            _number(token, units[named[0]])
    if len({units[t] for t in named}) > 1:
        raise _wrong(text, left.column or 1, f"{left} beside {right}, must be of one unit")


def _number(token: Token, unit: str) -> float:
    """A number as it is written, plain or in the metric's unit."""
    try:
        return float(token)
    except ValueError:
        return parse_quantity(str(token), unit, "success")


def _parsed(text: str) -> Tree[Token]:
    if len(text) > _LONGEST:
        raise _wrong(text[:20], 1, f"{len(text)} characters, must be at most {_LONGEST}")
    try:
        return _parser().parse(text)
    except UnexpectedToken as error:
        at_end = error.token.type == "$END"
        column = len(text) + 1 if at_end else error.column
        raise _wrong(text, column, f"{'the end' if at_end else error.token}, must be otherwise") from None
    except UnexpectedCharacters as error:
        raise _wrong(text, error.column, f"{error.char}, must be otherwise") from None
    except UnexpectedInput as error:  # pragma: no cover - lark has no other
        raise _wrong(text, 1, " ".join(str(error).split())) from None


def _wrong(text: str, column: int, what: str) -> ParameterError:
    return ParameterError(f'success: "{text}", column {column}: {what}; {_HELP}')


@cache
def _parser() -> Lark:
    return Lark(GRAMMAR, start="success", parser="lalr", propagate_positions=True, maybe_placeholders=False)
