"""Commands of `noctule run` and `blame`, one for each system, whose options are those of its scenarios.

Systems are loaded when they are named, so that `noctule --help` does not wait for them.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import Annotated, Any, ClassVar, final

import typer
from typer.core import TyperCommand, TyperGroup

from circuits.catalogue import loaded
from circuits.errors import CircuitError
from system.cli import bench_verb, map_verb
from system.cli.examples import epilog_of
from system.cli.given_once import App, take_as_they_are
from system.cli.option_names import PARAM, option_of
from system.cli.scenario_file import read_scenario_file
from system.cli.study_verbs import Blame
from system.cli.verb import (
    compilation_told,
    completion_of,
    end_with,
    flags_of,
    keyword,
    made_of,
    parameters_of,
    verb,
    with_parameters,
)
from system.cli.verbs import Run
from system.registry import load_system, system_line, system_names
from system.system import System

SCENARIO = "scenario"  # the option that names a file of options


@dataclass(frozen=True, slots=True)
class SystemVerb:
    """A verb with a command for each system.

    name : of the verb.
    place : its function, as `"module:function"`.
    options : dataclass of the options that it has for every system.
    about : its help.
    outputs : whether it leaves the files that a run of a system can leave.
    """

    name: str
    place: str
    options: type
    about: str
    outputs: bool


RUN = SystemVerb(
    "run",
    "system.cli.run:run_system",
    Run,
    "Run a system in its world, or PROGRAM.toml of noctule map.",
    outputs=True,
)
BLAME = SystemVerb(
    "blame", "system.cli.blame:blame_system", Blame, "Say which devices of a die make a robot fail.",
    outputs=False,
)  # fmt: skip


class Systems(TyperGroup):
    """Group of commands with one for each system; an unknown name is refused with similar ones."""

    verb: ClassVar[SystemVerb]

    def list_commands(self, ctx: Any) -> list[str]:
        """Give the names of all systems, with the users' own."""
        return [*system_names(), bench_verb.NAME] if self.verb is RUN else system_names()

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments."""
        take_as_they_are(self, ctx)
        return super().parse_args(ctx, args)

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        """Give what completes the name of a system, without loading one."""
        lines = self._lines()
        return lines.shell_complete(typer.Context(lines, parent=ctx.parent), incomplete)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Give the command of the system with this name."""
        if cmd_name == bench_verb.NAME and self.verb is RUN:
            return _bench()
        if cmd_name.endswith(map_verb.PROGRAM) and self.verb is RUN:
            return _program(cmd_name)
        return command_of(load_system(cmd_name), cmd_name, self.verb)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of systems with a line on each, without loading any but the users' own."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, _line(name)) for name in self.list_commands(ctx)])

    def _lines(self) -> TyperGroup:
        """A group whose commands have a name and a line each, and no options."""
        names = self.list_commands(None)
        lines: Any = {name: TyperCommand(name, help=_line(name)) for name in names}
        return TyperGroup(name=self.name, commands=lines, params=self.params)


def _line(name: str) -> str:
    """What a system does, or why it cannot be loaded, which must not hide the others."""
    if name == bench_verb.NAME:
        return _sentence(bench_verb.LINE)
    try:
        return _sentence(system_line(name))
    except CircuitError as error:
        return f"Cannot be loaded: {error}"


def _sentence(line: str) -> str:
    """A line of a list as a sentence, which help is."""
    return f"{line[:1].upper()}{line[1:]}."


@final
class _RunSystems(Systems):
    verb = RUN


@final
class _BlameSystems(Systems):
    verb = BLAME


def add_to(parent: typer.Typer) -> None:
    """Make `run` and `blame` commands of `parent`."""
    for group in (_RunSystems, _BlameSystems):
        parent.add_typer(_app(group), name=group.verb.name)


def _app(group: type[Systems]) -> App:
    """The commands of a verb."""
    verb = group.verb
    app = App(cls=group, help=verb.about, epilog=epilog_of(verb.name), rich_markup_mode=None)

    @app.callback(invoke_without_command=True, help=verb.about)
    def alone(context: typer.Context) -> None:
        if context.invoked_subcommand is None:
            typer.echo(context.get_help())

    return app


