"""Fields as words: defaults left out, text that stays one word, numbers that come back exactly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import DataError
from netlists.write.field_text import format_fields, parse_fields
from tests.refusals import refusals


@dataclass(frozen=True, slots=True)
class Example:
    name: str
    values: tuple[float, ...] = ()
    side: Literal["left", "right"] = "left"
    shape: tuple[int, ...] = ()


@given(st.text(), st.lists(st.floats(allow_nan=False)).map(tuple), st.sampled_from(["left", "right"]))
def test_what_is_written_is_read(
    name: str, values: tuple[float, ...], side: Literal["left", "right"]
) -> None:
    example = Example(name, values, side, (2, 3))
    words = list(format_fields(example))
    assert all(not set(word) & set(" \n\t\r\f\v") for word in words)
    assert parse_fields("it", Example, " ".join(words).split()) == example


def test_defaults_are_left_out_unless_wanted() -> None:
    assert list(format_fields(Example("a"))) == ["name=a"]
    assert list(format_fields(Example("a"), all_fields=True)) == [
        "name=a",
        "values=(",
        ")",
        "side=left",
        "shape=",
    ]


def test_text_is_bare_where_it_can_be() -> None:
    assert list(format_fields(Example("chip/neuron[2].v_r-"))) == ["name=chip/neuron[2].v_r-"]
    assert list(format_fields(Example('a b"é'))) == [r'name="a\u0020b\"\u00e9"']


test_what_is_wrong_is_named = refusals(
    DataError,
    lambda words: parse_fields("it", Example, words.split()),
    [
        ("name=a side=up", "it.side: 'up', no value of its kind"),
        ("name=a values=1.0", "it.values: '1.0', no value"),
        ("name=( a )", r"it.name: '\( a \)', no value"),
        ("name=a shape=1,,2", "it.shape"),
        ("name=1 name=2", "each once"),
        ("side=left", "it.name: missing"),
        ("name=a colour=red", "it.colour: no such field; known are name, values"),
        ('name="unended', "it.name"),
        ('name=a values=( "1" )', "it.values"),
    ],
)
