"""Output of all commands: JSON documents, tables for a reader, and progress on stderr."""

from __future__ import annotations

import contextlib
import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from circuits.units import format_quantity

_PIPED_WIDTH = 160  # columns of a table that no terminal limits


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


def print_line(text: str) -> None:
    """Print a line in its full width, whatever the width of the terminal."""
    sys.stdout.write(f"{text}\n")


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table with a title; columns whose heading ends with `:` stand to the right."""
    table = Table(box=None, pad_edge=False)
    for column in columns:
        table.add_column(column.removesuffix(":"), justify="right" if column.endswith(":") else "left")
    for row in rows:
        table.add_row(*(Text("" if cell is None else str(cell)) for cell in row))
    console = Console()
    if not console.is_terminal:
        console = Console(width=_PIPED_WIDTH)
    console.print(Text(title, style="bold"))
    console.print(table)
    console.print()


def quantity_cell(value: Any, unit: str) -> str:
    """Write a quantity in SI units as the cell of a table, as `199.9pA`.

    An array is written as its first and last element, and None as `off`.
    """
    if value is None:
        return "off"
    if isinstance(value, np.ndarray | tuple | list):
        values = [quantity_cell(float(v), unit) for v in np.ravel(value)]
        return values[0] if len(set(values)) == 1 else f"{values[0]} .. {values[-1]}"
    return format_quantity(float(value), unit)


@contextlib.contextmanager
def working(text: str) -> Iterator[None]:
    """Show `text` with a spinner on stderr during a `with` statement, if stderr is a terminal."""
    console = Console(stderr=True)
    with console.status(text) if console.is_terminal else contextlib.nullcontext():
        yield


@contextlib.contextmanager
def progress_bar(text: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr during a `with` statement, if stderr is a terminal.

    The statement gets a function that takes the fraction done, from 0 to 1.
    """
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:
        task = bars.add_task(text, total=1.0)
        yield lambda fraction: bars.update(task, completed=fraction)
