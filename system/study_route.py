"""What a study lets a system do: options of `noctule run`, by --param NAME=VALUE, and --duration.

A system names those that its study takes, each with a reader of its text; all others are refused by name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from circuits.errors import ParameterError
from circuits.units import parse_quantity

Reader = Callable[[str, str], Any]  # text, name of the option
Readers = Mapping[str, Reader]

YES, NO = ("yes", "true", "1"), ("no", "false", "0")


def words(text: str, _: str) -> str:
    """Text as it is."""
    return text


def number(text: str, option: str) -> float:
    """A number without a unit."""
    return parse_quantity(text, "", option)


def seconds(text: str, option: str) -> float:
    """A time, s."""
    return parse_quantity(text, "s", option)


def metres(text: str, option: str) -> float:
    """A length, m."""
    return parse_quantity(text, "m", option)


def whole(text: str, option: str) -> int:
    """A whole number."""
    try:
        return int(text)
    except ValueError:
        raise ParameterError(f'{option}: "{text}", must be a whole number; write as in {option}=12') from None


def switch(text: str, option: str) -> bool:
    """Yes or no."""
    if text.lower() not in YES + NO:
        raise ParameterError(f'{option}: "{text}", must be yes or no')
    return text.lower() in YES


def read_route(system: str, route: Mapping[str, Any], readers: Readers) -> dict[str, Any]:
    """Values of the options that a study takes; those that are not text were read before.

    Raises `ParameterError` for one that it does not take, or whose text is none.
    """
    found = {}
    for name, value in route.items():
        option = f"--{shown(name)}"
        if name not in readers:
            known = ", ".join(shown(n) for n in readers)
            raise ParameterError(f"{option}: not an option of {system}, its study has {known}; leave it out")
        found[name] = readers[name](value, option) if isinstance(value, str) else value
    return found


def with_params(route: Mapping[str, Any], params: Sequence[str]) -> dict[str, Any]:
    """Options with those of `NAME=VALUE`; raises `ParameterError` for no such text, or a second one."""
    found = dict(route)
    for text in params:
        name, equals, value = text.partition("=")
        key = name.strip().replace("-", "_")
        if not (equals and key and value):
            raise ParameterError(f'--param: "{text}", must be NAME=VALUE, as in --param forest=open')
        if key in found:
            raise ParameterError(f"--param: {shown(key)}, is given twice; leave one out")
        found[key] = value.strip()
    return found


def shown(name: str) -> str:
    """As the command line has it."""
    return name.replace("_", "-")
