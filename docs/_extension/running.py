"""Commands that pages show, run when the site is built, and what they gave, kept.

A command runs in a folder of the page's own. What it gave is taken again as long as the command, what it
depends on and the packages' texts are the same.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("circuits", "chips", "netlists", "system")
DRAWN = ("--plot", "--schematic", "--pareto", "--animate")
DEADLINE = 3600.0  # s of wall clock for one command, on a machine with other work; ours


@dataclass(frozen=True, slots=True)
class Done:
    """What a command gave: status, stdout and stderr, and the folder of its pictures and files."""

    status: int
    out: str
    err: str
    folder: str


def page_folder(directive: SphinxDirective) -> Path:
    """Where a page's commands run and what they gave is kept."""
    return Path(directive.config.noctule_folder) / directive.env.docname


def done(
    line: str, page: Path, before: Iterable[str] = (), files: Iterable[Path] = (), written: Iterable[str] = ()
) -> Done:
    """What a command gave, now or when it was last run.

    Parameters
    ----------
    line
        The command.
    page
        The page's folder, in whose `work` it runs.
    before
        What else it depends on, such as the commands before it on the page.
    files
        Files that it may change, which are copied into its folder under their names.
    written
        Files that it writes and that are kept, beside its pictures.
    """
    files, before, written = list(files), list(before), list(written)
    texts = [hashlib.sha256(path.read_bytes()).hexdigest() for path in files]
    key = hashlib.sha256("\n".join([_texts(), *texts, *before, *written, line]).encode()).hexdigest()[:20]
    kept = page / f"{key}.json"
    if kept.is_file():
        return Done(**json.loads(kept.read_text(encoding="utf-8")))
    work = page / "work"
    if not before:  # the first of its page, which finds nothing of an earlier build
        shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True, exist_ok=True)
    if not (work / "examples").exists():  # as in the checkout, where a reader gives the command
        (work / "examples").symlink_to(ROOT / "examples")
    names = [*drawn(shlex.split(line)), *written]
    for name in names:
        (work / name).unlink(missing_ok=True)
    for path in files:
        shutil.copy(path, work / path.name)
    found = _run(line, work, page / key, names)
    kept.write_text(json.dumps(asdict(found)), encoding="utf-8")
    return found


def reproduced(directive: SphinxDirective, name: str) -> tuple[Done, Path]:
    """What an experiment found, as JSON, and its picture: one run serves all pages that show it.

    name : the experiment, one that is no campaign.
    """
    drawing = f"experiment-{name}.png"
    folder = Path(directive.config.noctule_folder) / "experiments" / name
    found = done(f"noctule reproduce {name} --json --plot {drawing}", folder)
    return found, Path(found.folder) / drawing


def drawn(words: list[str]) -> list[str]:
    """Names of the pictures that a command is asked for."""
    return [value for option, value in pairwise(words) if option in DRAWN]


def picture(directive: SphinxDirective, path: Path, line: str) -> nodes.Node:
    """The picture that a command drew, beside the page."""
    if not path.is_file():
        raise directive.error(f"{line}: drew no {path.name}")
    source = Path(directive.env.srcdir)
    node = nodes.image(uri=os.path.relpath(path, source / Path(directive.env.docname).parent))
    node["alt"] = directive.options.get("alt", line)
    return node


def block(text: str, language: str, name: str = "") -> nodes.Node:
    """A block of code, under its file's name where it has one."""
    node = nodes.literal_block(text, text)
    node["language"] = language
    if not name:
        return node
    return nodes.container(
        "", nodes.caption("", name), node, classes=["literal-block-wrapper"], literal_block=True
    )


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


def _run(line: str, folder: Path, kept: Path, written: list[str]) -> Done:
    """Run a command in a folder by the environment that builds the site, and keep files that it writes."""
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "COLUMNS": "90",
        "MPLBACKEND": "Agg",
        "NO_COLOR": "1",
    }
    words = shlex.split(line)
    ended = subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    for name in written:
        if (folder / name).is_file():
            kept.mkdir(parents=True, exist_ok=True)
            shutil.copy(folder / name, kept / Path(name).name)
    return Done(ended.returncode, ended.stdout, ended.stderr, str(kept))
