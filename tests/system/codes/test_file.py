"""Files of codes: what is written is read again, and what is none is refused in one line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from chips.codes import Codes, Measured, key_of
from circuits.errors import DataError
from circuits.silicon.silicon import Silicon
from system.codes.file import read_codes, write_codes

CODES = Codes(
    "chip", key_of(Silicon(), "generator"), 27.0, {"i_one": ((5, 128),), "i_two": ((5, 64), (4, 1))},
    {"neuron": (3, 7)}, {"lookup": (1.0, 2.0)}, (Measured("time", "s", 1e-3, 2e-3, 1e-3),), 3.5,
    ("time: stays",), "a reason",
)  # fmt: skip


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    write_codes(tmp_path / "codes.toml", CODES)
    assert read_codes(tmp_path / "codes.toml") == CODES
    assert '"5:128"' in (tmp_path / "codes.toml").read_text()


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ('"5:128"', '"9:128"', r"biases.i_one, must be codes as 5:120"),
        ('"5:128"', '"5:256"', r"biases.i_one, must be codes as 5:120"),
        ("calibrated_c = 27.0", 'calibrated_c = "warm"', "calibrated_c"),
        ("[key]", "[kee]", "key"),
        ("[key]", "[key", "TOML|Expected|must be"),
    ],
)
def test_what_is_none_is_refused(tmp_path: Path, before: str, after: str, says: str) -> None:
    path = tmp_path / "codes.toml"
    write_codes(path, CODES)
    path.write_text(path.read_text().replace(before, after))
    with pytest.raises(DataError, match=says):
        read_codes(path)


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such file"):
        read_codes(tmp_path / "none.toml")
    write_codes(tmp_path / "codes.toml", replace(CODES, biases={}))
    assert read_codes(tmp_path / "codes.toml").biases == {}
