"""Verbs of the command line: dataclasses whose docstrings are the help, and whose fields are the options.

A field states its option by `option` (`system.option`), `required` or `argument`; the fields stand in the
order of `--help`. A field that is a `part` has options of its own, which stand in its place. `verb` makes the
command, which calls the verb's function with one value of the dataclass. Nothing here is slow to import.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import MISSING, dataclass, field, fields
from enum import Enum, StrEnum
from functools import cache
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import typer

from circuits.catalogue import loaded
from system.cli.completion import words_from
from system.cli.option_names import option_of
from system.option import OPTION, Option, without_none

ARGUMENT, PART = "argument", "part"  # keys of a field's metadata

EMPTY = inspect.Parameter.empty
_NAMED = re.compile("`([a-z_]+)`")  # an option in a line of help

Command = Callable[..., None]


@dataclass(frozen=True, slots=True)
class Part:
    """Options of a dataclass that stand together in the place of one field.

    Attributes
    ----------
    kind : dataclass of the options.
    without : names of its options that are left out.
    made : makes the field's value of a value of that dataclass.
    """

    kind: type
    without: Collection[str]
    made: Callable[[Any], Any]


def argument(metavar: str, about: str, **stated: Any) -> Any:
    """Make the field of a value that is given by its place; `about` is its help."""
    return field(metadata={OPTION: Option(help=about, metavar=metavar, **stated), ARGUMENT: True})


def required(about: str, **stated: Any) -> Any:
    """Make the field of an option that must be given; `about` is its help."""
    return field(metadata={OPTION: Option(help=about, **stated)})


def like(kind: type, name: str) -> Any:
    """Make a field with the option and the default that the field `name` of another dataclass has."""
    (found,) = (each for each in fields(kind) if each.name == name)
    return field(default=found.default, metadata=found.metadata)


def _itself(value: Any) -> Any:
    """What is made of a part whose dataclass is what the verb's function takes."""
    return value


def part(kind: type, *without: str, made: Callable[[Any], Any] = _itself) -> Any:
    """Make the field of a `Part`.

    Its default is what is made where none of its options is given. Parameters are those of `Part`.
    """
    return field(default_factory=lambda: made(kind()), metadata={PART: Part(kind, without, made)})


def verb(place: str, options: type) -> Command:
    """Make the command of a verb.

    Parameters
    ----------
    place : function of the verb in `system.cli`, as `"module:function"`; it is loaded when it is called, and
        returns an exit status, None for that of success.
    options : dataclass of the verb, of which the function takes one value.
    """

    def command(**given: Any) -> None:
        function, asked = loaded(f"system.cli.{place}"), made_of(options, given)
        with compilation_told():
            end_with(function(asked))

    return with_parameters(command, parameters_of(options), options.__doc__ or "")


@contextmanager
def compilation_told() -> Iterator[None]:
    """Inside, a person at a terminal is told of kernels that are compiled."""
    with ExitStack() as stack:
        if sys.stderr.isatty():
            waiting = loaded("circuits.compiled:before_first_kernel")
            stack.enter_context(
                waiting(lambda: stack.enter_context(loaded("system.cli.compilation:compilation_told")()))
            )
        yield


def end_with(status: int | None) -> None:
    """End the command with an exit status, None for that of success."""
    if status:
        raise typer.Exit(status)


def with_parameters(command: Command, parameters: Iterator[inspect.Parameter], about: str) -> Command:
    """Give a command the parameters that the command line reads as its options, and its help.

    The same function is returned.
    """
    signature = inspect.Signature(list(parameters))
    command.__signature__ = signature  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
    command.__doc__ = about
    return command


def parameters_of(options: type, without: Collection[str] = ()) -> Iterator[inspect.Parameter]:
    """Yield the parameters of a command for the options of a dataclass, but those `without`."""
    hints = _hints(options)
    for each in fields(options):
        inner = each.metadata.get(PART)
        if inner is not None:
            yield from parameters_of(inner.kind, inner.without)
        elif each.name not in without:
            stated, kind = each.metadata[OPTION], hints[each.name]
            about = _NAMED.sub(lambda found: option_of(found[1]), stated.help)
            shown: Any = {
                "metavar": stated.metavar or None,
                "help": f"{about}.",
                "autocompletion": completion_of(stated.names),
            }
            if ARGUMENT in each.metadata:
                declared = typer.Argument(**shown)
            else:
                declared = typer.Option(*flags_of(each.name, stated, paired=each.default is True), **shown)
            usual = list(each.default) if isinstance(each.default, tuple) else each.default
            yield keyword(each.name, Annotated[kind, declared], EMPTY if usual is MISSING else usual)


def completion_of(place: str, choices: Collection[str] = ()) -> Callable[[str], list[str]] | None:
    """Give the completion of a value by `choices`, and by the words at `place` if it is one; None without."""
    if not place and not choices:
        return None
    return words_from(lambda: (*choices, *(_words_at(place) if place else ())))


def _words_at(place: str) -> Iterable[str]:
    """Words at a place, or those that the function there lists."""
    found: Any = loaded(place)
    words: Iterable[str] = found() if callable(found) else found
    return words


def keyword(name: str, kind: Any, usual: Any) -> inspect.Parameter:
    """Make a parameter that is given by its name, with its type and its default."""
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=usual)


def flags_of(name: str, stated: Option, *, paired: bool) -> list[str]:
    """Give the names of an option, as `--samples` and `-n`.

    Where `paired`, the name has an opposite, as `--mismatch/--no-mismatch`.
    """
    option = option_of(stated.name or name)
    if paired or stated.opposite:
        option = f"{option}/{option_of(stated.opposite or f'no_{name}')}"
    return [option, *([f"-{stated.short}"] if stated.short else [])]


def made_of(options: type, given: Mapping[str, Any], without: Collection[str] = ()) -> Any:
    """Make a value of the dataclass from what was read for its options, but those `without`."""
    found = {}
    for each in fields(options):
        inner = each.metadata.get(PART)
        if inner is not None:
            found[each.name] = inner.made(made_of(inner.kind, given, inner.without))
        elif each.name not in without:
            found[each.name] = _plain(given[each.name])
    return options(**found)


@cache
def _hints(options: type) -> dict[str, Any]:
    """Types of a dataclass's fields, as typer reads them."""
    return {name: _typer_kind(hint) for name, hint in get_type_hints(options).items()}


def _typer_kind(hint: Any) -> Any:
    """The type by which typer reads a field: an enumeration for words, a list for several values."""
    arguments = get_args(hint)
    if hint is Any:
        return str | None
    if get_origin(hint) is Literal:
        return StrEnum("Words", {word: word for word in arguments})
    if get_origin(hint) is tuple:
        return list[_typer_kind(arguments[0])]  # type: ignore[misc]
    return _typer_kind(without_none(hint)) | None if type(None) in arguments else hint


def _plain(value: Any) -> Any:
    """A value of typer's as a field has it."""
    if isinstance(value, list):
        return tuple(_plain(each) for each in value)
    return value.value if isinstance(value, Enum) else value


def words_given(options: Any, apart: Collection[str]) -> Iterator[str]:
    """Give the words of options that are not at their default, without those whose names are `apart`."""
    for each in fields(options):
        value = getattr(options, each.name)
        if PART in each.metadata:
            yield from words_given(value, apart)
        elif each.name in apart or value == each.default:
            continue
        elif isinstance(value, bool):
            yield option_of(each.name if value else f"no_{each.name}")
        else:
            name = option_of(each.metadata[OPTION].name or each.name)
            for one in value if isinstance(value, tuple) else (value,):
                yield from (name, str(one))
