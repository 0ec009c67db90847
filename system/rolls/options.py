"""What the command line asks for on ROLLS: its file of biases, and options that only blocks have."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from chips.rolls.circuit import chip
from chips.rolls.program.bias_file import SHIPPED, BiasTable, read_biases, shipped_biases
from chips.rolls.validity import check_supply
from circuits.bias import rebias
from circuits.errors import DataError, ParameterError, meant
from circuits.silicon.process import ROLLS_180
from circuits.silicon.process_file import process_under
from circuits.silicon.silicon import Silicon
from circuits.units import parse_quantity
from system.options.block import ROLLS, read_die
from system.options.die.edited import check_edits
from system.options.silicon import SiliconChoice

NAME = ROLLS


def bias_table(text: str | None) -> BiasTable:
    """A shipped table by its name, else a file; the control software's unless given. Raises `DataError`."""
    if text is None or text in SHIPPED:
        return shipped_biases(text or SHIPPED[0])
    try:
        return read_biases(Path(text))
    except DataError as error:
        raise DataError(f"{error}{meant(text, SHIPPED)}") from error


def silicon_of(choice: SiliconChoice) -> Silicon:
    """Silicon of a whole chip.

    Raises `ParameterError` for a place on another one, a bad temperature, and a process of another supply.
    """
    if choice.at is not None:
        raise ParameterError(f"at: {choice.at}, the chip stands by itself; leave it out")
    celsius = parse_quantity(choice.celsius, "degC", "temperature")
    process = process_under(ROLLS_180, choice.process, choice.law)
    check_supply(process)
    silicon = Silicon(process, celsius, read_die(choice))
    check_edits(silicon.die, [(rebias(chip(), kind="generator"), silicon)] if silicon.die.edits else [])
    return silicon


def refuse_block_options(params: Collection[str], biases: Collection[str], bias_set: str | None) -> None:
    """Raise `ParameterError` for options of blocks: the chip's biases are codes."""
    for option, given in (
        ("param", bool(params)),
        ("bias", bool(biases)),
        ("bias_set", bool(bias_set)),
    ):
        if given:
            raise ParameterError(f"{option}: rolls has its biases by code; give `bias_file=FILE`")
