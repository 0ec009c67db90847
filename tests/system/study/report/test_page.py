"""Pages escape every text and hold their pictures."""

from __future__ import annotations

import base64
from typing import Any

import pytest
from jinja2 import UndefinedError
from matplotlib.figure import Figure

from system.study.report.page import Code, Grid, picture, render

CONTENT: dict[str, Any] = {"title": "a < b & c", "asked": Grid(("", ""), []), "groups": [], "breakdowns": []}


def test_texts_are_never_markup() -> None:
    table = Grid(("name", "n:"), [("<i>", 3), ("x", Code("a && b"))])
    text = render(CONTENT | {"asked": table, "groups": [{"place": "<script>", "samples": 0}]})
    assert text.lstrip().startswith("<!DOCTYPE html>\n<html")
    assert "<title>a &lt; b &amp; c</title>" in text
    assert "<h2>At &lt;script&gt;</h2>" in text
    assert '<td>&lt;i&gt;</td><td class="number">3</td>' in text
    assert '<td class="number"><code>a &amp;&amp; b</code></td>' in text


def test_a_part_that_is_missing_is_an_error() -> None:
    with pytest.raises(UndefinedError, match="asked"):
        render({name: part for name, part in CONTENT.items() if name != "asked"})


def test_a_picture_is_always_the_same() -> None:
    def draw(figure: Figure) -> None:
        figure.subplots().plot([0, 1])

    first = picture(draw, "a line")
    assert first == picture(draw, "a line")
    assert base64.b64decode(first.data).startswith(b"\x89PNG")
