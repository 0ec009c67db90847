"""Tests of what is refused: a table of what is given and of what the error then says."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

Rows = Sequence[tuple[Any, str]]


def refusals(
    error: type[Exception], call: Callable[[Any], object], rows: Rows, *, start: str = ""
) -> Callable[[Any, str], None]:
    """Make a test, one case a row (what is given, what the error says): `call` of the one raises the other.

    What the error says is a pattern, before which all messages have what `start` matches.
    """

    @pytest.mark.parametrize(("given", "says"), rows)
    def test(given: Any, says: str) -> None:
        with pytest.raises(error, match=f"{start}(?:{says})"):
            call(given)

    return test


def file_refusals(
    error: type[Exception], name: str, read: Callable[[str], object], rows: Rows, *, start: str = ""
) -> Callable[[Any, str, Path], None]:
    """Make the same test of texts that stand in a file of this name, whose path `read` takes.

    The error is one line.
    """

    @pytest.mark.parametrize(("text", "says"), rows)
    def test(text: str, says: str, tmp_path: Path) -> None:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        with pytest.raises(error, match=f"{start}(?:{says})") as caught:
            read(str(path))
        assert "\n" not in str(caught.value)

    return test


def command_refusals(*words: str, rows: Sequence[tuple[str, str]]) -> Callable[..., None]:
    """Make a test of commands that begin alike, one case a row: what follows in a shell; what stderr says.

    Each is refused in one line.
    """

    @pytest.mark.parametrize(("arguments", "says"), rows)
    def test(refused: Callable[..., str], arguments: str, says: str) -> None:
        assert says in refused(*words, *shlex.split(arguments))

    return test
