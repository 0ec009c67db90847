"""The commands on studies: `noctule montecarlo`, `noctule replay` and `noctule centre`."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from system.cli.command_options import (
    AllowImplausible,
    At,
    AtRest,
    Biases,
    BiasSet,
    BlockName,
    Corner,
    Deadline,
    Engine,
    Held,
    Json,
    Kind,
    Level,
    Lot,
    Mismatch,
    Params,
    Plot,
    Process,
    Stimuli,
    Temperature,
    Uic,
    call,
    kind_name,
)
from system.cli.run_command_line import names_in_study
from system.options.begin import begin_choice
from system.options.silicon import SiliconChoice


class PlanMethod(StrEnum):
    """How a study's dies are drawn."""

    random = "random"
    lhs = "lhs"
    sobol = "sobol"


class RareMethod(StrEnum):
    """How the probability of a rare failure is estimated."""

    scaled_sigma = "scaled-sigma"
    mean_shift = "mean-shift"


class SearchLevel(StrEnum):
    """What a search measures its dies with."""

    auto = "auto"
    behavioural = "behavioural"
    transistor = "transistor"


StudyOut = Annotated[
    str | None, typer.Option("--output", "-o", metavar="FOLDER", help="Keep samples and manifest there.")
]


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    montecarlo.said = names_in_study  # type: ignore[attr-defined]
    app.command()(montecarlo)
    app.command()(replay)
    app.command()(centre)


def montecarlo(
    target: Annotated[str, typer.Argument(metavar="TARGET", help="A block, chip or system.")],
    *,
    metric: Annotated[
        list[str],
        typer.Option(
            "--metric",
            metavar="NAME",
            help="Measured, or MODULE:FUNCTION, repeatable; the target's own unless options name some.",
        ),
    ] = [],  # noqa: B006 - typer reads the default and never changes it
    samples: Annotated[int, typer.Option("--samples", "-n", help="Number of dies.")] = 200,
    first_die: Annotated[int, typer.Option(help="Number of the first die.")] = 1000,
    lot: Lot = "A",
    corner: Annotated[
        list[Corner], typer.Option("--corner", help="Process corner; n first, then p; repeatable.")
    ] = [Corner.random],  # noqa: B006
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    allow_implausible: AllowImplausible = False,
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
    ic: Held = [],  # noqa: B006
    uic: Uic = False,
    at_rest: AtRest = False,
    level: Annotated[Level, typer.Option(help="Of a system.")] = Level.behavioural,
    duration: Annotated[
        str | None, typer.Option(metavar="TIME", help="Of a system's run; the system's own.")
    ] = None,
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
    contributions: Annotated[
        str | None, typer.Option(metavar="METRIC", help="What its variance comes from, by device and so on.")
    ] = None,
    pareto: Annotated[
        str | None, typer.Option(metavar="FILE", help="Draw contributions into a .png, .svg or .pdf file.")
    ] = None,
    rare: Annotated[
        RareMethod | None, typer.Option(help="Estimate how seldom a die fails --spec, by this method.")
    ] = None,
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
        begin=begin_choice(ic, uic=uic, at_rest=at_rest),
        silicon=SiliconChoice("27", lot, None, "random", mismatch, process, at, None, allow_implausible),
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
        contributions=contributions,
        pareto=pareto,
        rare=None if rare is None else rare.value,
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
    metric: Annotated[
        list[str],
        typer.Option(
            "--metric", metavar="NAME", help="MODULE:FUNCTION of the study's, which is code; repeatable."
        ),
    ] = [],  # noqa: B006
    engine: Annotated[Engine, typer.Option("--engine", help="What solves the testbench.")] = Engine.native,
    deadline: Deadline = None,
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
        metrics=metric,
        engine=engine.value,
        deadline=deadline,
        plot=plot,
        csv=csv,
        raw=raw,
        as_json=as_json,
    )


def centre(
    block: BlockName,
    *,
    spec: Annotated[
        list[str],
        typer.Option("--spec", metavar="TEXT", help='What should pass, as "class is works", repeatable.'),
    ] = [],  # noqa: B006 - typer reads the default and never changes it
    metric: Annotated[
        list[str],
        typer.Option("--metric", metavar="NAME", help="Measured besides those of the specs, repeatable."),
    ] = [],  # noqa: B006
    move: Annotated[
        list[str],
        typer.Option("--move", metavar="BIAS", help="Moved; every current unless given; repeatable."),
    ] = [],  # noqa: B006
    move_param: Annotated[
        list[str], typer.Option("--move-param", metavar="NAME", help="A size that is moved too, repeatable.")
    ] = [],  # noqa: B006
    reach: Annotated[
        float, typer.Option("--range", metavar="FACTOR", help="How far currents move, each way.")
    ] = 3.0,
    span: Annotated[
        str, typer.Option("--span", metavar="VOLTAGE", help="How far voltages move, each way.")
    ] = "100mV",
    tuning_dies: Annotated[int, typer.Option(help="Dies of the search, from 0 on, at most 1000.")] = 200,
    fresh_dies: Annotated[int, typer.Option(help="Dies of the report.")] = 1000,
    first_fresh_die: Annotated[int, typer.Option(help="The first of them, 1000 or later.")] = 1000,
    level: Annotated[
        SearchLevel, typer.Option(help="Of the search; auto takes a model where there is one.")
    ] = SearchLevel.auto,
    generations: Annotated[int, typer.Option(help="Of the search's first stage.")] = 10,
    seed: Annotated[int, typer.Option(help="Of the search; a die has its own key.")] = 0,
    lot: Lot = "A",
    mismatch: Mismatch = True,
    process: Process = True,
    at: At = None,
    allow_implausible: AllowImplausible = False,
    temperature: Temperature = "27",
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_set: BiasSet = None,
    bias_kind: Kind = None,
    stimulus: Stimuli = [],  # noqa: B006
    threads: Annotated[int | None, typer.Option(help="All cores unless given.")] = None,
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="FILE", help="Write the result as JSON.")
    ] = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Move biases so that more dies pass, and report on fresh dies."""
    call(
        "centre:centre_command",
        block=block,
        specs=spec,
        metrics=metric,
        moves=move,
        move_params=move_param,
        reach=reach,
        span=span,
        tuning_dies=tuning_dies,
        fresh_dies=fresh_dies,
        first_fresh_die=first_fresh_die,
        level=level.value,
        generations=generations,
        seed=seed,
        silicon=SiliconChoice(
            temperature, lot, None, "random", mismatch, process, at, None, allow_implausible
        ),
        params=param,
        biases=bias,
        bias_set=bias_set,
        bias_kind=kind_name(bias_kind),
        stimuli=stimulus,
        threads=threads,
        output=output,
        plot=plot,
        as_json=as_json,
    )
