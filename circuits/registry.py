"""Blocks by command-line name, loaded on use; users add theirs under the entry point `noctule.blocks`."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING

from circuits.errors import unknown_name

if TYPE_CHECKING:
    from circuits.blocks.block import Block

BLOCKS: dict[str, str] = {
    "rebound-neuron": "circuits.blocks.rebound_neuron:BLOCK",
    "centroid-board": "circuits.blocks.centroid_board:BLOCK",
    "vocalization-controller": "circuits.blocks.vocalization_controller:BLOCK",
    "envelope-detector": "circuits.blocks.envelope_detector:BLOCK",
    "onset-neuron": "circuits.blocks.onset_neuron:BLOCK",
    "high-threshold-neuron": "circuits.blocks.high_threshold_neuron:BLOCK",
    "first-target-isolation": "circuits.blocks.first_target_isolation:BLOCK",
}


def block_names() -> list[str]:
    """Names of all blocks, the users' own included, sorted."""
    return sorted({*BLOCKS, *(e.name for e in entry_points(group="noctule.blocks"))})


def load_block(name: str) -> Block:
    """Load a block by name; raises `UnknownNameError` for a name that nobody registered."""
    target = BLOCKS.get(name)
    if target is None:
        for entry in entry_points(group="noctule.blocks"):
            if entry.name == name:
                block: Block = entry.load()
                return block
        raise unknown_name("block", name, block_names())
    module, attribute = target.split(":")
    loaded: Block = getattr(import_module(module), attribute)
    return loaded
