"""Blocks that a verb of the command line asks for, with their sizes, biases, silicon and stimuli."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from circuits.lowering.coupling import coupled
from system.cli.shared_options import BlockValues
from system.options.begin import FREE, BeginChoice
from system.options.block import Choice, choose
from system.options.silicon import SiliconChoice
from system.options.target import driven


def choose_block(
    name: str,
    values: BlockValues,
    silicon: SiliconChoice,
    stimuli: Iterable[str] = (),
    begin: BeginChoice = FREE,
) -> Choice:
    """Give the block or chip that a verb asks for, with its values on silicon.

    It raises the errors of `system.options.block.choose`.

    Parameters
    ----------
    name : name of the block or chip.
    values : sizes, biases and coupling, as texts of the command line.
    silicon : die, temperature and corner that are asked for.
    stimuli : what the testbench applies, as texts `NAME=VALUE`.
    begin : state in which runs begin.
    """
    found = choose(
        target_of(name, values), values.param, values.bias, values.bias_kind, silicon, stimuli,
        values.bias_set, begin,
    )  # fmt: skip
    return replace(found, circuit=coupled(found.circuit, values.coupling))


def target_of(name: str, values: BlockValues) -> str:
    """Give the text of the block or chip that a verb asks for, with the testbench that its options name."""
    return name if values.testbench is None else driven(name, values.testbench)
