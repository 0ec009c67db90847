"""Scenarios of systems from Python: by their fields, or by options as the command line has them.

A field may be made of options (`bat` of `vmax` and `ping_rate`). It is given whole or by these, not both; a
name that is neither field nor option is refused with those that are taken.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

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
    known, made = _hints(scenario), parts or {}  # type: ignore[arg-type]
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


def _check_kind(path: str, hint: Any, value: Any) -> None:
    """Refuse something else where a field is one of a few words, yes or no, or data of a kind of its own."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if value is None and NoneType in kinds:
        return
    words = [word for kind in kinds if get_origin(kind) is Literal for word in get_args(kind)]
    if words and value not in words:
        raise ParameterError(f"{path}: {value}, must be {' or '.join(words)}")
    data = next((kind for kind in kinds if is_dataclass(kind)), None)
    if isinstance(data, type) and not isinstance(value, data):
        name = data.__name__
        raise ParameterError(
            f"{path}: {value!r}, must be a {name}; write as in {path.rsplit('.', maxsplit=1)[-1]}={name}()"
        )
    if set(kinds) <= {bool, NoneType} and not isinstance(value, bool):
        raise ParameterError(f"{path}: {value!r}, must be True or False")


@cache
def _hints(scenario: type) -> dict[str, Any]:
    return get_type_hints(scenario)
