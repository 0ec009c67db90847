"""Commands whose options may be given once; a second value is refused rather than silently taken."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any, final, get_args

import typer
from typer.core import TyperCommand, TyperGroup

from circuits.errors import CircuitError, ParameterError
from system.cli.former import check_former
from system.cli.option_names import as_options
from system.option import without_none

EDITS = {"only", "heal", "deviate"}  # options of a die's edits


@final
class OnceCommand(TyperCommand):
    """A command that refuses an option that is given twice, and a name that is set twice by `NAME=VALUE`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments; raises `ParameterError` for an option or a name that is given twice."""
        if ctx.resilient_parsing:  # a shell asks for what may follow
            return super().parse_args(ctx, args)
        check_former(self.name, args)
        take_as_they_are(self, ctx)
        given, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for option, count in Counter(id(p) for p in order).items():
            _check(next(p for p in order if id(p) == option), given, count)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command.

        An error that names a field is raised again as a `ParameterError` that names the option which sets the
        field.
        """
        try:
            return super().invoke(ctx)
        except CircuitError as error:
            text = str(error)
            told = as_options(text, self._names(ctx))
            if told == text:
                raise
            raise ParameterError(told) from error

    def _names(self, ctx: Any) -> dict[str, str]:
        """Names of fields and parameters, and the options that stand for them."""
        own = {p.name: p.opts[0] for p in self.params if p.param_type_name == "option"}
        if ctx.params.get("die"):  # which may be a file that states what these would
            own |= {name: own["die"] for name in EDITS & own.keys() if not ctx.params.get(name)}
        named = getattr(self.callback, "said", dict)
        return {**named(ctx.params), **own}


@final
class Commands(TyperGroup):
    """The group of all commands, whose own options are taken as they are where their types say no more."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments."""
        take_as_they_are(self, ctx)
        return super().parse_args(ctx, args)


@final
class App(typer.Typer):
    """A command line whose commands refuse an option that is given twice."""

    def command(self, name: str | None = None, **options: Any) -> Callable[[Any], Any]:
        """Register a function as a command that refuses an option that is given twice."""
        return super().command(name, cls=OnceCommand, **options)


def take_as_they_are(command: Any, ctx: Any) -> None:
    """Let a command's texts and defaults, and what is not given, be taken without typer looking at them.

    What looks at values of other types is slow to import.
    """
    stated = getattr(command.callback, "__annotations__", {})
    for each in command.get_params(ctx):
        (kind,) = (get_args(stated.get(each.name)) or (None,))[:1]
        each.process_value = partial(_value, each, without_none(kind), type(each).process_value)


def _value(option: Any, kind: Any, looked_at: Callable[[Any, Any, Any], Any], ctx: Any, value: Any) -> Any:
    """The value of an option: what typer makes of it, unless that is known to be the value itself.

    kind: the type that the option is said to have, without None.
    """
    several = option.multiple or option.nargs == -1
    if value is None and not option.required:
        known, value = True, () if several else None
    else:
        texts = value if several and isinstance(value, list | tuple) else (value,)
        known = kind in (str, list[str]) and all(type(text) is str for text in texts)
        known = known or (value is option.default and type(value) in (kind, str))
    if not known:
        return looked_at(option, ctx, value)
    return value if option.callback is None else option.callback(ctx, option, value)


def _check(option: Any, given: dict[str, Any], count: int) -> None:
    shown = "/".join((*option.opts, *option.secondary_opts))
    if option.param_type_name == "option" and not option.multiple and count > 1:
        raise ParameterError(f"{shown}: given {count} times, must be given once; leave the others out")
    if option.multiple and "=" in (option.metavar or ""):
        names = Counter(text.partition("=")[0].strip().replace("-", "_") for text in given[option.name])
        for name, times in names.items():
            if times > 1:
                raise ParameterError(f"{shown}: {name} is set {times} times, must be once; leave others out")
