"""`noctule run bug`: the options of the Bug robots."""

from __future__ import annotations

from typing import Annotated

import typer

from system.cli.command_options import Json, Kind, Plot, Seed
from system.cli.silicon_options import runs
from system.options.silicon import SiliconChoice


@runs("bug", bug_map="map")
def bug(
    *,
    agent: Annotated[str | None, typer.Option(help="As bug0, bug1 or bug2.")] = None,
    brain: Annotated[
        str | None, typer.Option(help="As reference, a program, or neurons: ideal, or chip.")
    ] = None,
    design: Annotated[str | None, typer.Option(help="Of Bug 2's neurons: published or improved.")] = None,
    neurons: Annotated[int | None, typer.Option(help="How many in all, about; the design's.")] = None,
    bug_map: Annotated[
        str | None, typer.Option("--map", metavar="MAP", help="As bug-cup, or a file of # S G and spaces.")
    ] = None,
    start: Annotated[
        str | None, typer.Option(metavar="N|X,Y", help="Number of the S, from 0, or a place.")
    ] = None,
    goal: Annotated[str | None, typer.Option(metavar="N|X,Y", help="As --start, of a G.")] = None,
    duration: Annotated[
        str | None, typer.Option(metavar="TIME", help="After which the run ends; 200s.")
    ] = None,
    calibrated: Annotated[
        str | None, typer.Option(metavar="DEGC", help="Where the chip's biases were trimmed; 27.")
    ] = None,
    solved: Annotated[
        str | None, typer.Option(metavar="DEGC", help="Where its decoders were solved; as --calibrated.")
    ] = None,
    area: Annotated[str | None, typer.Option(help="Of the chip's devices, relative; 1.")] = None,
    silicon_noise: Annotated[
        str | None, typer.Option(help="Of the chip's devices, by --seed: off, white, or all with flicker.")
    ] = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """A robot with a compass and contact follows walls to its goal (Stöckel 2017)."""
