"""The page of a report: a template filled with plain data, pictures held in the page as data.

The template escapes every text, so that a name from a user is never markup.
"""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from system.plot import save_picture
from system.view.page import tokens

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEMPLATE = "template.html"
FINISHED = {"refresh": 0, "state": ""}  # of a page that says nothing else of that


@dataclass(frozen=True, slots=True)
class Code:
    """A text that a table shows as code, such as a command."""

    text: str


@dataclass(frozen=True, slots=True)
class Link:
    """A text of a table that leads to a file beside the page."""

    text: str
    file: str


@dataclass(frozen=True, slots=True)
class Grid:
    """A table of a page.

    Attributes
    ----------
    heads : headings; a column whose heading ends with `:` holds numbers and stands to the right, as in
        `system.cli.output`.
    rows : cells, a text or a number each, a `Code` or a `Link`.
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[object]]


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of a page: a PNG as base64 text, and what it shows in words, for who cannot see it."""

    data: str
    alt: str


def picture(draw: Callable[[Figure], None], alt: str) -> Picture:
    """Make a picture that `draw` fills, with the alternative text `alt`.

    It is kept as pixels, so that its size does not grow with the number of samples.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        save_picture(str(path), draw)
        return Picture(base64.b64encode(path.read_bytes()).decode("ascii"), alt)


def render(content: Mapping[str, Any], template: str = TEMPLATE) -> str:
    """Give the page of a template with this content as HTML text.

    A missing part raises jinja2's `UndefinedError`.
    """
    environment = Environment(
        loader=PackageLoader("system.study.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["code"] = lambda cell: isinstance(cell, Code)
    environment.tests["link"] = lambda cell: isinstance(cell, Link)
    return environment.get_template(template).render(tokens=tokens(), **{**FINISHED, **content})