def command_of(system: System[Any, Any], name: str, verb: SystemVerb = RUN) -> Any:
    """Give the command of a verb for a system, with the options of its scenarios and outputs.

    name: what it was called by, which loads it.
    """
    said, own = _names_of(system), list(_options(system, outputs=verb.outputs))

    def command(**given: Any) -> None:
        options = {p.name: given[p.name] for p in own if given[p.name] not in (None, [])}
        function = loaded(verb.place)  # which numerical libraries come with
        try:
            with compilation_told():
                end_with(function(name, made_of(verb.options, given), options, said))
        except CircuitError as error:
            raise given[SCENARIO].told(error, given) if given[SCENARIO] else error from None

    about = _sentence(system.summary)
    with_parameters(command, chain(own, [_scenario(system)], parameters_of(verb.options)), about)
    command.said = lambda _: said  # type: ignore[attr-defined]
    alone = App(rich_markup_mode=None, add_completion=False)
    alone.command(system.name, epilog=epilog_of(verb.name, system.name))(command)
    return typer.main.get_command(alone)


def _bench() -> Any:
    """Give the command that measures the teaching chip by a script."""
    alone = App(rich_markup_mode=None, add_completion=False)
    made = verb("bench:bench_command", bench_verb.Bench)
    alone.command(bench_verb.NAME, epilog=epilog_of("run", bench_verb.NAME))(made)
    return typer.main.get_command(alone)


def _program(path: str) -> Any:
    """Give the command that runs a mapped network."""

    def command(**given: Any) -> None:
        function, asked = loaded("system.cli.run_program:run_program"), made_of(map_verb.RunProgram, given)
        with compilation_told():
            end_with(function(path, asked))

    about = map_verb.RunProgram.__doc__ or ""
    with_parameters(command, parameters_of(map_verb.RunProgram), about)
    alone = App(rich_markup_mode=None, add_completion=False)
    alone.command(path)(command)
    return typer.main.get_command(alone)


def _scenario(system: System[Any, Any]) -> inspect.Parameter:
    """Parameter for a file of options, which what else is given goes over."""

    def read(context: typer.Context, path: str | None) -> Any:
        if path is None:
            return None
        found = read_scenario_file(path, system)
        context.default_map = dict(found.values)
        return found

    about = "TOML of these options, seed and silicon; options given here go over it."
    declared = typer.Option(option_of(SCENARIO), metavar="FILE", help=about, is_eager=True, callback=read)
    return keyword(SCENARIO, Annotated[str | None, declared], None)


def _names_of(system: System[Any, Any]) -> dict[str, str]:
    """Names of a system's fields, options and outputs, and the options that stand for them here."""
    found = {name: option_of(name) for name in (*system.settings, *system.outputs)}
    fields = {one.field: found[name] for name, one in system.settings.items()}
    return {**fields, **found, "temperature_c": "--temperature", "temperature": "--temperature"}


def names_in_study(given: Mapping[str, Any]) -> dict[str, str]:
    """Give the option of `montecarlo` that stands for each field of a study's system, by its name.

    given: values of the options of `montecarlo`; for a target that is no system there are no names.
    """
    if given.get("target") not in system_names():
        return {}
    found = _names_of(load_system(given["target"]))
    return {name: f"{PARAM}{option.removeprefix('--')}" for name, option in found.items()}


def _options(system: System[Any, Any], *, outputs: bool) -> Iterator[inspect.Parameter]:
    """Parameters for the options of a system's scenarios, and for the files that its runs leave.

    Their help has the defaults of a run, which is on chips.
    """
    usual = system.usual({})
    for name, one in system.settings.items():
        if not one.option.run:
            continue
        several, paired = one.option.collect is not None, one.kind is bool
        kind: Any = list[str] if several else bool | None if paired else str | None
        flags = flags_of(name, one.option, paired=paired)
        completion = completion_of(one.option.names, one.choices)
        about = replace(one, default=usual.get(name, one.default)).help
        declared = typer.Option(*flags, metavar=one.metavar or None, help=about, autocompletion=completion)
        yield keyword(name, Annotated[kind, declared], [] if several else None)
    for name, output in system.outputs.items() if outputs else ():
        declared = typer.Option(option_of(name), metavar=output.metavar, help=output.help)
        yield keyword(name, Annotated[str | None, declared], None)
