"""Tables of a scene file, read into a dataclass whose fields are options (`system.option`).

A key is the name of a field's option; its unit, its limits and its default are the option's, and what the
dataclass itself refuses is told with its place in the file. The type of a field says what stands in the file:

=====================  ==================================================================================
type of a field        in the file
=====================  ==================================================================================
`float`                a number in the option's unit, a text with a unit (`"20ms"`), or one of its words
`int`, `str`, `bool`   a whole number, a text, or true or false
`Literal[...]`         one of these
`tuple[float, float]`  a list of so many
`tuple[Point, ...]`    a list of at least `fewest`
a dataclass            a table
`tuple[Block, ...]`    an array of tables, where `Block` is a dataclass
=====================  ==================================================================================

Of a union the first type that the value can be is taken; None is never written, a key is left out.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import MISSING, is_dataclass
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

from circuits.checks import require_real
from circuits.errors import ParameterError, meant
from system.option import Setting, settings

LARGEST = 1e9  # of a number, in its unit; ours: geometry overflows far beyond
_COUNTS = {2: "two", 3: "three"}

T = TypeVar("T")


def read_table(kind: type[T], content: Any, path: str = "") -> T:
    """A value of the dataclass `kind`, of a table as TOML gives it.

    Parameters
    ----------
    content : the table, a `dict` unless the file has something else there.
    path : the table's place in its file, such as `block[0]`; empty for the whole file.

    Raises
    ------
    ParameterError
        There is no table, a key is unknown or missing, or a value is not what its option takes: one line of
        place, value, unit and rule.
    """
    known = settings(kind)  # type: ignore[arg-type]  # a type is hashable
    if not isinstance(content, dict):
        raise ParameterError(f"{path}: {content!r}, must be a table of {', '.join(known)}")
    for name in content:
        if name not in known:
            raise _unknown(_joined(path, name), name, known)
    found = {}
    for name, one in known.items():
        if name in content:
            found[one.field] = _value(one, one.kind, content[name], _joined(path, name))
        elif one.default is MISSING:
            raise ParameterError(f"{_joined(path, name)}: missing, must be given")
    try:
        return kind(**found)
    except ParameterError as error:
        raise ParameterError(_joined(path, str(error))) from None


def _value(one: Setting, kind: Any, value: Any, path: str) -> Any:
    """A value of the type `kind`; `one` has unit and limits of the numbers in it."""
    if get_origin(kind) in (Union, UnionType):
        kind = next((each for each in get_args(kind) if _can_be(each, value)), get_args(kind)[0])
    if get_origin(kind) is tuple:
        return _list(one, get_args(kind), value, path)
    if is_dataclass(kind) and isinstance(kind, type):
        return read_table(kind, value, path)
    if kind is float:
        return _number(one, value, path)
    for simple, noun in ((bool, "true or false"), (int, "a whole number"), (str, "text")):
        if kind is simple and type(value) is not simple:
            raise ParameterError(f"{path}: {value!r}, must be {noun}")
    one.check(value, path)
    return value


def _number(one: Setting, value: Any, path: str) -> float:
    """A number in the field's unit of one in the option's, or of a word."""
    option = one.option
    if option.words and isinstance(value, str):
        if value not in option.words:
            raise ParameterError(f"{path}: {value}, must be one of {', '.join(option.words)}, or a number")
        return option.words[value]
    if option.unit and isinstance(value, str):
        value = one.read(value, path)
    require_real(path, value, option.unit or "")
    if LARGEST < abs(value) < float("inf"):
        raise ParameterError(f"{path}: must be within {LARGEST:g} either way; correct it")
    one.check(value, path)
    return float(value if option.to_field is None else option.to_field(value))


def _list(one: Setting, kinds: tuple[Any, ...], value: Any, path: str) -> tuple[Any, ...]:
    """A tuple of so many types, or of any number of one."""
    inner, many = kinds[0], kinds[-1] is Ellipsis
    if is_dataclass(inner) and not isinstance(value, list):
        raise ParameterError(f"{path}: must be written as [[{path}]], one table each")
    if not many and not (isinstance(value, list) and len(value) == len(kinds)):
        raise ParameterError(f"{path}: {value!r}, must be {_COUNTS[len(kinds)]} numbers")
    if many and not (isinstance(value, list) and len(value) >= one.option.fewest):
        raise ParameterError(f"{path}: {value!r}, must be a list of at least {one.option.fewest}")
    return tuple(_value(one, inner, each, f"{path}[{k}]") for k, each in enumerate(value))


def _can_be(kind: Any, value: Any) -> bool:
    """Whether a value of a file may be of a type, which stands in a union."""
    if get_origin(kind) is Literal:
        return any(value is each or (isinstance(value, str) and value == each) for each in get_args(kind))
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if get_origin(kind) is tuple:
        return isinstance(value, list)
    return isinstance(value, dict) if is_dataclass(kind) else type(value) is kind


def _unknown(path: str, name: str, known: Iterable[str]) -> ParameterError:
    guess = meant(name, known) or f"; known are {', '.join(known)}"
    return ParameterError(f"{path}: unknown key{guess}")


def _joined(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name
