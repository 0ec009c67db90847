"""The command `noctule`: its arguments, and one line on stderr for whatever goes wrong.

What a command does is in `system/commands/`, loaded when it is called, so that `noctule --help` does not wait
for numerical libraries. Exit status: 0 done; 1 an experiment disagrees, or the output's reader went away;
2 bad input, or a file, simulator or solver that fails; 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from enum import StrEnum
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any

import typer

from circuits.errors import CircuitError
from system.silicon_choice import SiliconChoice

READER_GONE, BAD_INPUT, INTERRUPTED = 1, 2, 130

# What typer raises for a wrong option: click's ClickException, which some releases of typer carry inside.
_UsageError: Any = typer.BadParameter.__mro__[1]

app = typer.Typer(
    name="noctule",
    help="Model mixed-signal neuromorphic hardware at circuit level: from transistors to robots.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class BiasKind(StrEnum):
    """What sets the current biases of a block."""

    gate = "gate"
    generator = "generator"


class Corner(StrEnum):
    """Where the process stands: drawn for each die, or set."""

    random = "random"
    typical = "typical"
    ss = "ss"
    ff = "ff"
    sf = "sf"
    fs = "fs"


class Engine(StrEnum):
    """What solves a transient."""

    native = "native"
    ngspice = "ngspice"


class Dialect(StrEnum):
    """What a netlist is written for."""

    ngspice = "ngspice"


BlockName = Annotated[str, typer.Argument(metavar="BLOCK", help="A block or chip: see noctule list.")]
Params = Annotated[
    list[str], typer.Option("--param", metavar="NAME=VALUE", help="Size or capacitor, repeatable.")
]
Biases = Annotated[
    list[str], typer.Option("--bias", metavar="NAME=VALUE", help="Bias, as i_lim=6.3uA, repeatable.")
]
Kind = Annotated[
    BiasKind | None, typer.Option("--bias-kind", help="Fixed gate voltages, or the bias generator.")
]
Temperature = Annotated[
    str, typer.Option("--temperature", metavar="DEGC", help="Degrees Celsius, -40 to 125.")
]
Lot = Annotated[str, typer.Option("--lot", help="Lot of dies.")]
DieNumber = Annotated[int | None, typer.Option("--die", help="Die of the lot; the nominal die unless given.")]
DieCorner = Annotated[Corner, typer.Option("--corner", help="Process corner; n first, then p.")]
Mismatch = Annotated[bool, typer.Option(help="Deviations of each device on the die.")]
Process = Annotated[bool, typer.Option(help="Deviations that a die's devices share.")]
At = Annotated[
    str | None,
    typer.Option("--at", metavar="CHIP/INSTANCE", help="Place on a chip, as ranging-chip/neuron[2]."),
]
Stimuli = Annotated[
    list[str],
    typer.Option("--stimulus", metavar="NAME=VALUE", help="As delay=6.4ms or call=off, repeatable."),
]
Targets = Annotated[str | None, typer.Option("--targets", metavar="FILE", help="CSV of moving targets.")]
Plot = Annotated[
    str | None, typer.Option("--plot", metavar="FILE", help="Draw into a .png, .svg or .pdf file.")
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]


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
    """List blocks, chips, systems and experiments."""
    _call("listing:list_command", as_json=as_json)


@app.command()
def show(
    block: BlockName,
    *,
    param: Params = [],  # noqa: B006 - typer reads the default and never changes it
    bias: Biases = [],  # noqa: B006
    bias_kind: Kind = None,
    temperature: Temperature = "27",
    lot: Lot = "A",
    die: DieNumber = None,
    corner: DieCorner = Corner.random,
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Show ports, devices, biases and stimuli, or draw the graph."""
    _call(
        "show:show_command",
        block,
        params=param,
        biases=bias,
        bias_kind=_kind(bias_kind),
        silicon=SiliconChoice(temperature, lot, die, corner.value, mismatch, process, at),
        plot=plot,
        as_json=as_json,
    )


@app.command()
def op(
    block: BlockName,
    *,
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_kind: Kind = None,
    temperature: Temperature = "27",
    lot: Lot = "A",
    die: DieNumber = None,
    corner: DieCorner = Corner.random,
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    stimulus: Stimuli = [],  # noqa: B006
    start: Annotated[
        list[str], typer.Option("--start", metavar="NODE=V", help="Voltage to start from, repeatable.")
    ] = [],  # noqa: B006
    as_json: Json = False,
) -> None:
    """Solve for the operating point."""
    _call(
        "op:op_command",
        block,
        params=param,
        biases=bias,
        bias_kind=_kind(bias_kind),
        silicon=SiliconChoice(temperature, lot, die, corner.value, mismatch, process, at),
        stimuli=stimulus,
        start=start,
        as_json=as_json,
    )


@app.command()
def simulate(
    block: BlockName,
    *,
    stimulus: Stimuli = [],  # noqa: B006
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_kind: Kind = None,
    temperature: Temperature = "27",
    lot: Lot = "A",
    die: DieNumber = None,
    corner: DieCorner = Corner.random,
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    rtol: Annotated[
        float | None, typer.Option("--rtol", help="Relative error a step; 1e-4 unless given.")
    ] = None,
    engine: Annotated[Engine, typer.Option("--engine", help="What solves it.")] = Engine.native,
    plot: Plot = None,
    csv: Annotated[str | None, typer.Option("--csv", metavar="FILE", help="Write all waveforms.")] = None,
    as_json: Json = False,
) -> None:
    """Simulate a transient of a block under its testbench."""
    _call(
        "simulate:simulate_command",
        block,
        params=param,
        biases=bias,
        bias_kind=_kind(bias_kind),
        silicon=SiliconChoice(temperature, lot, die, corner.value, mismatch, process, at),
        stimuli=stimulus,
        rtol=rtol,
        engine=engine.value,
        plot=plot,
        csv=csv,
        as_json=as_json,
    )


