"""Tables of what keys mean, and documents that are held against them."""

from __future__ import annotations

from typing import Literal

import pytest

from system.meaning import Meaning, kind_of, meanings, of_run
from tests.json_document import is_of, wrong

TABLE = """
time_s   number[]     s  when each
                         came
trips    object[]     -  each trip
trips.*  number?      -  a number of it
by_name  object{}     -  parts
by_name.*.share  number|string  -  how much
"""


def test_a_table_is_read() -> None:
    found = meanings(TABLE)
    assert found["time_s"] == Meaning("number[]", "s", "when each came")
    assert found["trips.*"] == Meaning("number?", "", "a number of it")
    assert set(meanings(TABLE, "run")) == {f"run.{key}" for key in found}
    assert set(of_run(found, {})) == {f"summary.{key}" for key in found}


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("time_s  number  s", "must be a key, a type, a unit and words"),
        ("time_s  float  s  when", "type float, must be of any, boolean"),
        ("time_s  number  s  when\ntime_s  number  s  when", "time_s: told twice"),
    ],
)
def test_a_table_that_is_none_is_refused(table: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        meanings(table)


def test_types_of_fields_are_those_of_json() -> None:
    assert kind_of(float, nullable=True) == "number?"
    assert kind_of(tuple[float, float], nullable=False) == "number[]"
    assert kind_of(tuple[tuple[int, int], ...], nullable=False) == "integer[][]"
    assert kind_of(Literal["a", "b"], nullable=False) == "string"
    assert kind_of(Meaning, nullable=True) == "string?"  # a thing of its own is in words
    assert kind_of(object, nullable=False) == "any"


def test_what_is_untold_or_of_another_type_is_found() -> None:
    told = meanings(TABLE)
    right = {
        "time_s": [1, 2.5],
        "trips": [{"cost": 1.0, "error": None}],
        "by_name": {"a.b": {"share": "all"}},
    }
    assert wrong(right, told) == []
    assert wrong({**right, "more": 1}, told) == ["more: untold"]
    assert wrong({"by_name": {"a": {"shares": 1}}}, told) == ["by_name.*.shares: untold"]
    assert wrong({"time_s": [1.0, None]}, told) == ["time_s: [1.0, None], must be number[]"]
    assert wrong({"trips": [{"cost": True}]}, told) == ["trips.*: True, must be number?"]


@pytest.mark.parametrize(
    ("value", "kind", "right"),
    [
        (1, "integer", True), (1.5, "integer", False), (True, "integer", False), (True, "boolean", True),
        (None, "number?", True), (None, "number", False), ([None, 1], "number?[]", True),
        ([[1], [2]], "integer[][]", True), ({"a": [1]}, "integer[]{}", True), ("a", "number|string", True),
        ([], "any", True),
    ],
)  # fmt: skip
def test_values_are_of_types(value: object, kind: str, right: bool) -> None:
    assert is_of(value, kind) is right
