"""`noctule run head`: the options of the sonar head."""

from __future__ import annotations

from typing import Annotated

import typer

from system.command_options import Json, Kind, Plot, Seed
from system.silicon_choice import SiliconChoice
from system.silicon_options import runs


@runs("head")
def head(
    *,
    motion: Annotated[str | None, typer.Option(help="Of the target: sine, step or walk; sine.")] = None,
    wiring: Annotated[
        str | None,
        typer.Option(help="As lso, excitation without inhibition, or one-ear against what is usual; lso."),
    ] = None,
    gain: Annotated[float | None, typer.Option(metavar="DEG", help="Of the neck a spike; 1.5.")] = None,
    ping_rate: Annotated[float | None, typer.Option(metavar="HZ", help="10.")] = None,
    azimuth: Annotated[float | None, typer.Option(metavar="DEG", help="Largest, of the target; 40.")] = None,
    period: Annotated[str | None, typer.Option(metavar="TIME", help="Of the sine; 10s.")] = None,
    distance: Annotated[float | None, typer.Option(metavar="M", help="Of the target, mean; 1.")] = None,
    swing: Annotated[float | None, typer.Option(metavar="M", help="Of the distance, each way; 0.4.")] = None,
    noise: Annotated[float | None, typer.Option(help="Of each ear's echo, relative rms; 0.1.")] = None,
    duration: Annotated[str | None, typer.Option(metavar="TIME", help="20s.")] = None,
    area: Annotated[float | None, typer.Option(help="Of the chip's devices, relative, from 1/16; 1.")] = None,
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
