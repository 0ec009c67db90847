"""Options that several commands share, as the command line declares them; nothing here is slow to import."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer

from circuits.catalogue import loaded
from system.cli.deadline import HELP as DEADLINE_HELP


def call(function_path: str, /, *arguments: Any, **options: Any) -> None:
    """Load `module:function` of `system.cli`, call it, and end with the status that it returns."""
    status = loaded(f"system.cli.{function_path}")(*arguments, **options)
    if status:
        raise typer.Exit(status)


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


class Level(StrEnum):
    """Devices, or the reduced equations of their models."""

    transistor = "transistor"
    behavioural = "behavioural"


class Models(StrEnum):
    """What transistors are in a netlist: our equations, or BSIM3 on cards from the process."""

    ekv = "ekv"
    bsim3 = "bsim3"


BlockName = Annotated[str, typer.Argument(metavar="BLOCK", help="A block or chip: see noctule list.")]
Params = Annotated[
    list[str], typer.Option("--param", metavar="NAME=VALUE", help="Size, capacitor, or a system's option.")
]
Biases = Annotated[
    list[str], typer.Option("--bias", metavar="NAME=VALUE", help="Bias, as i_lim=6.3uA, repeatable.")
]
BiasSet = Annotated[
    str | None,
    typer.Option("--bias-set", metavar="NAME", help="Named set of the block's biases; --bias goes on top."),
]
BiasFile = Annotated[
    str | None,
    typer.Option("--bias-file", metavar="FILE", help="Of rolls: rolls_default, rolls_parallella or a CSV."),
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
StudyFolder = Annotated[
    str | None, typer.Option("--study", metavar="FOLDER", help="Take --die from the plan of a study.")
]
Mismatch = Annotated[bool, typer.Option(help="Deviations of each device on the die.")]
Process = Annotated[bool, typer.Option(help="Deviations that a die's devices share.")]
At = Annotated[
    str | None,
    typer.Option("--at", metavar="CHIP/INSTANCE", help="Place on a chip, as ranging-chip/neuron[2]."),
]
AllowImplausible = Annotated[
    bool,
    typer.Option("--allow-implausible", help="Take sizes and currents that are far from any silicon's."),
]
Stimuli = Annotated[
    list[str],
    typer.Option("--stimulus", metavar="NAME=VALUE", help="As delay=6.4ms or call=off, repeatable."),
]
Held = Annotated[
    list[str],
    typer.Option("--ic", metavar="NODE=V", help="Voltage that a node is held at until time 0, repeatable."),
]
Uic = Annotated[
    bool, typer.Option("--uic", help="Begin with --ic and 0 V elsewhere, without an operating point.")
]
AtRest = Annotated[bool, typer.Option("--at-rest", help="Stay in an operating point that is not stable.")]
Targets = Annotated[str | None, typer.Option("--targets", metavar="FILE", help="CSV of moving targets.")]
Plot = Annotated[
    str | None, typer.Option("--plot", metavar="FILE", help="Draw into a .png, .svg or .pdf file.")
]
NetlistRoot = Annotated[
    str | None, typer.Option("--root", metavar="DIR", help="Folder of included files; the netlist's own.")
]
NetlistDialect = Annotated[
    str | None, typer.Option("--dialect", metavar="NAME", help="Of a netlist without our notes, as cdl.")
]
Deadline = Annotated[str | None, typer.Option("--deadline", metavar="TIME", help=DEADLINE_HELP)]
NetlistDrop = Annotated[
    list[str],
    typer.Option(
        "--drop",
        metavar="NAME,...",
        help="What may go though it cannot be honoured: a model, .model for all, .step, an option.",
    ),
]
Seed = Annotated[int, typer.Option(help="Of noise and worlds.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]


def kind_name(kind: BiasKind | None) -> str | None:
    """What commands call a kind of bias."""
    return None if kind is None else kind.value
