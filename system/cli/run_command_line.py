"""`noctule run SYSTEM`: a command a system, with its own options.

A user's own system runs under the options of the approach, whose scenario it takes.
"""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from system.cli.bug_command_line import bug
from system.cli.command_options import Json, Kind, Plot, Seed, Targets, call
from system.cli.given_once import App
from system.cli.head_command_line import head
from system.cli.pushbot_command_line import pushbot
from system.cli.rolls_command_line import rolls
from system.cli.silicon_options import runs, with_silicon
from system.options.silicon import SiliconChoice
from system.registry import load_system

USERS = "approach"  # the command that systems of users run under


class Systems(TyperGroup):
    """Names of systems as commands; a name that is none is refused with near ones."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of a system."""
        found = super().get_command(ctx, cmd_name)
        if found is None:
            load_system(cmd_name)
            found = super().get_command(ctx, USERS)
        return found


app = App(cls=Systems, help="Run a system in its world.", rich_markup_mode=None)


def add_to(parent: typer.Typer) -> None:
    """Make `run` a command of `parent`."""
    parent.add_typer(app, name="run")


@app.callback(invoke_without_command=True)
def run(context: typer.Context) -> None:
    """Run a system in its world."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command()
@with_silicon("at", "allow_implausible")
def approach(
    context: typer.Context,
    *,
    targets: Targets = None,
    level: Annotated[str | None, typer.Option(help="As transistor or behavioural.")] = None,
    transistors: Annotated[
        list[str], typer.Option("--transistors", metavar="BOX", help="A box kept as transistors, repeatable.")
    ] = [],  # noqa: B006 - typer reads the default and never changes it
    isolation: Annotated[bool, typer.Option(help="First-target isolation.")] = True,
    amplitude_law: Annotated[str | None, typer.Option(help="Of the call: linear or d4.")] = None,
    duration: Annotated[str | None, typer.Option(metavar="TIME", help="Length of the run, as 2s.")] = None,
    noise: Annotated[str | None, typer.Option(metavar="VOLTAGE", help="Rms at a microphone, as 1mV.")] = None,
    silicon_noise: Annotated[
        str | None, typer.Option(help="Of the chip's devices, by --seed: off, white, or all with flicker.")
    ] = None,
    silicon: SiliconChoice,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """A bat's sonar closes in on targets (Cheely & Horiuchi 2003)."""
    call(
        "run_approach:run_approach",
        context.info_name,
        silicon,
        seed,
        plot,
        targets=targets,
        level=level,
        transistors=transistors,
        isolation=isolation,
        amplitude_law=amplitude_law,
        duration=duration,
        noise=noise,
        silicon_noise=silicon_noise,
        as_json=as_json,
    )


