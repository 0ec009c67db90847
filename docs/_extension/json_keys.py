"""The directives `scenario-keys`, `summary-keys` and `row-keys`: keys of JSON documents, from the code.

`scenario-keys SYSTEM` has what a run says of its scenario, which is stated with each option. `summary-keys`
has the entries with which every run's summary begins, from the table of `system.system`. `row-keys` has a
row of an experiment. A key of which the code does not say what it is fails the build.
"""

from __future__ import annotations

import re

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import system.system
from _extension.table import Cell, table
from system.registry import load_system
from system.rule import unjudged
from system.statement import Statement

ENTRY = re.compile(r"^(\w+)  +(\S+)  +(.*)$", re.MULTILINE)  # of the table in `system.system`
SHARED = {  # of options that all systems have
    "seed": "Of noise and worlds",
    "temperature_C": "Of the chips",
}
ROW = {
    "name": "its name, which ends with its unit",
    "paper": "the paper's value, a number or words; null where it gives none",
    "ours": "the value that was found",
    "rule": "when ours agrees, in words",
    "tolerance": "the number of the rule; null where it has none",
    "fitted": "whether the value was used to choose parameters",
    "agrees": "the verdict; null where the rule gives none",
}


class ScenarioKeysDirective(SphinxDirective):
    """Keys of a system's scenario."""

    required_arguments = 1
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        rows = scenario_keys(self.arguments[0])
        missing = [key for key, _, said in rows if not said]
        if missing:
            raise self.error(f"scenario-keys: {', '.join(missing)}: no option says what it is")
        return [table(("key", "unit", "what it is"), rows)]


class SummaryKeysDirective(SphinxDirective):
    """Entries with which a summary begins."""

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        said = {name: (unit, words) for name, unit, words in ENTRY.findall(system.system.__doc__ or "")}
        missing = [name for name in system.system.ENTRIES if name not in said]
        if missing:
            raise self.error(f"summary-keys: {', '.join(missing)}: system.system does not say what it is")
        rows: list[list[Cell]] = []
        for name in system.system.ENTRIES:
            unit, words = said[name]
            rows.append([f"`{name}`", "" if unit in {"-", "text"} else f"`{unit}`", words])
        return [table(("key", "unit", "what it is"), rows)]


class RowKeysDirective(SphinxDirective):
    """Keys of a row of an experiment."""

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        keys = Statement("x", None, None, unjudged()).row()
        if missing := [key for key in keys if key not in ROW]:
            raise self.error(f"row-keys: {', '.join(missing)}: not told")
        return [table(("key", "what it is"), [(f"`{key}`", ROW[key]) for key in keys])]


def scenario_keys(name: str) -> list[tuple[str, str, str]]:
    """Key, unit and what it is of each entry that a run's JSON has of its scenario."""
    rows = []
    for one in load_system(name).settings.values():
        if one.key and one.part != "" and one.field != "die":
            unit = "rad" if one.option.unit == "deg" else one.option.unit
            said = one.option.help[:1].upper() + one.option.help[1:] or SHARED.get(one.key, "")
            rows.append((f"`{one.key}`", f"`{unit}`" if unit else "", said))
    return rows


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives."""
    app.add_directive("scenario-keys", ScenarioKeysDirective)
    app.add_directive("summary-keys", SummaryKeysDirective)
    app.add_directive("row-keys", RowKeysDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
