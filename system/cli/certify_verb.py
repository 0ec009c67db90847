"""The verb `noctule certify PROGRAM --task TASK`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from system.cli import shared_options as shared
from system.cli.verb import argument, required
from system.option import option
from system.options.silicon import USUAL_CELSIUS

NO_CHANGE = "none"  # in the place of changes


@dataclass(frozen=True, slots=True, kw_only=True)
class Certify:
    """Tell on what share of dies a mapped network does its task."""

    program: str = argument("PROGRAM", "A network on its chip, as noctule map wrote it")
    task: str = required("FILE.npz, an environment of Gymnasium, or FILE.py:NAME", metavar="TASK")
    samples: int = option(0, "Samples, or episodes, of a run; all, or 10, for 0")
    reach: str = option("", "Of each number that an environment shows, as 1,1.5,0.2,2", metavar="NUMBERS")
    bits: str = option("", "Of weights, tried without silicon, as 2,3,4,6", metavar="NUMBERS")
    dies: int = option(20, "Number of dies", short="n")
    first_die: int = option(1000, "Number of the first die")
    trials: int = option(1, "Runs of each die, with noise of their own")
    lot: str = option("A", "Lot of dies")
    variation: Literal["plain", "transistors", "full"] = option(
        "plain", "Lot, wafer, gradients and n with p beside; full: capacitors and resistors too"
    )
    temperature: tuple[str, ...] = option((USUAL_CELSIUS,), "Degrees Celsius, repeatable", metavar="DEGC")
    bias_kind: Literal["ideal", "generator"] = option("generator", "Of the chip's biases")
    change: tuple[str, ...] = option(
        (), "Tried on the same dies, repeatable; none, or the chip's usual ones unless given", metavar="TEXT"
    )
    output: str | None = option(None, "Keep runs and the page there", short="o", metavar="FOLDER")
    resume: bool = option(default=False, about="Go on with what is in --output")
    threads: int | None = shared.threads_option()
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()
