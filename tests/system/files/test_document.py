"""Documents have the type that is asked for, or one line says where and why not."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import DataError, ParameterError
from system.files import document
from system.files.document import document_bytes, from_json, from_toml

REMEDY = "name another"


@dataclass(frozen=True, slots=True)
class Part:
    name: str
    count: Annotated[int, msgspec.Meta(ge=1)]

    def __post_init__(self) -> None:
        if self.name == "gnd":
            raise ParameterError("name: gnd, is the ground")


class Whole(msgspec.Struct, forbid_unknown_fields=True):
    parts: tuple[Part, ...] = ()
    share: float = 0.0


def read(data: bytes | str) -> Whole:
    return from_json(data, Whole, "x.json", REMEDY)


def test_a_document_becomes_its_type_in_both_languages() -> None:
    expected = Whole((Part("a", 2),), 0.5)
    assert read('{"parts": [{"name": "a", "count": 2}], "share": 0.5}') == expected
    text = 'share = 0.5\n[[parts]]\nname = "a"\ncount = 2\n'
    assert from_toml(text, Whole, "x.toml", REMEDY) == expected


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"", "x.json: Input data was truncated; name another"),
        (b"\xff", "x.json: JSON is malformed: invalid character (byte 0); name another"),
        (b'{"parts": [{"name": "a\xff", "count": 2}]}', "x.json: 'utf-8' codec"),
        (b'{"parts": [{"name": "\\ud800", "count": 2}]}', "x.json: "),
        (b"[" * 50_000, "x.json: Expected object, got array; name another"),
        (b'{"parts": ' * 50_000, "x.json: parts: Expected array, got object; name another"),
        (b'{"share": 1e999}', "x.json: share: Number out of range; name another"),
        (b'{"share": ' + b"9" * 10_000 + b"}", "x.json: share: Number out of range; name another"),
        (b'{"share": NaN}', "x.json: JSON is malformed"),
        (b'{"share": true}', "x.json: share: Expected float, got bool; name another"),
        (b'{"parts": [{"name": "a", "count": 0}]}', "x.json: parts[0].count: Expected int >= 1; "),
        (b'{"parts": [{"name": "gnd", "count": 1}]}', "x.json: parts[0]: name: gnd, is the ground; "),
        (b'{"colour": 1}', "x.json: Object contains unknown field colour; name another"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_in_one_line_with_its_place(data: bytes, told: str) -> None:
    with pytest.raises(DataError) as raised:
        read(data)
    assert str(raised.value).startswith(told)
    assert str(raised.value).endswith(REMEDY)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("kind", [dict, list, object])
def test_brackets_without_end_are_told_whatever_is_asked_for(kind: Any) -> None:
    for data in (b"[" * 50_000, b'{"a":' * 50_000):
        with pytest.raises(DataError, match=r"nested too deeply|Expected"):
            from_json(data, kind, "x.json", REMEDY)
    with pytest.raises(DataError, match="nested too deeply"):
        from_toml("a = " + "[" * 50_000, dict, "x.toml", REMEDY)


@given(st.binary(max_size=40))
def test_no_bytes_raise_anything_else(data: bytes) -> None:
    for read_it in (from_json, from_toml):
        with suppress(DataError):
            assert isinstance(read_it(data, Whole, "x", REMEDY), Whole)


def test_a_file_that_cannot_be_read_or_is_too_long_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(DataError, match="cannot be read, Is a directory; name another"):
        document_bytes(tmp_path, REMEDY)
    with pytest.raises(FileNotFoundError):
        document_bytes(tmp_path / "none.json", REMEDY)
    (tmp_path / "long.json").write_bytes(b"[1, 2]")
    assert document_bytes(tmp_path / "long.json", REMEDY) == b"[1, 2]"
    monkeypatch.setattr(document, "LARGEST", 5)
    with pytest.raises(DataError, match="longer than"):
        document_bytes(tmp_path / "long.json", REMEDY)
