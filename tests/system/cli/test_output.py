"""What commands print: JSON that is short to read, and the same document."""

import io
import json
import math
from contextlib import redirect_stdout

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from system.cli import output
from system.cli.output import json_text, plain, print_table

NAMES = st.text(max_size=3)
LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | NAMES
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=8,
)


@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)  # it may run beside others
@given(st.dictionaries(NAMES, VALUES, max_size=3))
def test_the_text_is_the_document(document: dict[str, object]) -> None:
    assert json.loads(json_text(document)) == plain(document)


def test_arrays_of_numbers_stand_on_one_line() -> None:
    path = np.linspace(0.0, 1.0, 2000).reshape(1000, 2)
    document = {"path": path, "at": (1, math.nan), "runs": [{"times": [0.1, 0.2]}, {}], "none": [], "in": {}}
    assert json_text({k: v for k, v in document.items() if k != "path"}) == (
        '{\n  "at": [1, null],\n  "runs": [\n    {\n      "times": [0.1, 0.2]\n    },\n    {}\n  ],\n'
        '  "none": [],\n  "in": {}\n}\n'
    )
    text = json_text(document)
    assert len(text.splitlines()) == 12
    assert json.loads(text)["path"] == path.tolist()


CELLS = st.none() | st.integers() | st.text("ab :.×±µ-_=", max_size=20) | st.text(max_size=3)
ROWS = st.lists(st.lists(CELLS, min_size=3, max_size=3), max_size=4)


def table_of(columns: tuple[str, ...], rows: list[list[object]]) -> str:
    to = io.StringIO()
    with redirect_stdout(to):
        print_table("a table", columns, rows)
    return to.getvalue()


@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(st.tuples(*[st.sampled_from(("name", "value:", "", "summary of it"))] * 3), ROWS)
@example(("name", "name", "value:"), [[None, None, ": "]])
def test_a_piped_table_is_what_rich_prints(columns: tuple[str, ...], rows: list[list[object]]) -> None:
    assert table_of(columns, rows) == richly(columns, rows)


def richly(columns: tuple[str, ...], rows: list[list[object]]) -> str:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(output, "table_lines", lambda *_: None)
        return table_of(columns, rows)


LONG = st.lists(st.text("ab:.×", min_size=1, max_size=60) | st.just("of its"), max_size=30).map(" ".join)


@settings(suppress_health_check=list(HealthCheck), max_examples=60, deadline=None)
@given(st.data(), st.integers(1, 6))
def test_a_piped_table_that_is_too_wide_is_folded_as_rich_does(data: st.DataObject, count: int) -> None:
    columns = data.draw(st.tuples(*[st.sampled_from(("name", "value:"))] * count))
    rows = data.draw(st.lists(st.lists(LONG, min_size=count, max_size=count), max_size=3))
    assert table_of(columns, rows) == richly(columns, rows)


@pytest.fixture
def without_rich(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(output, "_print_styled", lambda *_: pytest.fail("rich was asked for"))


@pytest.mark.usefixtures("without_rich")
def test_a_plain_table_is_written_without_rich() -> None:
    assert table_of(("name", "value:"), [["v_th", "2.5V"], ["c", None]]) == (
        "a table\nname  value\nv_th   2.5V\nc          \n\n"
    )


@pytest.mark.usefixtures("without_rich")
def test_a_table_that_is_too_wide_is_wrapped() -> None:
    lines = table_of(("name", "summary"), [["a", " ".join(["word"] * 80)]]).splitlines()
    assert len(lines) > 4
    assert max(map(len, lines)) <= 160
