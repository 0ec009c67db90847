"""Output of all commands: JSON documents, tables for a reader, and progress on stderr."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from circuits.catalogue import later
from circuits.units import format_quantity
from system.cli.table_text import WIDTH, table_lines

if TYPE_CHECKING:
    from rich import console, progress, table, text
else:  # what is piped is written without
    console, progress, table, text = (later(f"rich.{n}") for n in ("console", "progress", "table", "text"))

_TERMINAL = ("FORCE_COLOR", "TTY_COMPATIBLE")  # variables by which rich takes a file for a terminal


def print_json(document: Mapping[str, Any]) -> None:
    """Print `document` as one JSON document; numbers that are not finite become null."""
    sys.stdout.write(json_text(document))


def json_text(document: Mapping[str, Any]) -> str:
    """Give a document as JSON that people and programs can read.

    Every member has a line of its own, but an array of numbers or words stands on one line.
    """
    return _json(plain(document), "\n") + "\n"


def _json(value: Any, line: str) -> str:
    """`value` as JSON; `line`: a line's end with the indentation of the next."""
    inner = line + "  "
    if value and isinstance(value, dict):
        members = (f"{json.dumps(k)}: {_json(v, inner)}" for k, v in value.items())
        return f"{{{inner}{f',{inner}'.join(members)}{line}}}"
    if _holds_objects(value):
        return f"[{inner}{f',{inner}'.join(_json(v, inner) for v in value)}{line}]"
    return json.dumps(value, allow_nan=False)


def _holds_objects(value: Any) -> bool:
    """Whether an array has objects in it, at any depth."""
    return isinstance(value, list) and any(isinstance(v, dict) or _holds_objects(v) for v in value)


def plain(value: Any) -> Any:
    """Give `value` in the types of JSON: arrays and tuples as lists, NaN and infinities as None."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def print_line(line: str) -> None:
    """Print a line in its full width, whatever the width of the terminal."""
    sys.stdout.write(f"{line}\n")


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table with a title; columns whose heading ends with `:` stand to the right."""
    cells = [["" if cell is None else str(cell) for cell in row] for row in rows]
    lines = None if _is_terminal(sys.stdout) else table_lines(columns, cells)
    if lines is None:
        _print_styled(title, columns, cells)
    else:
        sys.stdout.write("\n".join([title, *lines, "\n"]))


def _is_terminal(file: TextIO) -> bool:
    """Whether a person may read what is written; what asks more closely is slow to import."""
    return file.isatty() or any(name in os.environ for name in _TERMINAL)


def _print_styled(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table as rich does, for a terminal of any width and in any letters."""
    shown = table.Table(box=None, pad_edge=False)
    for column in columns:
        shown.add_column(column.removesuffix(":"), justify="right" if column.endswith(":") else "left")
    for row in rows:
        shown.add_row(*map(text.Text, row))
    to = console.Console()
    if not to.is_terminal:
        to = console.Console(width=WIDTH)
    to.print(text.Text(title, style="bold"))
    to.print(shown)
    to.print()


def quantity_cell(value: Any, unit: str) -> str:
    """Write a quantity in SI units as the cell of a table, as `199.9pA`.

    An array is written as its first and last element, and None as `off`.
    """
    if value is None:
        return "off"
    if isinstance(value, np.ndarray | tuple | list):
        flat = np.ravel(value)
        first, last = (quantity_cell(float(v), unit) for v in (flat[0], flat[-1]))
        same = all(quantity_cell(v, unit) == first for v in set(flat.astype(float).tolist()))
        return first if same else f"{first} .. {last}"
    return format_quantity(float(value), unit)


@contextlib.contextmanager
def working(said: str) -> Iterator[None]:
    """Show `said` with a spinner on stderr during a `with` statement, if stderr is a terminal."""
    with console.Console(stderr=True).status(said) if _is_terminal(sys.stderr) else contextlib.nullcontext():
        yield


@contextlib.contextmanager
def progress_bar(said: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr during a `with` statement, if stderr is a terminal.

    The statement gets a function that takes the fraction done, from 0 to 1.
    """
    if not _is_terminal(sys.stderr):
        yield lambda _: None
        return
    to = console.Console(stderr=True)
    shown = (
        progress.TextColumn("{task.description}"), progress.BarColumn(), progress.TimeRemainingColumn()
    )  # fmt: skip
    with progress.Progress(*shown, console=to, transient=True, disable=not to.is_terminal) as bars:
        task = bars.add_task(said, total=1.0)
        yield lambda fraction: bars.update(task, completed=fraction)
