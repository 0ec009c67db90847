"""Scenarios of systems, made by fields in Python or by options as users name them.

A field may be a part made of options (`bat` of `vmax` and `ping_rate`). It is given whole or by these, not
both; a name that is neither field nor option is refused with those that are taken. A number under the name of
a part's option is in the option's unit, one under a field's name in SI units. A text is read by its option.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from os import PathLike, fspath
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from circuits.catalogue import later
from circuits.errors import ParameterError, UnknownNameError, meant
from system.option import Option, Setting, check_kind, listed, settings, tupled, without_none

np = later("numpy")

S = TypeVar("S")
Make = Callable[[dict[str, Any], Mapping[str, Any]], dict[str, Any]]


def keep(fields: dict[str, Any], _: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields as they are, for scenarios whose every option sets one field."""
    return fields


def all_settings(scenario: type, more: Mapping[str, Option]) -> dict[str, Setting]:
    """Return the options of a scenario, and those that set no single field, by the names of users."""
    found = {name: Setting(name, "", str, None, option) for name, option in more.items()}
    return {**settings(scenario), **found}


def scenario_of(
    system: str,
    scenario: type[S],
    given: Mapping[str, Any],
    more: Mapping[str, Option] | None = None,
    make: Make = keep,
) -> S:
    """Return a scenario of a system, its fields and options `given` by name.

    Parameters
    ----------
    system
        Name of the system, for an error's text.
    scenario
        Dataclass of the system's scenarios.
    given
        Values, or texts of them, by name.
    more
        Options that set no single field.
    make
        Takes the fields, and the values of `more` that were given, and returns the fields.

    Raises
    ------
    UnknownNameError
        A name that is not taken; the text has all that are.
    ParameterError
        A field is given whole and in part, or as something else than what it is; and what `make` and the
        scenario refuse.
    """
    known, options = _hints(scenario), all_settings(scenario, more or {})  # type: ignore[arg-type]
    taken = [*known, *(name for name in options if name not in known)]
    whole: dict[str, Any] = {}
    rest: dict[str, Any] = {}
    parts: dict[str, dict[str, Any]] = {}
    for name, value in given.items():
        if name not in taken:
            raise _not_taken(f"{system}.scenario.{name}", name, taken)
        if name in known:
            own = _of_field(options, name)
            if not (isinstance(value, str) and own is not None and own.option.write is not None):
                _check_words(f"{system}.scenario.{name}", known[name], value)
            whole[name] = _plain(_read(name, value, own), known[name])
            check_kind(name, known[name], whole[name])
            continue
        one = options[name]
        _check_apart(system, one, given)
        hint = _hint_of(one, known)
        found = _plain(_read(name, value, one), hint)
        check_kind(name, hint, found)
        one.check(found)
        if one.part:
            parts.setdefault(one.part, {})[one.field] = _in_si(one, found)
        elif one.part is None:
            whole[one.field] = found
        else:
            rest[name] = found
    made = {name: without_none(known[name])(**numbers) for name, numbers in parts.items()}
    return scenario(**make({**whole, **made}, rest))


def read_texts(options: Mapping[str, Setting], texts: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of options, of which some are texts; raises `ParameterError` for no such text."""
    return {name: _read(name, value, options[name]) for name, value in texts.items()}


def _of_field(options: Mapping[str, Setting], name: str) -> Setting | None:
    return next((one for one in options.values() if one.field == name and one.part is None), None)


def _read(name: str, value: Any, one: Setting | None) -> Any:
    """A value, by its option's reader where it is a text; of texts, where the option is repeatable."""
    if one is None:
        return value
    texts = [value] if isinstance(value, str) else value
    if one.option.collect is not None and isinstance(texts, list) and all(isinstance(t, str) for t in texts):
        return one.option.collect(one.read(text, name) for text in texts)
    return one.read(value, name) if isinstance(value, str) else value


def _hint_of(one: Setting, known: Mapping[str, Any]) -> Any:
    """The type of the field that an option sets, of the scenario or its part, or of one that sets none."""
    if one.part:
        return _hints(without_none(known[one.part]))[one.field]
    return known[one.field] if one.part is None else str if one.option.unit is None else float


def _plain(value: Any, hint: Any) -> Any:
    """A list or an array as the tuple, and a path as the text, that its field takes."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if isinstance(value, list | np.ndarray) and any(get_origin(kind) is tuple for kind in kinds):
        return tupled(value)
    return fspath(value) if isinstance(value, PathLike) and str in kinds else value


def _in_si(one: Setting, value: Any) -> Any:
    """A value as the field has it."""
    change = one.option.to_field
    return value if change is None or value is None else change(value)


def _not_taken(path: str, name: str, taken: list[str]) -> UnknownNameError:
    guess = meant(name, taken) or ";"
    return UnknownNameError(f"{path}: unknown{guess} taken are {', '.join(sorted(taken))}")


def _check_apart(system: str, one: Setting, given: Mapping[str, Any]) -> None:
    """Refuse a field that is given whole, and by an option that sets it or a part of it."""
    field = one.part or one.field
    if field != one.name and field in given:
        value = f"{system}.scenario.{one.name}: {given[one.name]}"
        raise ParameterError(f"{value}, not with {field}, which has its own; leave one out")


def _check_words(path: str, hint: Any, value: Any) -> None:
    """Refuse something else where a field is one of a few words, yes or no, or data of a kind of its own."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if value is None and NoneType in kinds:
        return
    words = [word for kind in kinds if get_origin(kind) is Literal for word in get_args(kind)]
    if words and value not in words:
        raise ParameterError(f"{path}: {value}, must be {listed(tuple(words))}{meant(str(value), words)}")
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
    hints = get_type_hints(scenario)  # of what belongs to the class too, which no scenario is given
    return {field.name: hints[field.name] for field in fields(scenario)}
