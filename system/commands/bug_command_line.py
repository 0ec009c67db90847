"""`noctule run bug`: the options of the Bug robots."""

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

Seed = Annotated[int, typer.Option(help="Of noise and worlds.")]


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
    area: Annotated[float | None, typer.Option(help="Of the chip's devices, relative; 1.")] = None,
    silicon_noise: Annotated[
        str | None, typer.Option(help="Of the chip's devices, by --seed: off, white, or all with flicker.")
    ] = None,
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
    """A robot with a compass and contact follows walls to its goal (Stöckel 2017)."""
    options = {
        "agent": agent, "brain": brain, "design": design, "neurons": neurons, "map": bug_map, "start": start,
        "goal": goal, "duration": duration, "calibrated": calibrated, "solved": solved, "area": area,
        "bias_kind": kind_name(bias_kind), "silicon_noise": silicon_noise,
    }  # fmt: skip
    call(
        "run_bug:run_bug",
        "bug",
        SiliconChoice(temperature, lot, die, corner.value, mismatch, process),
        seed,
        plot,
        as_json=as_json,
        **{name: value for name, value in options.items() if value is not None},
    )
