"""Chips that have a testbench as one circuit, so that they are tested as blocks are."""

from __future__ import annotations

from chips.registry import CHIPS, load_chip
from circuits.blocks.block import Block


def whole_chip(name: str) -> Block | None:
    """A chip as a block, None for one that runs as a behavioural model alone."""
    found = load_chip(name)
    return found if isinstance(found, Block) else None


WHOLE_CHIPS = {name: block for name in CHIPS if (block := whole_chip(name)) is not None}
