"""Rows of a CSV file are dataclasses: columns in any order, with units and limits of their options."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from circuits.errors import DataError
from system.option import option, required
from system.rows import read_rows


@dataclass(frozen=True, slots=True)
class Post:
    """A row of every kind of column."""

    name: str = required("name of the post")
    height_m: float = required("height above the floor", unit="m", above=0.0, most=3.0)
    lean: float = option(0.0, "share of its height", unit="")


def read(tmp_path: Path, text: str) -> list[tuple[int, Post]]:
    path = tmp_path / "posts.csv"
    path.write_bytes(text.encode())
    return read_rows(path, Post)


def test_columns_come_in_any_order_and_lines_are_counted(tmp_path: Path) -> None:
    found = read(tmp_path, "\ufeffheight_m,name\n2, oak\n\n 1.5,elm\n")
    assert found == [(2, Post("oak", 2.0)), (4, Post("elm", 1.5))]


def test_a_column_with_a_default_may_be_given(tmp_path: Path) -> None:
    assert read(tmp_path, "name,height_m,lean\noak,2,-0.1\n") == [(2, Post("oak", 2.0, -0.1))]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "1: header: 'empty file', must have a header; the first line must be name,height_m[,lean]"),
        ("name,height\n", "1: header: 'height', must be a known column; "),
        ("name,lean\n", "1: header: 'name,lean', must have the column height_m; "),
        ("name,height_m\n", "2: row: 'end of file', must have at least one row of data; add one"),
        ("name,height_m\n,2\n", "2: name: '', must not be blank; "),
        ("name,height_m\noak,tall\n", "2: height_m: 'tall', must be a number; "),
        ("name,height_m\noak,1_0\n", "2: height_m: '1_0', must be a finite number; "),
        (
            "name,height_m\noak,4\n",
            "2: height_m: 4 m, must be > 0 and <= 3; it is the height",
        ),
        ("name,height_m\noak,2\nelm\n", "3: row: '1 cells', must have 2; match the header"),
    ],
)
def test_what_is_refused_names_line_and_column(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(DataError) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'posts.csv'}:{says}")
