"""`noctule run head`: the options of the sonar head."""

from __future__ import annotations

from typing import Annotated

import typer

from system.command_options import (
    Corner,
    DieCorner,
    DieNumber,
    Json,
    Kind,
    Lot,
    Mismatch,
    Plot,
    Process,
    Temperature,
    call,
    kind_name,
)
from system.silicon_choice import SiliconChoice

Seed = Annotated[int, typer.Option(help="Of noise and walks.")]


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
    bias_kind: Kind = None,
    temperature: Temperature = "27",
    lot: Lot = "A",
    die: DieNumber = None,
    corner: DieCorner = Corner.random,
    mismatch: Mismatch = True,
    process: Process = True,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """A sonar head turns to a moving target by its two ears (Cheely & Horiuchi 2003)."""
    options = {
        "motion": motion, "wiring": wiring, "gain": gain, "ping_rate": ping_rate, "azimuth": azimuth,
        "period": period, "distance": distance, "swing": swing, "noise": noise, "duration": duration,
        "area": area, "bias_kind": kind_name(bias_kind),
    }  # fmt: skip
    call(
        "run_head:run_head",
        "head",
        SiliconChoice(temperature, lot, die, corner.value, mismatch, process),
        seed,
        plot,
        as_json=as_json,
        **{name: value for name, value in options.items() if value is not None},
    )
