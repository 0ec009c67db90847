"""Pages escape every text and hold their pictures."""

import base64
import re

from matplotlib.figure import Figure

from system.study.report.page import add, add_picture, add_table, code, page, write


def test_texts_are_never_markup() -> None:
    root, body = page("a < b & c")
    add(body, "p", "<script>")
    add_table(body, ("name", "n:"), [("<i>", 3), ("x", code("a && b"))])
    text = write(root)
    assert text.startswith("<!DOCTYPE html>\n<html")
    assert "<title>a &lt; b &amp; c</title>" in text
    assert "<p>&lt;script&gt;</p>" in text
    assert '<td>&lt;i&gt;</td><td class="number">3</td>' in text
    assert '<td class="number"><code>a &amp;&amp; b</code></td>' in text


def test_a_picture_is_in_the_page_and_always_the_same() -> None:
    def draw(figure: Figure) -> None:
        figure.subplots().plot([0, 1])

    root, body = page("a")
    add_picture(body, draw, "a line")
    add_picture(body, draw, "a line")
    first, second = re.findall(r'alt="a line" src="data:image/png;base64,([^"]+)"', write(root))
    assert first == second
    assert base64.b64decode(first).startswith(b"\x89PNG")
