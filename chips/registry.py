"""Chips by command-line name, loaded on use; users add theirs under the entry point `noctule.chips`.

A chip with a testbench is a `Block` of the whole chip, which every command takes; one that runs as a
behavioural model alone is a `Chip`, which is listed and shown.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from circuits.catalogue import Catalogue

if TYPE_CHECKING:
    from chips.chip import Chip
    from circuits.blocks.block import Block

CHIPS: dict[str, str] = {
    "ranging-chip": "chips.ranging.circuit:CHIP",
    "ranging-chip-biased": "chips.ranging.circuit:BIASED_CHIP",
    "wavefront-chip": "circuits.blocks.wavefront.grid:CHIP",
    "latency-chip": "chips.latency.circuit:CHIP",
    "nef-chip": "chips.nef.circuit:CHIP",
    "rolls": "chips.rolls.circuit:CHIP",
}

_chips: Catalogue[Block | Chip] = Catalogue(
    "chip", CHIPS, "noctule.chips", ("circuits.blocks.block:Block", "chips.chip:Chip")
)

chip_names, load_chip = _chips.names, _chips.load