@app.command()
def export(
    block: BlockName,
    *,
    output: Annotated[str, typer.Option("--output", "-o", metavar="FILE", help="File, or - for stdout.")],
    stimulus: Stimuli = [],  # noqa: B006
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_kind: Kind = None,
    temperature: Temperature = "27",
    lot: Lot = "A",
    die: DieNumber = None,
    corner: DieCorner = Corner.random,
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    dialect: Annotated[Dialect, typer.Option("--dialect", help="Simulator to write for.")] = Dialect.ngspice,
    as_json: Json = False,
) -> None:
    """Write a block or chip with its testbench as a netlist."""
    _call(
        "export:export_command",
        block,
        params=param,
        biases=bias,
        bias_kind=_kind(bias_kind),
        silicon=SiliconChoice(temperature, lot, die, corner.value, mismatch, process, at),
        stimuli=stimulus,
        dialect=dialect.value,
        output=output,
        as_json=as_json,
    )


@app.command()
def montecarlo(
    target: BlockName,
    *,
    metric: Annotated[
        list[str], typer.Option("--metric", metavar="NAME", help="What is measured, repeatable.")
    ] = ["best_delay"],  # noqa: B006
    samples: Annotated[int, typer.Option("--samples", "-n", help="Number of dies.")] = 200,
    first_die: Annotated[int, typer.Option(help="Number of the first die.")] = 1000,
    lot: Lot = "A",
    corner: DieCorner = Corner.random,
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    temperature: Temperature = "27",
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_kind: Kind = None,
    stimulus: Stimuli = [],  # noqa: B006
    workers: Annotated[int | None, typer.Option(help="Threads; all cores unless given.")] = None,
    csv: Annotated[str | None, typer.Option("--csv", metavar="FILE", help="Write a row a die.")] = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Measure a block on many dies: mean, spread, quantiles, and what share works."""
    _call(
        "montecarlo:montecarlo_command",
        target,
        names=metric,
        count=samples,
        first_die=first_die,
        params=param,
        biases=bias,
        bias_kind=_kind(bias_kind),
        silicon=SiliconChoice(temperature, lot, None, corner.value, mismatch, process, at),
        stimuli=stimulus,
        workers=workers,
        csv=csv,
        plot=plot,
        as_json=as_json,
    )


@app.command()
def run(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A system: see noctule list.")],
    *,
    targets: Targets = None,
    level: Annotated[str | None, typer.Option(help="As transistor or behavioural.")] = None,
    isolation: Annotated[bool, typer.Option(help="First-target isolation.")] = True,
    amplitude_law: Annotated[str | None, typer.Option(help="Of the call: linear or d4.")] = None,
    duration: Annotated[str | None, typer.Option(metavar="TIME", help="Length of the run, as 2s.")] = None,
    temperature: Temperature = "27",
    lot: Lot = "A",
    die: DieNumber = None,
    corner: DieCorner = Corner.random,
    mismatch: Mismatch = True,
    process: Process = True,
    seed: Annotated[int, typer.Option(help="Of noise and worlds.")] = 0,
    noise: Annotated[str | None, typer.Option(metavar="VOLTAGE", help="Rms at a microphone, as 1mV.")] = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Run a system in its world."""
    _call(
        "run:run_command",
        system,
        targets=targets,
        level=level,
        isolation=isolation,
        amplitude_law=amplitude_law,
        duration=duration,
        silicon=SiliconChoice(temperature, lot, die, corner.value, mismatch, process),
        seed=seed,
        noise=noise,
        plot=plot,
        as_json=as_json,
    )


@app.command()
def characterise(
    block: BlockName,
    *,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="FILE", help="Record to write; the package's unless given."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure a block's behavioural model from its circuit; takes minutes."""
    _call("characterise:characterise_command", block, output=output, as_json=as_json)


@app.command()
def reproduce(
    experiment: Annotated[str, typer.Argument(metavar="EXPERIMENT", help="An experiment: see noctule list.")],
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Make a paper's figure again; status 1 if a row disagrees."""
    raise typer.Exit(_call("reproduce:reproduce_command", experiment, plot=plot, as_json=as_json))


@app.command()
def doctor(as_json: Json = False) -> None:
    """Show versions, ngspice, and what is missing."""
    _call("doctor:doctor_command", as_json=as_json)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line on `arguments`, those of the process unless given; returns the exit status."""
    try:
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
        return READER_GONE
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
    return 0


def _call(target: str, *arguments: Any, **options: Any) -> Any:
    """Load `module:function` of `system.commands` and call it."""
    module, function = target.split(":")
    return getattr(import_module(f"system.commands.{module}"), function)(*arguments, **options)


def _kind(kind: BiasKind | None) -> str | None:
    return None if kind is None else kind.value


def _version() -> str:
    try:
        return version("noctule")
    except PackageNotFoundError:
        return "(not installed)"


def _refuse(text: str, status: int = BAD_INPUT) -> int:
    """Say what is wrong in one line."""
    typer.echo(f"noctule: {' '.join(text.split())}", err=True)
    return status


def _drop_output() -> None:
    """Let stdout lead nowhere, so that the interpreter's last flush does not fail a second time."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
