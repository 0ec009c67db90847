"""The verb `noctule map`, and the command `noctule run PROGRAM.toml`, with their options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from system.cli import shared_options as shared
from system.cli.verb import argument, required
from system.cli.verbs import OnDie
from system.option import option

CHIPS = "system.mapping.chips:CHIPS"
PROGRAM = ".toml"  # end of a program's name
LINE = "a network on its chip, as noctule map wrote it"


@dataclass(frozen=True, slots=True, kw_only=True)
class Map:
    """Put a network on a chip. What is exact there, approximate or impossible is reported."""

    network: str = argument("NETWORK", "A network's .toml, or a .nir")
    chip: str = required("Chip that it goes on: rolls, or nef", metavar="NAME", names=CHIPS)
    output: str = required("Program to write", short="o", metavar="FILE.toml")
    graph_unit: str | None = option(None, "What 1 is of a .nir's times; 1 s unless given", metavar="TIME")
    graph_event: str | None = option(None, "Area of an event of a .nir, as of one step", metavar="TIME")
    input: str | None = option(
        None, "Events that are usual, at whose currents synapses are as asked for", metavar="FILE"
    )
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class RunProgram(OnDie):
    """Run a mapped network on a die, beside the network that was asked for."""

    input: str = required("Events, .csv, .npz or .aedat4; on nef values, a .csv", metavar="FILE")
    duration: str | None = option(
        None, "Of the run; until a little after the last event unless given", metavar="TIME"
    )
    codes: Literal["calibrated", "default"] = option(
        "calibrated", "Searched on the die, as on a bench, or the program's own"
    )
    bias_kind: Literal["ideal", "generator"] = option("generator", "Ideal PTAT currents, or the generator")
    spikes: str | None = shared.file_option("Write the die's spikes: .csv, .npz, .aedat4, .nwb or .nix")
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()
