"""Elements of a self-contained HTML page: headings, tables, pictures held as data, and the page itself.

Elements are made by ElementTree, which escapes every text, so that a name from a user is never markup.
"""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

from matplotlib.figure import Figure

from system.plot import save_picture

_STYLE = """
body { margin: 2rem auto; max-width: 60rem; padding: 0 1.5rem; background: #fff; color: #333;
  font: 15px/1.5 system-ui, "DejaVu Sans", Arial, sans-serif; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 0.4rem; border-bottom: 1px solid #ccc; }
h3 { font-size: 1rem; margin: 1.4rem 0 0.3rem; }
p { margin: 0.4rem 0; }
table { border-collapse: collapse; margin: 0.5rem 0 1rem; font-size: 0.88rem; }
th, td { padding: 0.2rem 0.8rem 0.2rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid #eee; }
th { font-weight: 600; border-bottom: 1px solid #bbb; }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
code { font: 0.85rem "DejaVu Sans Mono", Consolas, monospace; overflow-wrap: anywhere; }
td:last-child:not(:nth-child(2)) code { white-space: nowrap; }
.wide { overflow-x: auto; }
img { max-width: 100%; height: auto; display: block; }
"""


def page(title: str) -> tuple[Element, Element]:
    """Begin an empty page with a title, and give its root element and its body."""
    root = Element("html", lang="en")
    head = SubElement(root, "head")
    SubElement(head, "meta", charset="utf-8")
    SubElement(head, "meta", name="viewport", content="width=device-width, initial-scale=1")
    add(head, "title", title)
    add(head, "style", _STYLE)
    return root, SubElement(root, "body")


def write(root: Element) -> str:
    """Give the page with this root element as HTML text."""
    return f"<!DOCTYPE html>\n{tostring(root, encoding='unicode', method='html')}\n"


def add(parent: Element, tag: str, text: str = "", /, **attributes: str) -> Element:
    """Append an element with a tag, a text and attributes to `parent`, and give the new element."""
    element = SubElement(parent, tag, attributes)
    element.text = text
    return element


def add_table(parent: Element, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Append a table with a line of headings and a line for each of the rows.

    Columns whose heading ends with `:` hold numbers and stand to the right, as in `system.cli.output`. A cell
    that is an `Element` is taken as it is; any other is written as text.
    """
    table = SubElement(SubElement(parent, "div", {"class": "wide"}), "table")
    kinds = [{"class": "number"} if head.endswith(":") else {} for head in heads]
    line = SubElement(SubElement(table, "thead"), "tr")
    for head, kind in zip(heads, kinds, strict=True):
        SubElement(line, "th", kind).text = head.removesuffix(":")
    body = SubElement(table, "tbody")
    for row in rows:
        line = SubElement(body, "tr")
        for cell, kind in zip(row, kinds, strict=True):
            place = SubElement(line, "td", kind)
            if isinstance(cell, Element):
                place.append(cell)
            else:
                place.text = str(cell)


def code(text: str) -> Element:
    """Give an element that shows a text as code, such as a command."""
    element = Element("code")
    element.text = text
    return element


def add_picture(parent: Element, draw: Callable[[Figure], None], alt: str) -> None:
    """Append a picture that `draw` fills, held in the page itself, with the alternative text `alt`.

    It is kept as pixels, so that its size does not grow with the number of samples.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        save_picture(str(path), draw)
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    SubElement(parent, "img", {"alt": alt, "src": f"data:image/png;base64,{data}"})
