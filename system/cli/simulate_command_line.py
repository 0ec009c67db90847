"""The command `noctule simulate`: a transient of a block, its small signals, its noise."""

from __future__ import annotations

from typing import Annotated

import typer

from system.cli import analysis_options as of
from system.cli.analysis_options import Analysis, AnalysisChoice
from system.cli.command_options import (
    AtRest,
    Biases,
    BiasSet,
    BlockName,
    Deadline,
    Engine,
    Held,
    Json,
    Kind,
    Params,
    Plot,
    Stimuli,
    Uic,
    call,
    kind_name,
)
from system.cli.silicon_options import with_silicon
from system.options.begin import begin_choice
from system.options.silicon import SiliconChoice


@with_silicon()
def simulate(
    block: BlockName,
    *,
    analysis: of.Kind = Analysis.tran,
    stimulus: Stimuli = [],  # noqa: B006 - typer reads the default and never changes it
    param: Params = [],  # noqa: B006
    bias: Biases = [],  # noqa: B006
    bias_set: BiasSet = None,
    bias_kind: Kind = None,
    silicon: SiliconChoice,
    rtol: Annotated[
        float | None,
        typer.Option("--rtol", help="Local error a step relative to 1 V or more; 5e-7 unless given."),
    ] = None,
    engine: Annotated[Engine, typer.Option("--engine", help="What solves it.")] = Engine.native,
    deadline: Deadline = None,
    source: of.SourceName = None,
    node: of.Nodes = [],  # noqa: B006
    ic: Held = [],  # noqa: B006
    uic: Uic = False,
    at_rest: AtRest = False,
    low: of.Low = None,
    high: of.High = None,
    points: of.Points = None,
    dies: of.Dies = None,
    temperatures: of.Temperatures = None,
    flicker: of.Flicker = None,
    seed: of.Seed = None,
    trials: of.Trials = None,
    step: of.Step = None,
    workers: of.Workers = None,
    plot: Plot = None,
    csv: Annotated[
        str | None, typer.Option("--csv", metavar="FILE", help="Write all waveforms, or the table.")
    ] = None,
    netcdf: of.NetCdf = None,
    raw: Annotated[
        str | None, typer.Option("--raw", metavar="FILE", help="Write all waveforms as ngspice's rawfile.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Simulate a block under its testbench: a transient, small signals, or noise."""
    call(
        "simulate:simulate_command",
        block,
        params=param,
        biases=bias,
        bias_set=bias_set,
        bias_kind=kind_name(bias_kind),
        silicon=silicon,
        stimuli=stimulus,
        rtol=rtol,
        engine=engine.value,
        deadline=deadline,
        plot=plot,
        csv=csv,
        raw=raw,
        as_json=as_json,
        begin=begin_choice(ic, uic=uic, at_rest=at_rest),
        analysis=AnalysisChoice(
            analysis.value, source, tuple(node), low, high, points, dies, temperatures, netcdf, flicker,
            seed, trials, step, workers,
        ),
    )  # fmt: skip
