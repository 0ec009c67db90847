"""Programs of ROLLS: of `noctule map`, of a CSV with a row for each synapse, or the Pushbot's by its name.

    post,pre,level
    5,17,4
    5,40,-2

The header may be missing; blank lines are skipped. Synapses that no row names are off. A row
`depression,7,27` turns short-term depression on, with the coarse and fine code of its recovery; its step is
NPA_WEIGHT_STD_N of the bias file.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from chips.rolls.depression.program import ShortTermDepression
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.network import network_program
from chips.rolls.program.program import HIGHEST_LEVEL, Program
from circuits.errors import DataError, ParameterError, meant
from system.mapping.network_file import SUFFIX
from system.mapping.program_file import read_program_file
from system.pushbot.network.plain import pushbot_network

PUSHBOT = "pushbot"
COLUMNS = ("post", "pre", "level")
DEPRESSION = "depression"


def read_program(text: str, biases: BiasTable) -> Program:
    """Read the program that the option `--program` names, a file or `pushbot`.

    biases: bias table of the chip; a program of `noctule map` has its own. Raises `DataError` with the line
    for a file that is no program, and
    `ParameterError` for a level that the biases do not have.
    """
    if text.endswith(SUFFIX):
        return read_program_file(text).program
    if text == PUSHBOT:
        return network_program(pushbot_network(), biases)
    path = Path(text)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "no UTF-8 text"
        rule = f"must be a CSV of post,pre,level, or {PUSHBOT}{meant(text, (PUSHBOT,))}"
        raise DataError(f"{path}: {reason}, {rule}") from error
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    given = np.zeros((NEURONS, NEURONS), dtype=np.bool_)
    depression: ShortTermDepression | None = None
    for number, cells in enumerate(_rows(lines, path), start=1):
        fields = [cell.strip() for cell in cells]
        if not any(fields) or (number == 1 and tuple(fields) == COLUMNS):
            continue
        if fields[0] == DEPRESSION:
            depression = _depression(fields, f"{path}, line {number}", depression)
            continue
        post, pre, level = _row(fields, f"{path}, line {number}")
        if given[post, pre]:
            raise DataError(f"{path}, line {number}: {pre} to {post} stands twice, must once; remove one row")
        levels[post, pre], given[post, pre] = level, True
    if not given.any():
        raise DataError(f"{path}: no synapse, must have rows as 5,17,4; write one a synapse")
    return Program(levels, biases, depression=depression)


def _depression(fields: list[str], where: str, before: ShortTermDepression | None) -> ShortTermDepression:
    if before is not None:
        raise DataError(f"{where}: {DEPRESSION} stands twice, must once; remove one row")
    try:
        _, coarse, fine = fields
        return ShortTermDepression((int(coarse), int(fine)))
    except ValueError as error:
        reason = f"; {error}" if isinstance(error, ParameterError) else ""
        text = ",".join(fields)[:40]
        raise DataError(f'{where}: "{text}", must be {DEPRESSION},coarse,fine as in 7,27{reason}') from None


def _rows(lines: Iterable[str], path: Path) -> Iterator[list[str]]:
    """Cells of each line of a CSV file."""
    try:
        yield from csv.reader(lines)
    except csv.Error as error:
        raise DataError(f"{path}: {error}, must be a CSV of post,pre,level, or {PUSHBOT}") from None


def _row(fields: list[str], where: str) -> tuple[int, int, int]:
    text = ",".join(fields)[:40]
    try:
        post, pre, level = (int(field) for field in fields)
    except ValueError:
        raise DataError(
            f'{where}: "{text}", must be post,pre,level as in 5,17,4; write whole numbers'
        ) from None
    for name, value in (("post", post), ("pre", pre)):
        if not 0 <= value < NEURONS:
            raise DataError(f"{where}: {name} {value}, must be 0 to {NEURONS - 1}; the chip has {NEURONS}")
    if not -HIGHEST_LEVEL <= level <= HIGHEST_LEVEL:
        raise DataError(f"{where}: level {level}, must be -{HIGHEST_LEVEL} to {HIGHEST_LEVEL}; 0 is off")
    return post, pre, level
