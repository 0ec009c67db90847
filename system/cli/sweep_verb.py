"""The verb `noctule sweep`, with its options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from system.cli import shared_options as shared
from system.cli.shared_options import BlockValues, Engine, OnBlock
from system.option import option
from system.options.begin import BeginChoice
from system.options.silicon import SiliconChoice


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep(OnBlock):
    """Sweep sources, biases, sizes, temperature, corners or dies. Operating points, or a transient each."""

    over: tuple[str, ...] = option(
        (), "As v_in=0V..5V:101 or i_tau=1pA..1uA:61log; the first is the innermost; repeatable",
        metavar="NAME=VALUES",
    )  # fmt: skip
    analysis: Literal["dc", "tran"] = option("dc", "Operating points, or a transient at every point")
    measure: tuple[str, ...] = shared.measure_option()
    way: Literal["up", "down", "both"] = option(
        "up", "Innermost values as given, from the last to the first, or there and back"
    )
    node: tuple[str, ...] = option((), "Node to print and draw, repeatable", metavar="PATH")
    current: tuple[str, ...] = option(
        (), "Device or source whose current to print and draw, repeatable", metavar="NAME"
    )
    start: tuple[str, ...] = option((), "Voltage to start from, repeatable", metavar="NODE=V")
    stimulus: tuple[str, ...] = shared.stimulus_option()
    values: BlockValues = shared.values_part("bias_file")
    silicon: SiliconChoice = shared.silicon_part()
    begin: BeginChoice = shared.begin_part()
    engine: Engine = option("native", "What solves it")
    deadline: str | None = shared.deadline_option()
    plot: str | None = shared.plot_option()
    csv: str | None = shared.file_option("Write a row a point")
    netcdf: str | None = shared.file_option("Write everything as a netCDF file")
    as_json: bool = shared.json_option()
