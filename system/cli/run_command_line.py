"""`noctule run SYSTEM`: a command a system, whose options are those of its scenarios.

Systems are loaded when they are named, so that `noctule --help` does not wait for them.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, final

import typer
from typer.core import TyperGroup

from system.cli.command_options import Json, Plot, Seed, call
from system.cli.given_once import App
from system.cli.option_names import PARAM, option_of
from system.cli.silicon_options import with_silicon
from system.options.silicon import SiliconChoice
from system.registry import load_system, system_names


@final
class Systems(TyperGroup):
    """Names of systems as commands; a name that is none is refused with near ones."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all systems, the users' own included."""
        return system_names()

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of a system."""
        return command_of(load_system(cmd_name))


app = App(cls=Systems, help="Run a system in its world.", rich_markup_mode=None)


def add_to(parent: typer.Typer) -> None:
    """Make `run` a command of `parent`."""
    parent.add_typer(app, name="run")


@app.callback(invoke_without_command=True)
def run(context: typer.Context) -> None:
    """Run a system in its world."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def command_of(system: Any) -> Any:
    """The command that runs a system, with its options."""
    said = names_of(system)

    def command(*, silicon: SiliconChoice, seed: int, plot: str | None, as_json: bool, **given: Any) -> None:
        options = {key: value for key, value in given.items() if value not in (None, [])}
        call(
            "run:run_system", system.name, silicon, seed, plot,
            as_json=as_json, options=options, said=said,
        )  # fmt: skip

    keyword = inspect.Parameter.KEYWORD_ONLY
    shared = (("silicon", SiliconChoice, inspect.Parameter.empty), ("seed", Seed, 0), ("plot", Plot, None))
    rest = (*shared, ("as_json", Json, False))
    parameters = [
        *_options(system, said),
        *(inspect.Parameter(name, keyword, annotation=kind, default=usual) for name, kind, usual in rest),
    ]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in parameters}
    command.__doc__ = system.about or system.summary
    spoken = with_silicon("at", "allow_implausible")(command)
    spoken.said = lambda _: said  # type: ignore[attr-defined]
    alone = App(rich_markup_mode=None, add_completion=False)
    alone.command(system.name)(spoken)
    return typer.main.get_command(alone)


def names_of(system: Any) -> dict[str, str]:
    """Names of a system's fields, options and outputs, and the options that stand for them here."""
    found = {name: option_of(name) for name in (*system.settings, *system.outputs)}
    fields = {one.field: found[name] for name, one in system.settings.items()}
    return {**fields, **found, "temperature_c": "--temperature", "temperature": "--temperature"}


def names_in_study(given: Mapping[str, Any]) -> dict[str, str]:
    """Names of the fields and options of a study's system, and what stands for them in `montecarlo`."""
    if given.get("target") not in system_names():
        return {}
    found = names_of(load_system(given["target"]))
    return {name: f"{PARAM}{option.removeprefix('--')}" for name, option in found.items()}


def _options(system: Any, said: dict[str, str]) -> Iterator[inspect.Parameter]:
    keyword = inspect.Parameter.KEYWORD_ONLY
    for name, one in system.settings.items():
        if not one.option.run:
            continue
        kind: Any = bool | None if one.kind is bool else str | None
        usual: Any = None
        if one.option.collect is not None:
            kind, usual = list[str], []
        declared = typer.Option(_flags(said[name], one), metavar=one.metavar or None, help=one.help)
        yield inspect.Parameter(name, keyword, annotation=Annotated[kind, declared], default=usual)
    for name, output in system.outputs.items():
        declared = typer.Option(said[name], metavar=output.metavar, help=output.help)
        yield inspect.Parameter(name, keyword, annotation=Annotated[str | None, declared], default=None)


def _flags(option: str, one: Any) -> str:
    """`--posts/--no-posts` of what is yes or no."""
    if one.kind is not bool:
        return option
    return f"{option}/--{one.option.opposite or 'no-' + option.removeprefix('--')}"
