"""The tree of pages that stands beside each page is made of their titles, without what is below them.

Sphinx copies all headings and names of all pages for it, and then leaves out all but the titles. Pages of the
reference have hundreds of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

_BEFORE_THE_THEME = 400  # which asks for the tree at Sphinx's usual 500


def titles_of(toc: nodes.bullet_list) -> nodes.bullet_list:
    """A copy of a page's contents with its title, and the trees of pages that stand anywhere below it."""
    found: nodes.bullet_list = toc.copy()
    for item in toc.children:
        if isinstance(item, nodes.list_item) and len(item) > 1:
            kept = item.copy()
            kept += item[0].deepcopy()
            trees = [tree.deepcopy() for tree in item.findall(addnodes.toctree)]
            if trees:
                kept += nodes.bullet_list("", *trees)
            found += kept
        else:
            found += item.deepcopy()
    return found


def setup(app: Sphinx) -> dict[str, bool]:
    """Give pages a tree that is made of titles."""
    titles: dict[str, nodes.bullet_list] = {}

    def give(_: Sphinx, page: str, template: str, context: dict[str, Any], tree: object) -> None:
        whole: Callable[..., str] | None = context.get("toctree")
        if whole is None:
            return

        def toctree(**options: Any) -> str:
            if not options.get("titles_only"):
                return whole(**options)
            contents, environment = app.env.tocs, app.env
            titles.update({name: titles_of(toc) for name, toc in contents.items() if name not in titles})
            environment.tocs = titles
            try:
                return whole(**options)
            finally:
                environment.tocs = contents

        context["toctree"] = toctree

    app.connect("html-page-context", give, priority=_BEFORE_THE_THEME)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
