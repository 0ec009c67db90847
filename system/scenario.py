"""Scenarios of systems from Python: by their fields, or by options as the command line has them.

A field may be made of options (`bat` of `vmax` and `ping_rate`). It is given whole or by these, not both; a
name that is neither field nor option is refused with those that are taken.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, TypeVar

from circuits.errors import ParameterError, UnknownNameError

S = TypeVar("S")
Read = Callable[[Mapping[str, Any]], dict[str, Any]]  # options to fields
Parts = Mapping[str, tuple[str, ...]]  # a field, and the options that it is made of


def scenario_of(
    system: str, scenario: type[S], given: Mapping[str, Any], read: Read = dict, parts: Parts | None = None
) -> S:
    """A scenario of a system, its fields and options `given` by name.

    Parameters
    ----------
    scenario : dataclass of the system's scenarios.
    read : makes fields of options.
    parts : fields that are made of options.

    Raises
    ------
    UnknownNameError
        A name that is not taken; the text has all that are.
    ParameterError
        A field is given whole and in part, or as something else than what it is; and what `read` and the
        scenario refuse.
    """
    known, made = {f.name: f for f in fields(scenario)}, parts or {}  # type: ignore[arg-type]
    taken = [*known, *(option for options in made.values() for option in options if option not in known)]
    for name in given:
        if name not in taken:
            raise _not_taken(f"{system}.scenario.{name}", name, taken)
    whole = {name: value for name, value in given.items() if name in made}
    for name in whole:
        _check_apart(system, name, given, made[name])
    for name, value in given.items():
        if name in known:
            _check_kind(f"{system}.scenario.{name}", known[name], value)
    rest = read({name: value for name, value in given.items() if name not in whole})
    return scenario(**{**rest, **whole})


def _not_taken(path: str, name: str, taken: list[str]) -> UnknownNameError:
    near = difflib.get_close_matches(name, taken, n=1)
    guess = f"; did you mean {near[0]}?" if near else ";"
    return UnknownNameError(f"{path}: unknown{guess} taken are {', '.join(sorted(taken))}")


def _check_apart(system: str, name: str, given: Mapping[str, Any], options: tuple[str, ...]) -> None:
    for option in options:
        if option in given:
            value = f"{system}.scenario.{option}: {given[option]}"
            raise ParameterError(f"{value}, not with {name}, which has its own; leave one out")


def _check_kind(path: str, field: Field[Any], value: Any) -> None:
    """Refuse something else where a field is data of a kind of its own."""
    default = field.default if field.default_factory is MISSING else field.default_factory()
    if is_dataclass(default) and not isinstance(value, type(default)):
        kind = type(default).__name__
        raise ParameterError(f"{path}: {value!r}, must be a {kind}; write as in {field.name}={kind}()")
