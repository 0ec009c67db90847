"""The directive `nir-nodes`: every node of NIR, and what a network on a chip has of it."""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from _extension.table import table
from system.mapping.nir.nodes import NODES


class NirNodesDirective(SphinxDirective):
    """The table of nodes."""

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        rows = [(f"`{each.type}`", each.rolls, each.nef, each.note) for each in NODES]
        return [table(("node", "ROLLS", "NEF chip", "what it becomes, or why not"), rows)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("nir-nodes", NirNodesDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
