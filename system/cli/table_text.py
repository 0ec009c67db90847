"""Lines of a table that no terminal limits, letter by letter as rich lays them out, without it.

A table wider than `WIDTH` has its widest columns narrowed to the next widest until it fits, and their cells
folded between words; a word longer than its column is cut. What rich may lay out otherwise is left to it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest

WIDTH = 160  # columns
_SIDE = 1  # columns that are free on a side of a column where another stands
_NARROW = frozenset(map(chr, range(32, 127))) | set("×±·°µ²→")  # letters that take one column
_WORD = re.compile(r"\s*\S+\s*")  # with the spaces behind it
_LEAST = 8  # columns of one that is narrowed; ours: below, spaces between columns shrink too


def table_lines(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str] | None:
    """Lines of a table; columns whose heading ends with `:` stand to the right.

    None for one with letters that may be wide, with spaces around a cell, which rich may drop, and for one of
    too many columns.
    """
    whole = [[column.removesuffix(":") for column in columns], *rows]
    widths = [max(map(len, cells)) for cells in zip_longest(*whole, fillvalue="")]
    plain = all(cell == cell.strip() and set(cell) <= _NARROW for row in whole for cell in row)
    if not plain or len(widths) != len(columns):
        return None
    given = [(*row, *[""] * (len(columns) - len(row))) for row in whole]
    last = len(widths) - 1
    gaps = [_SIDE * ((k > 0) + (k < last)) for k in range(last + 1)]
    narrowed = _narrowed([width + gap for width, gap in zip(widths, gaps, strict=True)])
    if narrowed is None:
        return None
    widths = [width - gap for width, gap in zip(narrowed, gaps, strict=True)]
    signs = [">" if column.endswith(":") else "<" for column in columns]
    shapes = [f"{{:{sign}{width}}}" for sign, width in zip(signs, widths, strict=True)]
    layout = (" " * 2 * _SIDE).join(shapes).format
    return [layout(*line) for row in given for line in _lines_of(row, widths)]


def _narrowed(widths: list[int]) -> list[int] | None:
    """Widths of columns, with what is free at their sides, that fit; None where all would have to shrink."""
    if sum(widths) <= WIDTH:
        return widths
    found = [min(width, WIDTH) for width in widths]
    while (excess := sum(found) - WIDTH) > 0:
        most = max(found)
        step = most - max((width for width in found if width != most), default=0)
        left, count = excess, found.count(most)
        for k in (k for k, width in enumerate(found) if width == most):
            taken = min(excess, step, round(left / count))
            found[k], left, count = most - taken, left - taken, count - 1
    changed = (new for new, width in zip(found, widths, strict=True) if new < width)
    return found if min(changed) >= _LEAST else None


def _lines_of(row: Sequence[str], widths: Sequence[int]) -> Iterator[Sequence[str]]:
    """Cells of a row, line by line."""
    if all(len(cell) <= width for cell, width in zip(row, widths, strict=True)):
        return iter((row,))
    folded = (_folded(cell, width) for cell, width in zip(row, widths, strict=True))
    return zip_longest(*folded, fillvalue="")


def _folded(cell: str, width: int) -> list[str]:
    """A cell in lines of at most so many letters, broken before words; a longer word is cut."""
    starts, used = [0], 0
    for word in _WORD.finditer(cell):
        if used and len(word[0].rstrip()) > width - used:
            starts.append(word.start())
            used = 0
        used += len(word[0])
    lines = (cell[a:b].rstrip() for a, b in zip_longest(starts, starts[1:]))
    return [line if len(line) <= width else line[: width - 1] + "…" for line in lines]
