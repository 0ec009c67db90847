"""The directive `rows` and the role `row`: what an experiment found beside its paper, and links to its rows.

    ```{rows} cheely2003-fig9
    ```

The table is that of `noctule reproduce EXPERIMENT --json`, run by `make docs` alone and kept as a `command`
is. Of a campaign it is either what a file in `evidence/` says (`:kept: milde2017-table1.jsonl`), which the
build refuses if a run is missing in it, or a form with fewer runs (`:short: dies=2`), named so, or both, or,
where that is long too, the command alone (`:long:`).

A claim links to its row by {row}`its words <EXPERIMENT/ROW>`. Without the run there are no rows, and the
link leads to the experiment.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util.docutils import ReferenceRole, SphinxDirective
from sphinx.util.typing import OptionSpec

from _extension.running import ROOT, block, done, page_folder, picture, reproduced
from _extension.table import paragraph, table, text
from system.registry import load_experiment
from system.verdict.null import Score

HEAD = ("row", "paper", "ours", "agrees when", "", "agrees")
VERDICTS = {True: "yes", False: "no", None: ""}
WORD = re.compile(r"[^a-z0-9]+")


def anchor(experiment: str, row: str = "") -> str:
    """Where an experiment, or one of its rows, stands on its page."""
    return WORD.sub("-", f"rows {experiment} {row}".lower()).strip("-")


class RowsDirective(SphinxDirective):
    """Show the rows of an experiment."""

    required_arguments = 1
    has_content = False
    option_spec: ClassVar[OptionSpec] = {
        "kept": directives.unchanged_required,  # its campaign's file in `evidence/`
        "short": directives.unchanged_required,  # counts of a form with fewer runs, NAME=COUNT
        "long": directives.unchanged,  # the experiment takes too long to be run here, and how long if known
        "plot": directives.flag,  # with its picture
        "alt": directives.unchanged_required,  # what the picture shows, for who cannot see it
    }

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        name = self.arguments[0]
        section = nodes.container(ids=[anchor(name)], classes=["noctule-rows"])
        self._note(anchor(name))
        summary = load_experiment(name).summary
        section += [paragraph(f"{summary[0].upper()}{summary[1:]}."), block(f"$ {self._line()}", "console")]
        if "long" in self.options:
            time = f" It takes {self.options['long']}." if self.options["long"] else ""
            section += paragraph(f"This is a long campaign, which building these pages does not run.{time}")
        elif self.config.noctule_run:
            section += self._found(name)
        return [section]

    def _line(self) -> str:
        """The command for a reader."""
        words = [f"noctule reproduce {self.arguments[0]}"]
        words += [f"--param {count}" for count in self.options.get("short", "").split()]
        if "kept" in self.options:
            words.append(f"--output evidence/{self.options['kept']} --resume")
        return " ".join(words)

    def _found(self, name: str) -> list[nodes.Node]:
        """The rows, and what is said of them."""
        line = f"{self._line().replace('evidence/', '')} --json"
        kept = [ROOT / "evidence" / self.options["kept"]] if "kept" in self.options else []
        if load_experiment(name).counts is None:
            found, drawing = reproduced(self, name)
        else:
            line += f" --plot {name}.png" if "plot" in self.options else ""
            found = done(line, page_folder(self) / "rows", files=kept, written=[path.name for path in kept])
            drawing = Path(found.folder) / f"{name}.png"
        if found.status not in (0, 1) or not found.out:
            raise self.error(f"{line}: status {found.status}: {found.err.strip()}")
        if any((Path(found.folder) / path.name).read_bytes() != path.read_bytes() for path in kept):
            raise self.error(f"{line}: made runs that the file has not")
        report = json.loads(found.out)
        shown: list[nodes.Node] = []
        if "short" in self.options:
            shown.append(paragraph(_short_form(name, self.options["short"])))
        shown.append(self._table(name, report["rows"]))
        shown.append(paragraph(_scores(report["scores"])))
        shown += _notes(report["notes"])
        if "plot" in self.options:
            shown.append(picture(self, drawing, line))
        return shown

    def _table(self, experiment: str, rows: list[dict[str, Any]]) -> nodes.table:
        """The rows, each of which can be linked to."""
        ids = [anchor(experiment, row["name"]) for row in rows]
        for each in ids:
            self._note(each)
        return table(HEAD, [_cells(row, each) for row, each in zip(rows, ids, strict=True)], ids)

    def _note(self, each: str) -> None:
        """Make an anchor known to the role."""
        std = self.env.get_domain("std")
        std.note_hyperlink_target(each, self.env.docname, each, each)  # type: ignore[attr-defined]


class RowRole(ReferenceRole):
    """A link to a row of an experiment; without a title of its own the row's name is shown."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Nodes of the page."""
        experiment, _, row = self.target.partition("/")
        wanted = anchor(experiment, row if self.config.noctule_run else "")
        words = self.title if self.has_explicit_title else (row or experiment)
        node = addnodes.pending_xref(
            refdomain="std",
            reftype="ref",
            reftarget=wanted,
            refexplicit=True,
            refwarn=True,
            refdoc=self.env.docname,
        )
        self.set_source_info(node)
        node += nodes.inline("", "", *text(words))
        return [node], []


def _scores(scores: list[dict[str, Any]]) -> str:
    """How many of the rows hold for ours, nulls and the paper, as the command prints it."""
    return f"Rows that hold: {'; '.join(str(Score(**score)) for score in scores)}."


def _cells(row: dict[str, Any], each: str) -> tuple[str | nodes.Node, ...]:
    """Cells of a row."""
    link = nodes.reference("", row["name"], refid=each)
    verdict = nodes.inline(
        "", VERDICTS[row["agrees"]], classes=[f"noctule-{VERDICTS[row['agrees']] or 'open'}"]
    )
    return (
        nodes.paragraph("", "", link),
        _shown(row["paper"]),
        _shown(row["ours"]),
        row["rule"],
        "fitted" if row["fitted"] else "predicted",
        nodes.paragraph("", "", verdict),
    )


def _notes(notes: list[str]) -> list[nodes.Node]:
    """What the experiment says besides its rows, folded."""
    if not notes:
        return []
    said = nodes.bullet_list("", *(nodes.list_item("", paragraph(note)) for note in notes))
    opened = "<details><summary>Notes of the run</summary>"
    return [nodes.raw("", opened, format="html"), said, nodes.raw("", "</details>", format="html")]


def _shown(value: float | str | None) -> str | nodes.Node:
    """A value; a number has four significant digits and stays on one line."""
    if value is None or isinstance(value, str):
        return value or ""
    return nodes.paragraph("", f"{value:.4g}", classes=["noctule-number"])


def _short_form(name: str, counts: str) -> str:
    """Sentences that say what is left out."""
    usual = load_experiment(name).counts or {}
    told = ", ".join(f"{n} = {k}" for n, k in usual.items())
    few = counts.replace("=", " = ")
    return (
        f"Short form: {few}. The whole has {told}: "
        f"`noctule reproduce {name} --output {name}.jsonl --resume`. "
        "So few runs may disagree where the whole agrees, and the other way round."
    )


def setup(app: Sphinx) -> dict[str, bool]:
    """Register directive and role."""
    app.add_directive("rows", RowsDirective)
    app.add_role("row", RowRole())
    return {"parallel_read_safe": True, "parallel_write_safe": True}
