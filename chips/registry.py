"""Chips by command-line name, loaded on use; users add theirs under the entry point `noctule.chips`."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from circuits.errors import unknown_name

if TYPE_CHECKING:
    from circuits.blocks.block import Block

CHIPS: dict[str, str] = {
    "ranging-chip": "chips.ranging.circuit:CHIP",
    "ranging-chip-biased": "chips.ranging.circuit:BIASED_CHIP",
    "wavefront-chip": "circuits.blocks.wavefront.grid:CHIP",
    "latency-chip": "chips.latency.circuit:CHIP",
}


def load_chip(name: str) -> Block:
    """Load a chip by name; raises `UnknownNameError`."""
    if name not in CHIPS:
        raise unknown_name("chip", name, CHIPS)
    module, attribute = CHIPS[name].split(":")
    chip: Block = getattr(import_module(module), attribute)
    return chip
