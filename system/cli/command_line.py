"""The command `noctule`: its arguments, and one line on stderr for whatever goes wrong.

What a command does is in `system/cli/`, loaded when it is called, so that `noctule --help` does not wait
for numerical libraries. Exit status (`system.cli.exit_status`): 0 done; 1 done, and the answer is no: an
experiment disagrees, netlists differ, no die of a study could be measured or passes, a sample is not the one
that was kept, a piece is missing; also where the output's reader went away; 2 bad input, or a file, simulator
or solver that fails; 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any

import typer

from circuits.errors import CircuitError
from system.cli import run_command_line, simulate_command_line, study_command_line
from system.cli.command_options import (
    AllowImplausible,
    Biases,
    BiasFile,
    BiasSet,
    BlockName,
    Held,
    Json,
    Kind,
    Level,
    Models,
    NetlistDialect,
    NetlistDrop,
    NetlistRoot,
    Params,
    Plot,
    Stimuli,
    Uic,
    call,
    kind_name,
)
from system.cli.exit_status import BAD_INPUT, DONE, INTERRUPTED, NO
from system.cli.given_once import App
from system.cli.silicon_options import with_silicon
from system.notice import say, warnings_in_a_line
from system.options.begin import begin_choice
from system.options.silicon import SiliconChoice

# What typer raises for a wrong option: click's ClickException, which some releases of typer carry inside.
_UsageError: Any = typer.BadParameter.__mro__[1]

app = App(
    name="noctule",
    help="Model mixed-signal neuromorphic hardware at circuit level: from transistors to robots.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@app.callback(invoke_without_command=True)
def noctule(
    context: typer.Context,
    show_version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    """Model mixed-signal neuromorphic hardware at circuit level: from transistors to robots."""
    if show_version:
        typer.echo(f"noctule {_version()}")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command("list")
def list_(as_json: Json = False) -> None:
    """List blocks, chips, systems, experiments, metrics and dialects."""
    call("listing:list_command", as_json=as_json)


@app.command()
@with_silicon()
def show(
    block: BlockName,
    *,
    param: Params = [],  # noqa: B006 - typer reads the default and never changes it
    bias: Biases = [],  # noqa: B006
    bias_set: BiasSet = None,
    bias_file: BiasFile = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Show ports, devices, biases and stimuli, or draw the graph; of rolls, what a die is like."""
    call(
        "show:show_command",
        block,
        params=param,
        biases=bias,
        bias_set=bias_set,
        bias_file=bias_file,
        bias_kind=kind_name(bias_kind),
        silicon=silicon,
        plot=plot,
        as_json=as_json,
    )


@app.command()
@with_silicon()
def op(
    block: BlockName,
    *,
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_set: BiasSet = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    stimulus: Stimuli = [],  # noqa: B006
    start: Annotated[
        list[str], typer.Option("--start", metavar="NODE=V", help="Voltage to start from, repeatable.")
    ] = [],  # noqa: B006
    csv: Annotated[str | None, typer.Option("--csv", metavar="FILE", help="Write a row a device.")] = None,
    as_json: Json = False,
) -> None:
    """Solve for the operating point: voltages, and currents, inversion and headroom by device."""
    call(
        "op:op_command",
        block,
        params=param,
        biases=bias,
        bias_set=bias_set,
        bias_kind=kind_name(bias_kind),
        silicon=silicon,
        stimuli=stimulus,
        start=start,
        csv=csv,
        as_json=as_json,
    )


app.command()(simulate_command_line.simulate)


@app.command()
@with_silicon()
def export(
    block: BlockName,
    *,
    output: Annotated[str, typer.Option("--output", "-o", metavar="FILE", help="File, or - for stdout.")],
    stimulus: Stimuli = [],  # noqa: B006
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_set: BiasSet = None,
    bias_file: BiasFile = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    program: Annotated[
        str | None,
        typer.Option("--program", metavar="FILE", help="Of rolls: a CSV of post,pre,level, or pushbot."),
    ] = None,
    dialect: Annotated[
        str, typer.Option("--dialect", metavar="NAME", help="What to write, as spectre; see noctule list.")
    ] = "ngspice",
    models: Annotated[Models, typer.Option("--models", help="What transistors are.")] = Models.ekv,
    ic: Held = [],  # noqa: B006
    uic: Uic = False,
    parasitics: Annotated[
        str | None,
        typer.Option("--parasitics", metavar="FILE", help="CSV of node and capacitance, merged in."),
    ] = None,
    mapping: Annotated[
        str | None,
        typer.Option("--mapping", metavar="NAME", help="A foundry's process, as gf180mcu, or a TOML file."),
    ] = None,
    level: Annotated[
        Level, typer.Option("--level", help="Devices, or a chip's neurons by their reduced equations.")
    ] = Level.transistor,
    as_json: Json = False,
) -> None:
    """Write a block, a chip or a row of rolls with its testbench as a netlist."""
    call(
        "export:export_command",
        block,
        params=param,
        biases=bias,
        bias_set=bias_set,
        bias_file=bias_file,
        program=program,
        bias_kind=kind_name(bias_kind),
        silicon=silicon,
        stimuli=stimulus,
        mapping=mapping,
        level=level.value,
        dialect=dialect,
        models=models.value,
        parasitics=parasitics,
        begin=begin_choice(ic, uic=uic),
        output=output,
        as_json=as_json,
    )


