"""The commands on studies: `noctule montecarlo` and `noctule replay`."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from system.command_options import (
    At,
    Biases,
    BiasSet,
    Corner,
    Engine,
    Json,
    Kind,
    Lot,
    Mismatch,
    Params,
    Plot,
    Process,
    Stimuli,
    call,
    kind_name,
)
from system.silicon_choice import SiliconChoice


class PlanMethod(StrEnum):
    """How a study's dies are drawn."""

    random = "random"
    lhs = "lhs"
    sobol = "sobol"


class Level(StrEnum):
    """How a system's boxes are run."""

    behavioural = "behavioural"
    transistor = "transistor"


StudyOut = Annotated[
    str | None, typer.Option("--output", "-o", metavar="FOLDER", help="Keep samples and manifest there.")
]


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    app.command()(montecarlo)
    app.command()(replay)


def montecarlo(
    target: Annotated[str, typer.Argument(metavar="TARGET", help="A block, chip or system.")],
    *,
    metric: Annotated[
        list[str],
        typer.Option("--metric", metavar="NAME", help="What is measured, or MODULE:FUNCTION; repeatable."),
    ] = ["best_delay"],  # noqa: B006 - typer reads the default and never changes it
    samples: Annotated[int, typer.Option("--samples", "-n", help="Number of dies.")] = 200,
    first_die: Annotated[int, typer.Option(help="Number of the first die.")] = 1000,
    lot: Lot = "A",
    corner: Annotated[
        list[Corner], typer.Option("--corner", help="Process corner; n first, then p; repeatable.")
    ] = [Corner.random],  # noqa: B006
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    temperature: Annotated[
        list[str], typer.Option("--temperature", metavar="DEGC", help="Degrees Celsius, repeatable.")
    ] = ["27"],  # noqa: B006
    trials: Annotated[int, typer.Option(help="Runs of a system on each die, with seeds of their own.")] = 1,
    plan: Annotated[PlanMethod, typer.Option(help="How the dies are drawn.")] = PlanMethod.random,
    seed: Annotated[int, typer.Option(help="Of the plan and of bootstraps; a die has its own key.")] = 0,
    spec: Annotated[
        list[str],
        typer.Option("--spec", metavar="TEXT", help='As "best_delay in 5.9ms:6.8ms", repeatable.'),
    ] = [],  # noqa: B006
    until: Annotated[
        str | None, typer.Option(metavar="SHARE", help="Stop when the yield is known to +- this, as 2%.")
    ] = None,
    require: Annotated[
        str | None, typer.Option(metavar="SHARE", help="Stop when the yield is surely above or below.")
    ] = None,
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_set: BiasSet = None,
    bias_kind: Kind = None,
    stimulus: Stimuli = [],  # noqa: B006
    level: Annotated[Level, typer.Option(help="Of a system.")] = Level.behavioural,
    duration: Annotated[str, typer.Option(metavar="TIME", help="Of a system's run.")] = "4s",
    threads: Annotated[int | None, typer.Option(help="All cores unless given.")] = None,
    workers: Annotated[int | None, typer.Option(help="Processes of a local Dask cluster.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Dask cluster, as tcp://host:8786.")
    ] = None,
    chunk: Annotated[int, typer.Option(help="Dies that are measured and kept together.")] = 32,
    output: StudyOut = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the study in --output.")] = False,
    csv: Annotated[str | None, typer.Option("--csv", metavar="FILE", help="Write a row a sample.")] = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Measure a block, chip or system on many dies: statistics, and what share works."""
    call(
        "montecarlo:montecarlo_command",
        target=target,
        metrics=metric,
        params=param,
        biases=bias,
        bias_set=bias_set,
        bias_kind=kind_name(bias_kind),
        stimuli=stimulus,
        silicon=SiliconChoice("27", lot, None, "random", mismatch, process, at),
        level=level.value,
        duration=duration,
        temperatures=temperature,
        corners=[c.value for c in corner],
        trials=trials,
        samples=samples,
        first_die=first_die,
        plan=plan.value,
        seed=seed,
        chunk=chunk,
        specs=spec,
        until=until,
        require=require,
        threads=threads,
        workers=workers,
        scheduler=scheduler,
        output=output,
        resume=resume,
        csv=csv,
        plot=plot,
        as_json=as_json,
    )


def replay(
    study: Annotated[str, typer.Argument(metavar="STUDY", help="Folder of a study.")],
    *,
    die: Annotated[int, typer.Option("--die", help="Die of the study.")],
    corner: Annotated[
        Corner | None, typer.Option("--corner", help="The first of the study's unless given.")
    ] = None,
    temperature: Annotated[
        str | None,
        typer.Option("--temperature", metavar="DEGC", help="The first of the study's unless given."),
    ] = None,
    trial: Annotated[int | None, typer.Option(help="The first unless given.")] = None,
    engine: Annotated[Engine, typer.Option("--engine", help="What solves the testbench.")] = Engine.native,
    plot: Plot = None,
    csv: Annotated[str | None, typer.Option("--csv", metavar="FILE", help="Write all waveforms.")] = None,
    raw: Annotated[
        str | None, typer.Option("--raw", metavar="FILE", help="Write all waveforms as ngspice's rawfile.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure one sample of a study again, and run its testbench."""
    call(
        "replay:replay_command",
        study,
        die=die,
        corner=None if corner is None else corner.value,
        temperature=temperature,
        trial=trial,
        engine=engine.value,
        plot=plot,
        csv=csv,
        raw=raw,
        as_json=as_json,
    )
