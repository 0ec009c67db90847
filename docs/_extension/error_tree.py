"""The directives `error-tree`, `outcomes` and `raises`: errors of Python, from the code that raises them.

`error-tree` has every class that is raised on purpose, `outcomes` how a solver ends. `raises` runs its lines,
which must raise such an error, and shows them with its text.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import chips.rolls.pynn.lacking
import chips.wavefront.readout
import netlists.ngspice.library
from _extension.running import block
from _extension.table import table
from circuits.errors import CircuitError
from circuits.solver.outcome import Outcome

# modules that add to the tree
DEFINING = (chips.rolls.pynn.lacking, chips.wavefront.readout, netlists.ngspice.library)


class ErrorTreeDirective(SphinxDirective):
    """The tree of errors as a table."""

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        rows = [
            ("\u2003" * depth + f"`{each.__name__}`", _builtins(each), f"`{each.__module__}`", _said(each))
            for depth, each in tree()
        ]
        return [table(("class", "is also", "module", "says"), rows)]


class OutcomesDirective(SphinxDirective):
    """How a solver ends, as a table."""

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        return [table(("outcome", "what to do"), [(f"`{o.name}`", o.value) for o in Outcome])]


class RaisesDirective(SphinxDirective):
    """Lines of Python and the error that they raise."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        lines = "\n".join(self.content)
        try:
            exec(compile(lines, self.env.docname, "exec"), {})  # noqa: S102 - our own page's
        except CircuitError as error:
            said = f"{type(error).__name__}: {error}"
            shown = nodes.container("", block(said, "text"), classes=["noctule-output"])
            return [block(lines, "python"), shown]
        raise self.error("raises: the lines raise nothing")


def tree(root: type[CircuitError] = CircuitError, depth: int = 0) -> Iterator[tuple[int, type[CircuitError]]]:
    """Every class with its depth, parents first; one with a leading underscore stays inside its module."""
    yield depth, root
    for each in root.__subclasses__():
        if not each.__name__.startswith("_"):
            yield from tree(each, depth + 1)


def _builtins(each: type[CircuitError]) -> str:
    """Builtin errors as which a class can be caught."""
    found = [base for base in each.__mro__ if base.__module__ == "builtins"]
    own = [b for b in found if not any(b is not c and issubclass(c, b) for c in found)]
    return ", ".join(f"`{base.__name__}`" for base in own)


def _said(each: type[CircuitError]) -> str:
    """First paragraph of the docstring."""
    return " ".join((inspect.getdoc(each) or "").partition("\n\n")[0].split())


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives."""
    app.add_directive("error-tree", ErrorTreeDirective)
    app.add_directive("outcomes", OutcomesDirective)
    app.add_directive("raises", RaisesDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
