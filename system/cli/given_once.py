"""Commands whose options may be given once; a second value is refused rather than silently taken."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any, final

import typer
from typer.core import TyperCommand

from circuits.errors import CircuitError, ParameterError
from system.cli.former import check_former
from system.cli.option_names import as_options

EDITS = {"only", "heal", "deviate"}  # options of a die's edits


@final
class OnceCommand(TyperCommand):
    """A command that refuses an option that is given twice, and a name that is set twice by `NAME=VALUE`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments; raises `ParameterError` for an option or a name that is given twice."""
        if ctx.resilient_parsing:  # a shell asks for what may follow
            return super().parse_args(ctx, args)
        check_former(self.name, args)
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
class App(typer.Typer):
    """A command line whose commands refuse an option that is given twice."""

    def command(self, name: str | None = None, **options: Any) -> Callable[[Any], Any]:
        """Register a function as a command that refuses an option that is given twice."""
        return super().command(name, cls=OnceCommand, **options)


def _check(option: Any, given: dict[str, Any], count: int) -> None:
    shown = "/".join((*option.opts, *option.secondary_opts))
    if option.param_type_name == "option" and not option.multiple and count > 1:
        raise ParameterError(f"{shown}: given {count} times, must be given once; leave the others out")
    if option.multiple and "=" in (option.metavar or ""):
        names = Counter(text.partition("=")[0].strip().replace("-", "_") for text in given[option.name])
        for name, times in names.items():
            if times > 1:
                raise ParameterError(f"{shown}: {name} is set {times} times, must be once; leave others out")
