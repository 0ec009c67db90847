"""Text of a user's file, or one line on why there is none."""

from __future__ import annotations

from pathlib import Path

import pytest

from circuits.errors import DataError, UnknownNameError
from system.files.text import map_path, read_text


def test_text_comes_without_a_mark(tmp_path: Path) -> None:
    path = tmp_path / "map.txt"
    path.write_bytes("\ufeffS #\n".encode())
    assert read_text(path, "a map") == "S #\n"


def test_bytes_that_are_no_text_are_named_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "map.txt"
    path.write_bytes(b"S #\n\xff")
    with pytest.raises(DataError) as caught:
        read_text(path, "a map")
    assert str(caught.value) == f"{path}:2: byte 0xff is not UTF-8, must be a map; save it as text in UTF-8"


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.txt"):
        with pytest.raises(DataError, match=r"must be a readable file; check path and permissions$"):
            read_text(path, "a map")


def test_a_map_is_a_shipped_one_or_a_users_file(tmp_path: Path) -> None:
    own = tmp_path / "yard"
    own.write_text("S G")
    assert map_path("field", ["field"], tmp_path) == tmp_path / "field.txt"
    assert map_path(str(own), ["field"], tmp_path) == own
    assert map_path("none.txt", ["field"], tmp_path) == Path("none.txt")  # told when it is read
    with pytest.raises(UnknownNameError, match=r"^map feld: unknown; did you mean field\?"):
        map_path("feld", ["field"], tmp_path)
