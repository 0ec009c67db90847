"""Numbers with SPICE's suffixes."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from netlists.read.number import read_number


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1.0),
        ("-1.5", -1.5),
        (".5", 0.5),
        ("1.", 1.0),
        ("1k", 1e3),
        ("1M", 1e-3),
        ("1MEG", 1e6),
        ("10megohm", 10e6),
        ("600fF", 600e-15),
        ("1F", 1e-15),
        ("2.5e-3", 2.5e-3),
        ("1e3k", 1e6),
        ("1mil", 25.4e-6),
        ("5V", 5.0),
        ("12ms", 12e-3),
        ("3G", 3e9),
        ("1T", 1e12),
        ("1a", 1e-18),
        ("0.1u", 1e-7),
    ],
)
def test_a_suffix_means_what_spice_says(text: str, value: float) -> None:
    assert read_number(text) == value


@pytest.mark.parametrize("text", ["", "x", "1+1", "1 k", "--1", "e3", ".", "1u*2", "0x10", "1_000"])
def test_anything_else_is_no_number(text: str) -> None:
    assert read_number(text) is None


def test_a_long_text_is_read_once() -> None:
    digits = "1" * 200_000
    assert read_number(digits + "_") is None
    assert read_number(digits) == math.inf


def test_no_float_is_large_enough() -> None:
    assert read_number("1e999") == math.inf


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_float_comes_back(value: float) -> None:
    assert read_number(repr(value)) == value
