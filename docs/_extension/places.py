"""Folders of the machine that builds the site are left out of what notebooks and commands printed.

A warning names the file that it comes from. On a page that is `system/study/engine.py`, or
`numpy/ma/core.py` of a library, wherever both lie on the machine; a cell of a notebook is called that.
"""

from __future__ import annotations

import re
import sys
import sysconfig
import tempfile

from docutils import nodes
from sphinx.application import Sphinx

from _extension.running import ROOT

CELL = re.compile(r"(?:/[^\s:/]+)*/ipykernel_\d+/\d+\.py")
LIBRARIES = ("purelib", "platlib", "stdlib")
FOLDERS = sorted(  # the longest first, since an environment may lie in the checkout
    {str(ROOT), sys.prefix, sys.base_prefix, tempfile.gettempdir(), *map(sysconfig.get_path, LIBRARIES)},
    key=len,
    reverse=True,
)
_ANY = re.compile(f"(?<![\\w/.])(?:{'|'.join(map(re.escape, FOLDERS))})/")


def without_places(text: str) -> str:
    """A text without the folders in which files lie."""
    return _ANY.sub("", CELL.sub("a cell", text))


def clean(_: Sphinx, page: nodes.document) -> None:
    """Leave the folders out of a page's blocks."""
    for block in page.findall(nodes.literal_block):
        text = without_places(block.astext())
        if text != block.astext():
            block.rawsource = text
            block.children = [nodes.Text(text)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the cleaning."""
    app.connect("doctree-read", clean)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
