"""The verb `simulate` for transients, small signals and noise of a block, with the options of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from circuits.errors import ParameterError
from system.cli import shared_options as shared
from system.cli.option_names import option_of
from system.cli.shared_options import BlockValues, Engine, OnBlock
from system.option import option
from system.options.begin import BeginChoice
from system.options.silicon import SiliconChoice

Analysis = Literal["tran", "dc", "ac", "noise", "tran-noise"]
ANALYSES: tuple[Analysis, ...] = ("tran", "dc", "ac", "noise", "tran-noise")


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulate(OnBlock):
    """Simulate a block: a transient, small signals, or noise."""

    analysis: Analysis = option("tran", "What is simulated; dc is a deck's own sweep")
    stimulus: tuple[str, ...] = shared.stimulus_option()
    measure: tuple[str, ...] = shared.measure_option()
    values: BlockValues = shared.values_part("bias_file")
    silicon: SiliconChoice = shared.silicon_part()
    current: tuple[str, ...] = option(
        (), "tran: written by --csv too: a device's path, or i(SOURCE); repeatable", metavar="NAME"
    )
    rtol: float | None = option(None, "Local error a step relative to 1 V or more; 5e-7 unless given")
    engine: Engine = option("native", "What solves it")
    deadline: str | None = shared.deadline_option()
    verilog_a: str | None = shared.file_option("Transistors by models in Verilog-A, of a TOML file")
    source: str | None = option(None, "ac: which source moves; noise: refer the noise to it", metavar="NAME")
    node: tuple[str, ...] = option(
        (), "ac: nodes to print, repeatable; noise: the output, or two for v(A,B)", metavar="PATH"
    )
    begin: BeginChoice = shared.begin_part()
    low: str | None = option(None, "ac, noise: 1Hz unless given", name="from", metavar="FREQUENCY")
    high: str | None = option(None, "ac, noise: 1MHz unless given", name="to", metavar="FREQUENCY")
    points: int | None = option(None, "ac, noise: frequencies a decade, 20 unless given")
    dies: str | None = option(None, "ac, noise: several dies, as 1000-1019", metavar="FIRST-LAST")
    temperatures: str | None = option(None, "ac, noise: several, as -20,27,85", metavar="DEGC,...")
    flicker: bool | None = option(
        None, "noise, tran-noise: flicker too; on unless given", opposite="no_flicker"
    )
    seed: int | None = option(None, "tran-noise: of the noise, 0 unless given")
    trials: int | None = option(None, "tran-noise: runs, 1 unless given")
    step: str | None = option(None, "tran-noise: a noise current stands for this long", metavar="TIME")
    workers: int | None = option(None, "tran-noise: threads, all cores unless given")
    plot: str | None = shared.plot_option()
    csv: str | None = shared.file_option("Write all waveforms, or the table")
    netcdf: str | None = shared.file_option("ac, noise, tran-noise: write a netCDF file")
    raw: str | None = shared.file_option("Write all waveforms as ngspice's rawfile")
    spikes: str | None = shared.spikes_option()
    view: str | None = option(None, "tran: page that plays the run, for a browser", metavar="FILE.html")
    output: str | None = option(None, "tran: keep the run, for noctule view", short="o", metavar="RUN.nc")
    as_json: bool = shared.json_option()


_NAMES = {"low": "from", "high": "to"}  # of options that are not called as their fields
TAKEN_BY: dict[str, tuple[str, ...]] = {  # options that not every analysis has
    **dict.fromkeys(("source", "node", "low", "high", "points", "dies", "temperatures"), ("ac", "noise")),
    "netcdf": ("ac", "noise", "tran-noise"),
    "flicker": ("noise", "tran-noise"),
    **dict.fromkeys(("seed", "trials", "step", "workers"), ("tran-noise",)),
    **dict.fromkeys(
        ("rtol", "raw", "spikes", "at_rest", "current", "verilog_a", "view", "output"), ("tran",)
    ),
    "measure": ("tran", "dc", "ac"),
    **dict.fromkeys(("ic", "uic"), ("tran", "tran-noise")),
    "engine": ("tran", "dc", "ac"),
}


def check_options(asked: Simulate) -> None:
    """Raise `ParameterError` with the name of an option that the analysis does not take."""
    begin = asked.begin
    others = {
        "at_rest": begin.begin == "at_rest", "ic": bool(begin.held), "uic": begin.begin == "uic",
        "engine": asked.engine != "native",
    }  # fmt: skip
    if asked.current and asked.csv is None and asked.analysis == "tran":
        raise ParameterError("--current: into which file, must come with --csv FILE")
    for name, analyses in TAKEN_BY.items():
        given = others[name] if name in others else getattr(asked, name) not in {None, ()}
        if given and asked.analysis not in analyses:
            option = option_of(_NAMES.get(name, name))
            raise ParameterError(f"{option}: not of --analysis {asked.analysis}; leave it out")
