"""Blocks that a verb of the command line asks for, with their sizes, biases, silicon and stimuli."""

from __future__ import annotations

from collections.abc import Iterable

from system.cli.shared_options import BlockValues
from system.options.begin import FREE, BeginChoice
from system.options.block import Choice, choose
from system.options.silicon import SiliconChoice


def choose_block(
    name: str,
    values: BlockValues,
    silicon: SiliconChoice,
    stimuli: Iterable[str] = (),
    begin: BeginChoice = FREE,
) -> Choice:
    """Read what verbs on a block or chip have in common; raises as `system.options.block.choose` does."""
    return choose(
        name, values.param, values.bias, values.bias_kind, silicon, stimuli, values.bias_set, begin
    )  # fmt: skip
