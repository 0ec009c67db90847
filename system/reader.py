"""Readers of options: each makes a value of a text, and that of a quantity states its unit.

A study takes those that its system names, others are refused by name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from circuits.errors import ParameterError
from circuits.units import parse_quantity

Reader = Callable[[str, str], Any]  # text, name of the option

YES, NO = ("yes", "true", "1"), ("no", "false", "0")


@dataclass(frozen=True, slots=True)
class In:
    """Reader of a quantity in `unit`; of a plain number where that is empty."""

    unit: str

    def __call__(self, text: str, option: str) -> float:
        """The value in `unit`."""
        return parse_quantity(text, self.unit, option)


number, seconds, metres = In(""), In("s"), In("m")


def words(text: str, _: str) -> str:
    """Return a text as it is."""
    return text


def whole(text: str, option: str) -> int:
    """Return the whole number of a text; raises `ParameterError` for another text."""
    try:
        return int(text)
    except ValueError:
        raise ParameterError(
            f'{option}: "{text}", must be a whole number; write as in `{option}=12`'
        ) from None


def switch(text: str, option: str) -> bool:
    """Return whether a text says yes or no; raises `ParameterError` for another text."""
    if text.lower() not in YES + NO:
        raise ParameterError(f'{option}: "{text}", must be yes or no')
    return text.lower() in YES


def place(text: str, option: str) -> tuple[float, float]:
    """Return the place of a text `X,Y`, m; raises `ParameterError` for another text."""
    x, comma, y = text.partition(",")
    if not comma:
        raise ParameterError(f'{option}: "{text}", must be X,Y; write as in `{option}=40m,25m`')
    return metres(x, option), metres(y, option)


def with_params(route: Mapping[str, Any], params: Sequence[str]) -> dict[str, Any]:
    """Options with those of `NAME=VALUE`; raises `ParameterError` for no such text, or a second one."""
    found = dict(route)
    for text in params:
        name, equals, value = text.partition("=")
        key = name.strip().replace("-", "_")
        if not (equals and key and value):
            raise ParameterError(f'param: "{text}", must be NAME=VALUE, as in `param=forest=open`')
        if key in found:
            raise ParameterError(f"param: {shown(key)}, is given twice; leave one out")
        found[key] = value.strip()
    return found


def shown(name: str) -> str:
    """Return a name as the command line has it, with hyphens."""
    return name.replace("_", "-")
