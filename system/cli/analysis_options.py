"""Options of the analyses of `noctule simulate` beyond the transient, and which analysis takes which."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Annotated

import typer

from circuits.errors import ParameterError


class Analysis(StrEnum):
    """What is simulated: waveforms, small signals, noise about a rest state, waveforms with noise."""

    tran = "tran"
    ac = "ac"
    noise = "noise"
    tran_noise = "tran-noise"


Kind = Annotated[Analysis, typer.Option("--analysis", help="What is simulated.")]
SourceName = Annotated[
    str | None,
    typer.Option("--source", metavar="NAME", help="ac: which source moves; noise: refer the noise to it."),
]
Nodes = Annotated[
    list[str],
    typer.Option("--node", metavar="PATH", help="ac: nodes to print, repeatable; noise: the output."),
]
Low = Annotated[str | None, typer.Option("--from", metavar="FREQUENCY", help="ac, noise: 1Hz unless given.")]
High = Annotated[str | None, typer.Option("--to", metavar="FREQUENCY", help="ac, noise: 1MHz unless given.")]
Points = Annotated[
    int | None, typer.Option("--points", help="ac, noise: frequencies a decade, 20 unless given.")
]
Dies = Annotated[
    str | None,
    typer.Option("--dies", metavar="FIRST-LAST", help="ac, noise: several dies, as 1000-1019."),
]
Temperatures = Annotated[
    str | None,
    typer.Option("--temperatures", metavar="DEGC,...", help="ac, noise: several, as -20,27,85."),
]
NetCdf = Annotated[
    str | None, typer.Option("--netcdf", metavar="FILE", help="ac, noise, tran-noise: write a netCDF file.")
]
Flicker = Annotated[
    bool | None,
    typer.Option("--flicker/--no-flicker", help="noise, tran-noise: flicker too; on unless given."),
]
Seed = Annotated[int | None, typer.Option("--seed", help="tran-noise: of the noise, 0 unless given.")]
Trials = Annotated[int | None, typer.Option("--trials", help="tran-noise: runs, 1 unless given.")]
Step = Annotated[
    str | None,
    typer.Option("--step", metavar="TIME", help="tran-noise: a noise current stands for this long."),
]
Workers = Annotated[
    int | None, typer.Option("--workers", help="tran-noise: threads, all cores unless given.")
]


@dataclass(frozen=True, slots=True)
class AnalysisChoice:
    """What the options say, as texts and numbers; None and () for what was not given."""

    analysis: str = "tran"
    source: str | None = None
    nodes: tuple[str, ...] = ()
    low: str | None = None
    high: str | None = None
    points: int | None = None
    dies: str | None = None
    temperatures: str | None = None
    netcdf: str | None = None
    flicker: bool | None = None
    seed: int | None = None
    trials: int | None = None
    step: str | None = None
    workers: int | None = None


_SWEEP = {"source", "nodes", "low", "high", "points", "dies", "temperatures", "netcdf"}
_TAKES = {
    "tran": set[str](),
    "ac": _SWEEP,
    "noise": {*_SWEEP, "flicker"},
    "tran-noise": {"netcdf", "flicker", "seed", "trials", "step", "workers"},
}
_OPTION = {"low": "--from", "high": "--to", "nodes": "--node"}


def check_options(choice: AnalysisChoice, others: dict[str, object]) -> None:
    """Refuse by name every option that the analysis does not take.

    others: values of options outside `choice` that only some analyses have, None where not given.
    """
    given = {f.name: getattr(choice, f.name) for f in fields(choice) if f.name != "analysis"}
    wrong = [n for n, v in given.items() if v not in {None, ()} and n not in _TAKES[choice.analysis]]
    wrong += [name for name, value in others.items() if value is not None]
    if wrong:
        option = _OPTION.get(wrong[0], f"--{wrong[0].replace('_', '-')}")
        raise ParameterError(f"{option}: not of --analysis {choice.analysis}; leave it out")