@app.command("import")
def import_netlist(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A netlist.")],
    *,
    root: NetlistRoot = None,
    dialect: NetlistDialect = None,
    drop: NetlistDrop = [],  # noqa: B006
    allow_implausible: AllowImplausible = False,
    as_json: Json = False,
) -> None:
    """Read a netlist: its circuit, sources and analyses, and what was not taken over."""
    call(
        "import_netlist:import_command",
        file,
        root=root,
        dialect=dialect,
        drop=drop,
        allow_implausible=allow_implausible,
        as_json=as_json,
    )


@app.command()
def compare(
    first: Annotated[str, typer.Argument(metavar="A", help="A netlist.")],
    second: Annotated[str, typer.Argument(metavar="B", help="Another netlist.")],
    *,
    root: NetlistRoot = None,
    dialect: NetlistDialect = None,
    drop: NetlistDrop = [],  # noqa: B006
    as_json: Json = False,
) -> None:
    """Compare the circuits of two netlists; status 1 if they differ."""
    call("compare:compare_command", first, second, root=root, dialect=dialect, drop=drop, as_json=as_json)


study_command_line.add_to(app)
run_command_line.add_to(app)


@app.command()
def characterise(
    block: BlockName,
    *,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="FILE", help="Record to write; in the caches unless given."),
    ] = None,
    bias_set: BiasSet = None,
    update_package: Annotated[
        bool, typer.Option("--update-package", help="Write the package's own record, in a checkout.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Measure a block's behavioural model from its circuit; takes minutes."""
    call(
        "characterise:characterise_command",
        block,
        output=output,
        bias_set=bias_set,
        update_package=update_package,
        as_json=as_json,
    )


@app.command()
def reproduce(
    experiment: Annotated[str, typer.Argument(metavar="EXPERIMENT", help="An experiment: see noctule list.")],
    *,
    param: Annotated[
        list[str], typer.Option("--param", metavar="NAME=COUNT", help="Of a campaign, as forests=20.")
    ] = [],  # noqa: B006
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="FILE", help="Keeps a campaign's runs as it goes.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the campaign in --output.")] = False,
    workers: Annotated[int | None, typer.Option(help="Processes of a campaign.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Dask cluster of a campaign.")
    ] = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Make a paper's figure again; status 1 if a row disagrees."""
    call(
        "reproduce:reproduce_command",
        experiment,
        params=param,
        output=output,
        resume=resume,
        workers=workers,
        scheduler=scheduler,
        plot=plot,
        as_json=as_json,
    )


@app.command()
def doctor(as_json: Json = False) -> None:
    """Show versions, ngspice, and what is missing."""
    call("doctor:doctor_command", as_json=as_json)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line on `arguments`, those of the process unless given; returns the exit status."""
    try:
        with warnings_in_a_line():
            status = _run(sys.argv[1:] if arguments is None else list(arguments))
        sys.stdout.flush()
    except CircuitError as error:
        return _refuse(str(error))
    except ImportError as error:
        return _refuse(f"{error}; see noctule doctor")
    except KeyboardInterrupt:
        return _refuse("interrupted", INTERRUPTED)
    except BrokenPipeError:
        _drop_output()
        return NO
    except OSError as error:
        _drop_output()
        return _refuse(f"{error.filename or 'output'}: {error.strerror or error}")
    return status


def _run(arguments: list[str]) -> int:
    """Parse and run. typer's own `main` would print usage errors in several lines."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("noctule", arguments) as context:
            command.invoke(context)
    except typer.Exit as done:
        return done.exit_code
    except _UsageError as error:
        return _refuse(error.format_message().replace("Value error, ", "").rstrip("."))
    return DONE


def _version() -> str:
    try:
        return version("noctule")
    except PackageNotFoundError:
        return "(not installed)"


def _refuse(text: str, status: int = BAD_INPUT) -> int:
    """Say what is wrong in one line."""
    say(text)
    return status


def _drop_output() -> None:
    """Let stdout lead nowhere, so that the interpreter's last flush does not fail a second time."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
