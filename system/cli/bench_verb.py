"""The command `noctule run bench`, with its options."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from system.cli import shared_options as shared
from system.cli.verb import argument, like
from system.option import option
from system.options.silicon import SiliconChoice

NAME = "bench"
LINE = "the teaching chip's bench: a sweep or a record from a script, read as its board reads"


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """Measure the teaching chip on its bench: a sweep or a record that a script in TOML says."""

    script: str = argument("SCRIPT.toml", "Circuit, biases, voltages, and what is swept or recorded")
    variation: SiliconChoice = shared.silicon_part("die", "study", "at", "allow_implausible")
    die: str | None = like(SiliconChoice, "die")
    study: str | None = like(SiliconChoice, "study")
    board: Literal["identified", "nominal"] | None = option(
        None, "Process numbers, codes and converters that an identified die's file has, or nominal ones"
    )
    seed: int = option(0, "Of what differs from one reading to the next")
    plot: str | None = shared.plot_option()
    csv: str | None = shared.file_option("Write a row a point or sample")
    as_json: bool = shared.json_option()

    @property
    def silicon(self) -> SiliconChoice:
        """The silicon that is measured."""
        return shared.of_study(replace(self.variation, die=self.die, study=self.study))
