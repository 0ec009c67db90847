"""The verbs on a metric's gradient over dies: `match`, `size`, `worst` and `corners`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from system.cli import shared_options as shared
from system.cli.shared_options import BlockValues, ManyDies, OnBlock
from system.cli.verb import like, part, required
from system.option import option
from system.options.silicon import SiliconChoice


@dataclass(frozen=True, slots=True, kw_only=True)
class OverDies(ManyDies):
    """A block whose metrics are measured over dies: options that its verbs share."""

    OWN: ClassVar[str] = "temperature"
    measure: tuple[str, ...] = shared.measure_option()
    variation: SiliconChoice = shared.silicon_part("temperature", "die", "study", "corner")
    temperature: str | None = like(SiliconChoice, "temperature")
    values: BlockValues = shared.values_part("bias_file", "coupling", "testbench")
    stimulus: tuple[str, ...] = shared.stimulus_option()
    threads: int | None = shared.threads_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Match(OnBlock):
    """Show what spreads a metric, and what area helps. By one gradient; sampling checks it."""

    metric: str = required("What is matched, as t_inh_s", metavar="NAME")
    spread: str | None = option(
        None, "Wanted standard deviation over dies, as 5% of the metric or in its unit", metavar="SHARE"
    )
    least: str = option("10%", "No device gets less of its own area than this", metavar="SHARE")
    check: int = option(0, "Dies of the check by sampling; none unless given", metavar="DIES")
    seed: int = option(0, "Of that check's draws")
    over: OverDies = part(OverDies)
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Size(OnBlock):
    """Find the least area for a yield; judge on fresh dies."""

    spec: tuple[str, ...] = option((), 'As "offset_V in -5mV:5mV", repeatable', metavar="TEXT")
    move_param: tuple[str, ...] = option(
        (), "A size that moves; every length and width unless given; repeatable", metavar="NAME"
    )
    wanted: str = option("99%", "Share of dies that should pass", name="yield", metavar="SHARE")
    reach: float = option(3.0, "How far sizes move, each way", name="range", metavar="FACTOR")
    tuning_dies: int = option(200, "Dies of the search, from 0 on, at most 1000")
    fresh_dies: int = option(1000, "Dies of the report")
    first_fresh_die: int = option(1000, "The first of them, 1000 or later")
    output: str | None = shared.file_option("Write the result as JSON", short="o")
    over: OverDies = part(OverDies)
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Worst(OnBlock):
    """Find the most probable failing die of each specification. It tells the yield without sampling."""

    spec: tuple[str, ...] = option((), 'As "t_inh_s in 5ms:8ms", repeatable', metavar="TEXT")
    check: int = option(0, "Dies drawn about the worst points to check the yield", metavar="DIES")
    seed: int = option(0, "Of that check's draws")
    output: str | None = option(None, "Write the failing dies there, for --die", short="o", metavar="FOLDER")
    over: OverDies = part(OverDies)
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Corners(OnBlock):
    """Find the dies at k sigma of a metric, low and high. They take the place of ss and ff."""

    metric: tuple[str, ...] = option((), "Of the testbench, as t_inh_s, repeatable", metavar="NAME")
    sigma: float = option(3.0, "Distance of the dies", metavar="K")
    output: str | None = option(None, "Write the dies there, for --die", short="o", metavar="FOLDER")
    over: OverDies = part(OverDies)
    as_json: bool = shared.json_option()
