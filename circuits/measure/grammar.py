r"""Text of a measure -> its syntax tree.

lark parses it: a small library without dependencies of its own, whose grammar is the text below, and whose
errors know their column.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, TypeAlias

from circuits.catalogue import later
from circuits.errors import ParameterError

if TYPE_CHECKING:
    import lark
else:
    lark = later("lark")  # runs without measures do not wait for it

GRAMMAR = r"""
measure   : NAME "=" sum                     -> named
          | sum                              -> unnamed
?sum      : product
          | sum "+" product                  -> add
          | sum "-" product                  -> subtract
?product  : signed
          | product "*" signed               -> multiply
          | product "/" signed               -> divide
?signed   : power
          | "-" signed                       -> negate
?power    : atom
          | atom ("^" | "**") signed         -> raise
?atom     : NUMBER                           -> number
          | NAME                             -> name
          | NAME "(" [argument ("," argument)*] ")"  -> call
          | VOLTAGE NODE ["," NODE] ")"      -> voltage
          | CURRENT NODE ")"                 -> current
          | "(" sum ")"
?argument : NAME "=" sum                     -> keyword
          | sum

NAME      : /[A-Za-z_]\w*(\[\d+(,\d+)*\])?(\.[A-Za-z_]\w*(\[\d+(,\d+)*\])?)*/
NODE      : /[^\s(),\[\]]+(\[\d+(,\d+)*\][^\s(),\[\]]*)*/
NUMBER    : /(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?[A-Za-z\u00b5\u03bc]*/
VOLTAGE.2 : /[vV]\s*\(/
CURRENT.2 : /[iI]\s*\(/
%ignore /\s+/
"""

_WORDS = {
    "NAME": "a name", "NUMBER": "a number", "NODE": "a path", "VOLTAGE": "v(node)", "CURRENT": "i(device)",
    "LPAR": "(", "RPAR": ")", "COMMA": "a comma", "EQUAL": "=", "SLASH": "an operator", "$END": "the end",
}  # fmt: skip
_VALUE = {"NAME", "NUMBER", "LPAR"}  # what a value can begin with; what else it can is left unsaid
_LONGEST = 4000  # characters of a measure; ours
_SHOWN = 60  # of a measure in an error

Node: TypeAlias = "lark.Tree[lark.Token]"


class MeasureError(ParameterError):
    """A measure that cannot be read: its text, the column that is wrong, and what to write."""

    def __init__(self, text: str, column: int, what: str) -> None:
        """Make the error of the measure `text` at a column, counted from 1."""
        super().__init__(f'measure: "{_marked(text, column)}", column {column}: {what}')


def parse(text: str) -> Node:
    """Parse a measure; raises `MeasureError`."""
    if len(text) > _LONGEST:
        raise MeasureError(text, _LONGEST, f"{len(text)} characters, must be at most {_LONGEST}; part it")
    try:
        return _parser().parse(text)
    except lark.UnexpectedToken as error:
        column = error.column if error.token.type != "$END" else len(text) + 1
        found = "the end" if error.token.type == "$END" else str(error.token)
        raise MeasureError(text, column, f"{found}, must be {_alternatives(error.accepts)}") from None
    except lark.UnexpectedCharacters as error:
        what = f"{error.char}, must be {_alternatives(error.allowed or ())}"
        raise MeasureError(text, error.column, what) from None
    except lark.UnexpectedInput as error:  # pragma: no cover - lark has no other
        raise MeasureError(text, 1, " ".join(str(error).split())) from None


def currents_in(texts: Iterable[str]) -> tuple[str, ...]:
    """Return the names in the `i(NAME)` of measures, each once; none of what cannot be read."""
    found: dict[str, None] = {}
    for text in texts:
        try:
            tree = parse(text)
        except MeasureError:
            continue
        found |= dict.fromkeys(str(part.children[-1]) for part in tree.find_data("current"))
    return tuple(found)


def column_of(node: Node | lark.Token) -> int:
    """Column at which a part of a measure begins, from 1."""
    return (node.column if isinstance(node, lark.Token) else node.meta.column) or 1


@cache
def _parser() -> lark.Lark:
    return lark.Lark(
        GRAMMAR, start="measure", parser="lalr", propagate_positions=True, maybe_placeholders=False
    )


def _alternatives(names: Iterable[object]) -> str:
    """What may stand there, in words."""
    found: set[object] = set(names)
    if found >= _VALUE:
        found &= {"NAME", "NUMBER"}
    if "SLASH" in found:
        found -= {"LPAR", "EQUAL"}
    words = [word for name, word in _WORDS.items() if name in found]
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words) or "something else"


def _marked(text: str, column: int) -> str:
    """The text around a column, with `>` before it."""
    low = max(0, min(column - 1 - _SHOWN // 2, len(text) - _SHOWN))
    high = min(len(text), low + _SHOWN)
    at = min(column - 1, len(text))
    before, after = text[low:at], text[at:high]
    return f"{'...' if low else ''}{before}>{after}{'...' if high < len(text) else ''}"