@app.command()
@runs("rover", cost_map="map")
def rover(
    *,
    cost_map: Annotated[
        str | None, typer.Option("--map", metavar="MAP", help="As map1-road, or a file of costs.")
    ] = None,
    start: Annotated[
        str | None, typer.Option(metavar="ROW,COLUMN", help="From 0, row 0 in the north.")
    ] = None,
    goal: Annotated[str | None, typer.Option(metavar="ROW,COLUMN", help="As --start.")] = None,
    planner: Annotated[
        str | None, typer.Option(help="As wave, paper, a-star, admissible-a-star or dijkstra.")
    ] = None,
    cells: Annotated[str | None, typer.Option(help="As ideal, or chip for a die's.")] = None,
    bias_kind: Kind = None,
    unit: Annotated[
        str | None, typer.Option(metavar="TIME", help="Of the chip: delay a unit of cost; 100us.")
    ] = None,
    silicon_noise: Annotated[
        str | None, typer.Option(help="Of the chip's devices, by --seed: off, white, or all with flicker.")
    ] = None,
    need: Annotated[str | None, typer.Option(help="As energy, the map itself, or speed.")] = None,
    learn: Annotated[str | None, typer.Option(metavar="RATE", help="Learn the map, above 0 up to 1.")] = None,
    prior: Annotated[
        str | None, typer.Option(metavar="COST", help="What unknown cells are taken for; 5.")
    ] = None,
    trips: Annotated[int | None, typer.Option(help="How often the way is planned and driven; 1.")] = None,
    posts: Annotated[bool | None, typer.Option(help="Obstacles that no map has.")] = None,
    sonar: Annotated[bool | None, typer.Option(help="Turn away from what sonars see.")] = None,
    silicon: SiliconChoice,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """A rover plans on a delay-line chip and drives the way (Hwu et al. 2018)."""


@app.command()
@runs("forest", forest_map="map")
def forest(
    *,
    model: Annotated[
        str | None,
        typer.Option(help="Of the bat's mind: analog, latency-network, latency-lif, latency-chip."),
    ] = None,
    paths: Annotated[int | None, typer.Option(help="Memories of a latency model; 33.")] = None,
    taps: Annotated[int | None, typer.Option(help="Of a latency model's delay line; 15.")] = None,
    codes: Annotated[
        str | None,
        typer.Option(help="Of a latency chip's biases: usual, or calibrated on its die at 27 degC."),
    ] = None,
    units: Annotated[
        list[str] | None,
        typer.Option("--unit", metavar="MEMORY,UNIT", help="A latency chip's unit at transistor level."),
    ] = None,
    forest_map: Annotated[
        str | None, typer.Option("--map", metavar="FILE", help="Obstacles, x_m,y_m a line; else planted.")
    ] = None,
    obstacles: Annotated[int | None, typer.Option(help="How many are planted from the seed; 1400.")] = None,
    vmax: Annotated[str | None, typer.Option(metavar="SPEED", help="Straight ahead; 2m/s.")] = None,
    ping_rate: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help="Of pings; 5Hz, of a latency model 10Hz.")
    ] = None,
    start: Annotated[str | None, typer.Option(metavar="X,Y", help="As 40m,25m; drawn unless given.")] = None,
    pings: Annotated[
        int | None, typer.Option(help="Ends undecided after these; 20000, of a latency model 1000.")
    ] = None,
    ranges: Annotated[str | None, typer.Option(help="As exact, sonar or chip.")] = None,
    selection: Annotated[str | None, typer.Option(help="As ideal, or chip for a die's.")] = None,
    weights: Annotated[str | None, typer.Option(help="As fixed, or speed to depend on --vmax.")] = None,
    occlusion: Annotated[bool | None, typer.Option(help="Obstacles hide those behind them.")] = None,
    multipath: Annotated[bool | None, typer.Option(help="Echoes by way of two obstacles.")] = None,
    azimuth_noise: Annotated[
        str | None, typer.Option(metavar="ANGLE", help="Of every echo, standard deviation; 0deg.")
    ] = None,
    reader: Annotated[
        str | None, typer.Option(help="Of a chip's ranges: nominal, or calibrated on its die at 27 degC.")
    ] = None,
    area: Annotated[str | None, typer.Option(metavar="FACTOR", help="Of a chip's devices; 1.")] = None,
    silicon_noise: Annotated[
        str | None,
        typer.Option(
            help="Of chips' devices (latency, ranging, selection): off, white, or all with flicker."
        ),
    ] = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    animate: Annotated[
        str | None, typer.Option(metavar="FILE", help="Draw the first pings into a .gif file.")
    ] = None,
    seed: Seed = 0,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """A bat flies through a dense forest by narrow pings (Wen & Horiuchi 2022)."""


@app.command()
@runs("robot", pipes="forest")
def robot(
    *,
    pipes: Annotated[
        str | None,
        typer.Option("--forest", metavar="FOREST", help="As corridor, open, dense, or a FILE; corridor."),
    ] = None,
    ranges: Annotated[
        str | None, typer.Option(help="As flight, of the echoes, exact places, or chip to time echoes.")
    ] = None,
    occlusion: Annotated[bool | None, typer.Option(help="Pipes hide those behind; they do.")] = None,
    multipath: Annotated[bool | None, typer.Option(help="Echoes by way of two pipes; there are.")] = None,
    soft_pings: Annotated[
        bool | None, typer.Option(help="A softer ping where something is near; there is.")
    ] = None,
    vmax: Annotated[str | None, typer.Option(metavar="SPEED", help="Straight ahead, as 0.5m/s.")] = None,
    ping_rate: Annotated[str | None, typer.Option(metavar="FREQUENCY", help="Head at rest; 12Hz.")] = None,
    start: Annotated[str | None, typer.Option(metavar="X,Y", help="As 40m,25m; drawn unless given.")] = None,
    pings: Annotated[int | None, typer.Option(help="Ends undecided after these; 1500.")] = None,
    reader: Annotated[
        str | None, typer.Option(help="Of a chip's ranges: nominal, or calibrated on its die at 27 degC.")
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
    """A car with a narrow sonar drives through pipes (Wen & Horiuchi 2022)."""


for _command in (bug, pushbot, head, rolls):
    app.command()(_command)
