"""The directive `command`: a command line, and what it prints and draws when the site is built.

    ```{command} noctule op rebound-neuron --csv devices.csv
    :lines: 12
    ```

The page shows the command, what it printed and the picture of each `--plot FILE`, `--schematic FILE`,
`--pareto FILE` and `--animate FILE`; where another status than 0 is right, what it said on stderr and the
status too. Commands are run by `make docs` alone (`noctule_run`), in a folder of the page's own, so that one
may read what another wrote; a status that is not the stated one fails the build. What a command gave is kept,
and taken again as long as the command, those before it on the page, what it needs and the packages' texts are
the same. With `:still: PICTURE` that picture stands where commands are not run, in print, and for who asks
for no motion, in the place of the film.

The directive `script` holds Python instead, which runs in the same folder, may read what commands wrote, and
goes on from the scripts before it on its page: what these printed stands with them.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import OptionSpec

from _extension.file_fields import netcdf
from _extension.running import ROOT, Done, block, done, drawn, page_folder, picture, reproduced

COLUMNS = 100  # of a file's lines that are shown
SHOWN = 6  # lines of a file that are shown
GO_ON = """import contextlib, io, sys
names = {"__name__": "__main__"}
*before, last = sys.argv[1:]
with contextlib.redirect_stdout(io.StringIO()):
    for code in before:
        exec(code, names)
exec(last, names)"""


class CommandDirective(SphinxDirective):
    """Show a command, run it where the build runs commands, and show what came out."""

    required_arguments = 1
    final_argument_whitespace = True
    has_content = False
    option_spec: ClassVar[OptionSpec] = {
        "lines": directives.nonnegative_int,  # of the output that are shown, all unless given; 0 hides it
        "status": directives.nonnegative_int,  # the exit status that is right, 0 unless given
        "alt": directives.unchanged,  # what the picture shows, for who cannot see it
        "hide": directives.flag,  # only what it draws is shown
        "still": directives.unchanged_required,  # a picture beside the page, for who prints or wants no film
        "shows": directives.unchanged_required,  # a file that it writes, of which the beginning is shown
        "experiment": directives.unchanged_required,  # its run is that of its rows, and may be 1
        "needs": directives.unchanged_required,  # files beside the page that it reads, shown before it
    }

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        line = " ".join(self.arguments[0].split())
        needs = self._needs()
        still = [self._still(self.options["still"])] if "still" in self.options else []
        shown: list[nodes.Node] = [
            block(path.read_text(encoding="utf-8").rstrip(), "text", path.name) for path in needs
        ]
        if "hide" not in self.options:
            shown.append(block(f"$ {line}", "console"))
        if not self.config.noctule_run:
            return shown + still
        if "experiment" in self.options:
            return shown + self._experiment(self.options["experiment"])
        found = _in_turn(self, line, needs, self.options.get("shows", "").split())
        wanted = self.options.get("status", 0)
        if found.status != wanted:
            raise self.error(f"{line}: status {found.status} where {wanted} is due: {found.err.strip()}")
        shown += _output(found.out.rstrip("\n").splitlines(), self.options.get("lines"))
        if wanted:
            shown += _output([*found.err.splitlines(), f"[status {wanted}]"], None)
            return shown + self._pictures(found, [n for n in drawn(shlex.split(line)) if _left(found, n)])
        if "shows" in self.options:
            shown += self._written(Path(found.folder) / Path(self.options["shows"]).name, line)
        pictures = self._pictures(found, drawn(shlex.split(line)))
        if still:
            return [*shown, nodes.container("", *pictures, *still, classes=["noctule-film"])]
        return shown + pictures

    def _experiment(self, name: str) -> list[nodes.Node]:
        """The picture of an experiment, and which of its rows disagree, if any do."""
        found, drawing = reproduced(self, name)
        if found.status not in (0, 1):
            raise self.error(f"{name}: status {found.status}: {found.err.strip()}")
        said = found.err.splitlines() if found.status else []
        return [*_output(said, None), picture(self, drawing, self.arguments[0])]

    def _pictures(self, found: Done, names: Iterable[str]) -> list[nodes.Node]:
        """Pictures of those names that the command drew."""
        return [picture(self, Path(found.folder) / name, self.arguments[0]) for name in names]

    def _still(self, name: str) -> nodes.Node:
        """The picture that stands for a film, where nothing runs or moves."""
        return nodes.image(uri=name, alt=self.options.get("alt", name))

    def _needs(self) -> list[Path]:
        """Files that the command reads."""
        page = Path(self.env.doc2path(self.env.docname)).parent
        found = [page / name for name in self.options.get("needs", "").split()]
        for path in found:
            self.env.note_dependency(str(path))
        return found

    def _written(self, path: Path, line: str) -> list[nodes.Node]:
        """The beginning of a text, or what stands in a netCDF file."""
        if not path.is_file():
            raise self.error(f"{line}: wrote no {path.name}")
        if path.suffix == ".nc":
            return [netcdf(path)]
        lines = [each[:COLUMNS] for each in path.read_text(encoding="utf-8").splitlines()]
        return [block(_beginning(lines, SHOWN), "text", path.name)]


class ScriptDirective(SphinxDirective):
    """Show Python, run it where the build runs commands, and show what it printed."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        code = "\n".join(self.content)
        shown: list[nodes.Node] = [block(code, "python")]
        if not self.config.noctule_run:
            return shown
        before = self.env.temp_data.setdefault("noctule_scripts", [])
        found = _in_turn(self, shlex.join(["python", "-c", GO_ON, *before, code]))
        before.append(code)
        if found.status:
            raise self.error(f"script: status {found.status}: {found.err.strip()}")
        return shown + _output(found.out.rstrip("\n").splitlines(), None)


def _in_turn(
    directive: SphinxDirective, line: str, needs: Iterable[Path] = (), written: Sequence[str] = ()
) -> Done:
    """What a command gave, now or when it was last run after the same ones of its page."""
    before = directive.env.temp_data.setdefault("noctule_commands", [])
    found = done(line, page_folder(directive), before, needs, written)
    before.append(line)
    return found


def _left(found: Done, name: str) -> bool:
    """Whether a command that ended with another status than 0 drew a picture before."""
    return (Path(found.folder) / name).is_file()


def _output(lines: list[str], most: int | None) -> list[nodes.Node]:
    """What was printed, cut to the lines that are wanted."""
    if not lines or most == 0:
        return []
    shown = _beginning(lines, len(lines) if most is None else most)
    return [nodes.container("", block(shown, "text"), classes=["noctule-output"])]


def _beginning(lines: list[str], most: int) -> str:
    """The first lines of a text, with how many were left out."""
    more = [f"... {len(lines) - most} more lines"] if len(lines) > most else []
    return "\n".join([*lines[:most], *more])


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive and what it is configured by."""
    app.add_config_value("noctule_run", default=False, rebuild="env", types=(bool, str))
    app.add_config_value("noctule_folder", default=str(ROOT / "build" / "commands"), rebuild="env")
    app.add_directive("command", CommandDirective)
    app.add_directive("script", ScriptDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
