"""The reference from its sources: help of every command as it prints it, docstrings as they were written.

Docstrings are plain sentences in which `|v|` and `2 * W` are what they look like, so what reStructuredText
would take for markup is marked as text, outside of code in backticks.
"""

from __future__ import annotations

import re

import typer
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from typer.testing import CliRunner

from system.cli.command_line import app as command_line

CODE = re.compile(r"(`[^`]*`)")
MARKUP = re.compile(r"([*|]|_\b|_(?=\W|$))")
WIDTH = 100  # columns of help; ours


def verbs() -> list[tuple[str, ...]]:
    """Words by which every command is called, in the order of the help."""
    group = typer.main.get_command(command_line())
    found: list[tuple[str, ...]] = []
    for name, command in group.commands.items():  # type: ignore[attr-defined]
        found.append((name,))
        if hasattr(command, "list_commands"):
            found += [(name, inner) for inner in command.list_commands(typer.Context(command))]
    return found


class HelpDirective(SphinxDirective):
    """Help of every command, a section each."""

    def run(self) -> list[nodes.Node]:
        """Sections of the page."""
        return [self._section(verb) for verb in verbs()]

    def _section(self, verb: tuple[str, ...]) -> nodes.Node:
        """Section of a command."""
        said = CliRunner().invoke(
            command_line(), [*verb, "--help"], terminal_width=WIDTH, prog_name="noctule"
        )
        if said.exit_code != 0:
            raise self.error(f"noctule {' '.join(verb)} --help: status {said.exit_code}")
        title = f"noctule {' '.join(verb)}"
        section = nodes.section("", nodes.title(title, title), ids=["-".join(verb)], names=[title])
        block = nodes.literal_block(said.output, said.output.rstrip())
        block["language"] = "text"
        section += block
        self.state.document.note_implicit_target(section)
        return section


def as_text(_app: Sphinx, _what: str, _name: str, _obj: object, _options: object, lines: list[str]) -> None:
    """Escape, in the lines of a docstring, what its writer meant as text."""
    whole = "\n".join(lines)
    parts = CODE.split(whole)
    parts[::2] = [MARKUP.sub(r"\\\1", part) for part in parts[::2]]
    lines[:] = "".join(parts).split("\n")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive and the treatment of docstrings."""
    app.add_directive("help", HelpDirective)
    app.connect("autodoc-process-docstring", as_text)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
