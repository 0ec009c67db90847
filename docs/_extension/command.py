"""The directive `command`: a command line, and what it prints and draws when the site is built.

    ```{command} noctule op rebound-neuron --csv devices.csv
    :lines: 12
    ```

The page shows the command, what it printed and the picture of each `--plot FILE` and `--animate FILE`.
Commands are run by `make docs` alone (`noctule_run`), in a folder of the page's own, so that one may read
what another wrote; a status that is not the stated one fails the build. What a command gave is kept, and
taken again as long as the command, those before it on the page and the packages' texts are the same.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import OptionSpec

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("circuits", "chips", "netlists", "system")
DRAWN = ("--plot", "--animate")
DEADLINE = 900.0  # s of wall clock for one command; ours


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
    }

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        line = " ".join(self.arguments[0].split())
        shown: list[nodes.Node] = [] if "hide" in self.options else [_block(f"$ {line}", "console")]
        if not self.config.noctule_run:
            return shown
        done = self._done(line)
        wanted = self.options.get("status", 0)
        if done["status"] != wanted:
            raise self.error(f"{line}: status {done['status']} where {wanted} is due: {done['err'].strip()}")
        text = done["out"].rstrip("\n")
        shown += _output(text.splitlines(), self.options.get("lines"))
        for name in drawn(shlex.split(line)):
            shown.append(self._picture(Path(done["folder"]) / name, line))
        return shown

    def _done(self, line: str) -> dict[str, object]:
        """What the command gave, now or when it was last run after the same ones."""
        before = self.env.temp_data.setdefault("noctule_commands", [])
        key = hashlib.sha256("\n".join([_texts(), *before, line]).encode()).hexdigest()[:20]
        before.append(line)
        page = Path(self.config.noctule_folder) / self.env.docname
        kept = page / f"{key}.json"
        if kept.is_file():
            return json.loads(kept.read_text(encoding="utf-8"))
        work = page / "work"
        work.mkdir(parents=True, exist_ok=True)
        done = _run(line, work)
        pictures = page / key
        for name in drawn(shlex.split(line)):
            if (work / name).is_file():
                pictures.mkdir(exist_ok=True)
                shutil.copy(work / name, pictures / Path(name).name)
        done["folder"] = str(pictures)
        kept.write_text(json.dumps(done), encoding="utf-8")
        return done

    def _picture(self, path: Path, line: str) -> nodes.Node:
        """The picture that the command drew, beside the page."""
        if not path.is_file():
            raise self.error(f"{line}: drew no {path.name}")
        source = Path(self.env.srcdir)
        node = nodes.image(uri=os.path.relpath(path, source / Path(self.env.docname).parent))
        node["alt"] = self.options.get("alt", line)
        return node


def drawn(words: list[str]) -> list[str]:
    """Names of the pictures that a command is asked for."""
    return [value for option, value in pairwise(words) if option in DRAWN]


@cache
def _texts() -> str:
    """A hash of all that a command's output may come from: the packages' texts and records."""
    digest = hashlib.sha256()
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*")):
            if path.suffix in {".py", ".nc", ".csv", ".json", ".toml", ".html"}:
                digest.update(str(path.relative_to(ROOT)).encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()


def _run(line: str, folder: Path) -> dict[str, object]:
    """Status and texts of a command that is run in a folder by the environment that builds the site."""
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "COLUMNS": "100",
        "MPLBACKEND": "Agg",
        "NO_COLOR": "1",
    }
    words = shlex.split(line)
    for name in drawn(words):
        (folder / name).unlink(missing_ok=True)
    done = subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    return {"status": done.returncode, "out": done.stdout, "err": done.stderr}


def _block(text: str, language: str) -> nodes.literal_block:
    """A block of code."""
    block = nodes.literal_block(text, text)
    block["language"] = language
    return block


def _output(lines: list[str], most: int | None) -> list[nodes.Node]:
    """What was printed, cut to the lines that are wanted, with how many were left out."""
    if not lines or most == 0:
        return []
    kept = (
        lines
        if most is None or len(lines) <= most
        else [*lines[:most], f"... {len(lines) - most} more lines"]
    )
    block = _block("\n".join(kept), "text")
    box = nodes.container("", block, classes=["noctule-output"])
    return [box]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive and what it is configured by."""
    app.add_config_value("noctule_run", default=False, rebuild="env", types=(bool, str))
    app.add_config_value("noctule_folder", default=str(ROOT / "build" / "commands"), rebuild="env")
    app.add_directive("command", CommandDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
