"""The table of all chips by their names on the command line.

Chips are loaded when they are used; users add theirs under the entry point `noctule.chips`.

A chip with a testbench is a `Block` of the whole chip, which every command takes; one that runs as a
behavioural model alone is a `Chip`, which is listed and shown.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from circuits.catalogue import Catalogue

if TYPE_CHECKING:
    from circuits.blocks.block import Block
    from circuits.circuit import Circuit

CHIPS: dict[str, str] = {
    "ranging-chip": "chips.ranging.circuit:CHIP",
    "ranging-chip-biased": "chips.ranging.circuit:BIASED_CHIP",
    "wavefront-chip": "circuits.blocks.wavefront.grid:CHIP",
    "latency-chip": "chips.latency.circuit:CHIP",
    "nef-chip": "chips.nef.circuit:CHIP",
    "rolls": "chips.rolls.circuit:CHIP",
    "coach": "chips.coach.chip:CHIP",
}

# What each is, as its own summary says: `noctule list` and a shell's completion load none of them.
CHIP_LINES: dict[str, str] = {
    "ranging-chip": "13 rebound neurons with best delays of 2 to 28 ms",
    "ranging-chip-biased": "the ranging chip with its bias chain inside",
    "wavefront-chip": "20 x 20 wavefront cells with axons; simulate a part: rows=2, columns=3",
    "latency-chip": "33 latency memories, delay line, two racing layers; a part: paths=2, taps=2",
    "nef-chip": "8192 neurons whose curves a die sets, encoders, filters, a router of events",
    "rolls": "256 neurons, 256 x 256 synapses of eight levels, and virtual synapses",
    "coach": "teaching chip: transistors, amplifiers, a synapse, neurons, and its bench",
}


@dataclass(frozen=True, slots=True)
class Chip:
    """A chip without a testbench of the whole, as the command line lists and shows it.

    name, summary: its name on the command line, and a line of what it is. circuits: builds the circuits that
    all of its devices stand in. remedy: what to do instead where a testbench was asked for, as the end of an
    error's line.
    """

    name: str
    summary: str
    circuits: Callable[[], tuple[Circuit, ...]]
    remedy: str


_chips: Catalogue[Block | Chip] = Catalogue(
    "chip", CHIPS, "noctule.chips", ("circuits.blocks.block:Block", "chips.registry:Chip"), CHIP_LINES
)

chip_names, load_chip, chip_line = _chips.names, _chips.load, _chips.line
