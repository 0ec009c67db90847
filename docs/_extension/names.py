"""The names that users call: a section a heading of a package's list, and the whole docstring of each name.

    .. names:: circuits.api

The list is the module's `__all__`; comments on lines of their own in it are the headings.
"""

from __future__ import annotations

import ast
import inspect
import re
import tokenize
from importlib import import_module
from io import StringIO
from itertools import pairwise
from types import ModuleType

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

NO_TEXT = re.compile(r"(?<== )<[\w.'<> ]+>")  # <factory>, <function name at 0x...>


def grouped(module: ModuleType) -> dict[str, list[str]]:
    """Names of a module's list by their heading, in the order in which they stand there."""
    source = inspect.getsource(module)
    (listed,) = (
        node.value
        for node in ast.parse(source).body
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__"
    )
    lines = range(listed.lineno + 1, (listed.end_lineno or listed.lineno) + 1)
    found: dict[str, list[str]] = {}
    for token in tokenize.generate_tokens(StringIO(source).readline):
        if token.start[0] in lines and token.type == tokenize.COMMENT:
            found[token.string.removeprefix("#").strip()] = []
        elif token.start[0] in lines and token.type == tokenize.STRING:
            found[next(reversed(found))].append(ast.literal_eval(token.string))
    return found


def constant_text(module: ModuleType, name: str) -> str:
    """What stands below the line that defines a constant, in the module that a list has it from."""
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.ImportFrom) and any(alias.name == name for alias in node.names):
            body = ast.parse(inspect.getsource(import_module(str(node.module)))).body
            for own, after in pairwise(body):
                targets = own.targets if isinstance(own, ast.Assign) else [getattr(own, "target", None)]
                is_own = any(getattr(target, "id", "") == name for target in targets)
                if is_own and isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                    return str(after.value.value)
    return ""


def block(module: ModuleType, name: str) -> list[str]:
    """The directive of a name, in reStructuredText."""
    thing, path = getattr(module, name), f"{module.__name__}.{name}"
    if isinstance(thing, type):
        kind = "autoexception" if issubclass(thing, Exception) else "autoclass"
        fields = getattr(thing, "_fields", ())
        return [
            f".. {kind}:: {path}",
            *([] if kind == "autoexception" else ["   :members:"]),
            *([f"   :exclude-members: {', '.join(fields)}"] if fields else []),
            "",
        ]
    if callable(thing):
        return [f".. autofunction:: {path}", ""]
    text = constant_text(module, name)
    return [f".. py:data:: {path}", "", *(f"   {line}" for line in text.split("\n")), ""]


def as_signature(
    _app: Sphinx, _what: str, _name: str, _obj: object, _options: object, signature: str | None, result: str
) -> tuple[str | None, str]:
    """Write `...` for a default that has no text of its own, as that of a factory."""
    return (None if signature is None else NO_TEXT.sub("...", signature)), result


class NamesDirective(SphinxDirective):
    """The names of a module's list, a section a heading."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Sections of the list."""
        module = import_module(self.arguments[0])
        return [self._section(module, title, names) for title, names in grouped(module).items()]

    def _section(self, module: ModuleType, title: str, names: list[str]) -> nodes.Node:
        """Section of a heading."""
        place = nodes.make_id(f"{module.__name__} {title}")
        section = nodes.section("", nodes.title(title, title), ids=[place], names=[place])
        lines = [line for name in names for line in block(module, name)]
        self.state.nested_parse(StringList(lines, source=module.__name__), 0, section)
        self.state.document.note_implicit_target(section)
        return section


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("names", NamesDirective)
    app.connect("autodoc-process-signature", as_signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
