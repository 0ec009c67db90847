"""`noctule run rolls`: the options of the rates of a die's neurons."""

from __future__ import annotations

from typing import Annotated

import typer

from system.cli.command_options import BiasFile, Json, Kind, Plot, Seed
from system.cli.silicon_options import runs
from system.options.silicon import SiliconChoice


@runs("rolls")
def rolls(
    *,
    bias_file: BiasFile = None,
    input_rate: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help="Of events a neuron, 0Hz for none; 100Hz.")
    ] = None,
    duration: Annotated[str | None, typer.Option(metavar="TIME", help="1s; rates from 0.1s on.")] = None,
    silicon_noise: Annotated[
        str | None, typer.Option(help="Of the chip's devices, by --seed: off, white, or all with flicker.")
    ] = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """All neurons of a ROLLS die under equal input."""
