"""`noctule run head`: the options of the sonar head."""

from __future__ import annotations

from typing import Annotated

import typer

from system.cli.command_options import Json, Kind, Plot, Seed
from system.cli.silicon_options import runs
from system.options.silicon import SiliconChoice


@runs("head")
def head(
    *,
    motion: Annotated[str | None, typer.Option(help="Of the target: sine, step or walk; sine.")] = None,
    wiring: Annotated[
        str | None,
        typer.Option(help="As lso, excitation without inhibition, or one-ear against what is usual; lso."),
    ] = None,
    gain: Annotated[str | None, typer.Option(metavar="ANGLE", help="Of the neck a spike; 1.5deg.")] = None,
    ping_rate: Annotated[str | None, typer.Option(metavar="FREQUENCY", help="Of pings; 10Hz.")] = None,
    azimuth: Annotated[str | None, typer.Option(metavar="ANGLE", help="Of the target; 40deg.")] = None,
    period: Annotated[str | None, typer.Option(metavar="TIME", help="Of the sine; 10s.")] = None,
    distance: Annotated[str | None, typer.Option(metavar="LENGTH", help="Of the target, mean; 1m.")] = None,
    swing: Annotated[str | None, typer.Option(metavar="LENGTH", help="Of the distance; 0.4m.")] = None,
    noise: Annotated[str | None, typer.Option(help="Of each ear's echo, relative rms; 0.1.")] = None,
    duration: Annotated[str | None, typer.Option(metavar="TIME", help="20s.")] = None,
    area: Annotated[str | None, typer.Option(help="Of the chip's devices, relative, from 1/16; 1.")] = None,
    silicon_noise: Annotated[
        str | None, typer.Option(help="Of the chip's devices, by --seed: off, white, or all with flicker.")
    ] = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """A sonar head turns to a moving target by its two ears (Cheely & Horiuchi 2003)."""
