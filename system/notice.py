"""What a command says beside its output: one line each on stderr, and warnings the same way."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO


def say(text: str) -> None:
    """Write one line on stderr, under the command's name."""
    sys.stderr.write(f"noctule: {' '.join(text.split())}\n")


@contextmanager
def warnings_in_a_line() -> Iterator[None]:
    """Inside, a warning is one line without the source that raised it."""
    with warnings.catch_warnings():
        warn_in_a_line()
        yield


def warn_in_a_line() -> None:
    """From now on a warning of this process is one line without the source that raised it."""
    warnings.showwarning = _show


def _show(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    say(f"warning: {message}")
