"""Tables whose cells come from the code: texts, in which what stands in backticks is code, or nodes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from docutils import nodes

CODE = re.compile(r"`+([^`]+)`+")

Cell = str | nodes.Node


def table(head: Sequence[str], rows: Iterable[Sequence[Cell]], ids: Iterable[str] = ()) -> nodes.table:
    """A table; ids: anchors of its rows, in order."""
    body = [_row(cells) for cells in rows]
    for row, anchor in zip(body, ids, strict=False):
        row["ids"].append(anchor)
    group = nodes.tgroup("", cols=len(head))
    group += [nodes.colspec(colwidth=1) for _ in head]
    group += nodes.thead("", _row(head))
    group += nodes.tbody("", *body)
    return nodes.table("", group, classes=["colwidths-auto"])


def text(words: str) -> list[nodes.Node]:
    """A text with its code marked."""
    parts = CODE.split(words)
    return [nodes.literal(p, p) if k % 2 else nodes.Text(p) for k, p in enumerate(parts) if p]


def paragraph(words: str) -> nodes.paragraph:
    """A paragraph of such a text."""
    return nodes.paragraph("", "", *text(words))


def _row(cells: Sequence[Cell]) -> nodes.row:
    """A row, or the head."""
    return nodes.row("", *(nodes.entry("", _inside(cell)) for cell in cells))


def _inside(cell: Cell) -> nodes.Node:
    return paragraph(cell) if isinstance(cell, str) else cell
