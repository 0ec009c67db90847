"""The directives `units`, `prefixes` and `read-as`: how quantities are written, from the reader's code.

`units` and `prefixes` are the tables of `circuits.units`, the latter beside SPICE's of netlists. `read-as`
takes lines of a text and a unit, and shows what the text is read as, or why it is refused:

    ```{read-as}
    600fF F
    12M Hz
    ```
"""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from _extension.table import table
from circuits.errors import ParameterError
from circuits.units import MAY_BE_BARE, PREFIXES, UNITS, UNSCALED, parse_quantity
from netlists.read.number import SCALES

EXAMPLE = "12"


class UnitsDirective(SphinxDirective):
    """Units that a quantity may have."""

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        head = ("unit", "what has it", "example", "without the unit", "prefix")
        rows = [
            (
                f"`{unit}`" if unit else "none",
                UNITS[unit].noun,
                f"`{EXAMPLE}{UNITS[unit].usual}`",
                "taken" if unit in MAY_BE_BARE else "refused",
                "none" if unit in UNSCALED else "taken",
            )
            for unit in UNITS
        ]
        return [table(head, rows)]


class PrefixesDirective(SphinxDirective):
    """Prefixes at the edges, and SPICE's scale factors in netlists."""

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        edges = {f"1e{power}": prefix for prefix, power in PREFIXES.items() if prefix}
        netlist = {f"1e{round(_power(scale))}": suffix for suffix, scale in SCALES.items() if suffix != "mil"}
        powers = sorted({*edges, *netlist}, key=float)
        rows = [(power, _code(edges.get(power)), _code(netlist.get(power))) for power in powers]
        rows.append((f"{SCALES['mil']:g}", "", "`mil`"))
        return [table(("factor", "options and files", "netlists, case does not count"), rows)]


class ReadAsDirective(SphinxDirective):
    """Texts, and what each is read as."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        rows = [self._row(*line.split()) for line in self.content if line.strip()]
        return [table(("text", "for a quantity in", "is read as"), rows)]

    def _row(self, text: str, unit: str = "") -> tuple[str, str, str]:
        """A text, its unit, and the value or the refusal."""
        if unit not in UNITS:
            raise self.error(f"read-as: {text} {unit}: unknown unit")
        try:
            read = f"{parse_quantity(text, unit, 'x'):g} {unit}"
        except ParameterError as error:
            read = f"refused: {str(error).partition(', ')[2]}"
        return f"`{text}`", f"`{unit}`" if unit else "none", read


def _power(scale: float) -> float:
    """Power of ten of a factor."""
    return float(f"{scale:e}".partition("e")[2])


def _code(word: str | None) -> str:
    return f"`{word}`" if word else ""


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives."""
    app.add_directive("units", UnitsDirective)
    app.add_directive("prefixes", PrefixesDirective)
    app.add_directive("read-as", ReadAsDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
