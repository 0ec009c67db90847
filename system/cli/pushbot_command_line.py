"""`noctule run pushbot`: the options of the Pushbot."""

from __future__ import annotations

from typing import Annotated

import typer

from system.cli.command_options import Json, Kind, Plot, Seed
from system.cli.silicon_options import runs
from system.options.silicon import SiliconChoice


@runs("pushbot", drop="dropped")
def pushbot(
    *,
    scene: Annotated[
        str | None, typer.Option(metavar="SCENE", help="As single-block, or a FILE.toml; single-block.")
    ] = None,
    speed_factor: Annotated[str | None, typer.Option(help="Of equation (2); 0.5, about 0.35 m/s.")] = None,
    turn_factor: Annotated[
        str | None, typer.Option(help="Of equation (1); 0.5, or 2 with --modified.")
    ] = None,
    window: Annotated[
        str | None, typer.Option(metavar="TIME", help="In which spikes are counted; 500ms.")
    ] = None,
    readout: Annotated[
        str | None,
        typer.Option(help="As sliding, fixed: a command at each window's end, or spikes: to the motors."),
    ] = None,
    modified: Annotated[
        bool | None, typer.Option(help="Gyro-driven suppression and graded weights (section 3.4).")
    ] = None,
    drop: Annotated[
        str | None, typer.Option(metavar="SHARE", help="Of events that are dropped at random; 0.8.")
    ] = None,
    colour: Annotated[str | None, typer.Option(help="Of the blocks, as blue, red or yellow.")] = None,
    light: Annotated[str | None, typer.Option(help="As normal, dark, very-dark, or 500lux.")] = None,
    target: Annotated[
        bool | None, typer.Option(help="Events to the target field; where the scene has a target.")
    ] = None,
    exc: Annotated[int | None, typer.Option(help="Neurons that fire constantly; 16.")] = None,
    frame: Annotated[
        bool | None,
        typer.Option("--frame", help="A target frame that keeps its orientation, on a second chip."),
    ] = None,
    raise_lateral: Annotated[
        bool | None,
        typer.Option("--raise-lateral", help="Stronger lateral weights while the target is lost."),
    ] = None,
    calibrated: Annotated[
        bool | None,
        typer.Option("--calibrated/--uncalibrated", help="Codes of the die's own calibration; they are."),
    ] = None,
    duration: Annotated[
        str | None, typer.Option(metavar="TIME", help="After which the run ends; the scene's.")
    ] = None,
    way: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="After which the run ends too; none.")
    ] = None,
    events: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Write events that arrived into a .aedat4, .npz or .txt."),
    ] = None,
    silicon_noise: Annotated[
        str | None, typer.Option(help="Of the chip's devices, by --seed: off, white, or all with flicker.")
    ] = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """A robot avoids obstacles by an event camera and the ROLLS chip (Milde et al. 2017)."""
