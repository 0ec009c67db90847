"""The command `noctule run bench`, with its options."""

from __future__ import annotations

from dataclasses import dataclass

from system.cli import shared_options as shared
from system.cli.verb import argument
from system.option import option
from system.options.silicon import SiliconChoice

NAME = "bench"
LINE = "the teaching chip's bench: a sweep or a record from a script, read as its board reads"


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """Measure the teaching chip on its bench: a sweep or a record that a script in TOML says."""

    script: str = argument("SCRIPT.toml", "Circuit, biases, voltages, and what is swept or recorded")
    silicon: SiliconChoice = shared.silicon_part("at", "allow_implausible")
    seed: int = option(0, "Of what differs from one reading to the next")
    plot: str | None = shared.plot_option()
    csv: str | None = shared.file_option("Write a row a point or sample")
    as_json: bool = shared.json_option()
