"""The walks of CONTRIBUTING.md: the files, entry points and commands of each, found in its text.

A walk is a section `### ...`. Its Python blocks begin with the name of their file, its toml blocks are entry
points of a `pyproject.toml`, its sh blocks are what is done then. Where that begins with `noctule new`, files
and entry points are those that it writes.
"""

from __future__ import annotations

import re
import shlex
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from system.cli.new import package_of
from tests.documents import fenced

_WALK = re.compile(r"^### ([^\n]+)\n(.*?)(?=^#{2,3} |\Z)", re.DOTALL | re.MULTILINE)
_FILE = re.compile(r"# (\S+\.py)\n")
DISTRIBUTION = "walked-1.dist-info"
NEW = ("noctule", "new")


@dataclass(frozen=True, slots=True)
class Walk:
    """A section: Python text by the name of its file, entry points by group and name, and commands."""

    title: str
    files: Mapping[str, str]
    entry_points: Mapping[str, Mapping[str, str]]
    commands: tuple[tuple[str, ...], ...]


def walks(text: str) -> list[Walk]:
    """Walks of a text, in order."""
    return [_walk(title, body) for title, body in _WALK.findall(text)]


def without_walks(text: str) -> str:
    """The rest of a text."""
    return _WALK.sub("", text)


def install(found: Iterable[Walk], folder: Path) -> None:
    """Put the files of walks into a folder, and the description of the package that they are."""
    groups: dict[str, dict[str, str]] = {}
    for walk in found:
        for name, text in walk.files.items():
            (folder / name).write_text(text, encoding="utf-8")
        for group, entries in walk.entry_points.items():
            groups.setdefault(group, {}).update(entries)
    described = folder / DISTRIBUTION
    described.mkdir()
    (described / "METADATA").write_text("Metadata-Version: 2.1\nName: walked\nVersion: 1\n", encoding="utf-8")
    lines = [
        line
        for group, entries in groups.items()
        for line in (f"[{group}]", *(f"{n} = {v}" for n, v in entries.items()))
    ]
    (described / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _walk(title: str, body: str) -> Walk:
    blocks = fenced(body)
    texts = [text for language, text in blocks if language == "python"]
    tables = [tomllib.loads(text) for language, text in blocks if language == "toml"]
    lines = [line for language, text in blocks if language == "sh" for line in text.splitlines()]
    commands = [tuple(shlex.split(line)) for line in lines]
    files = {_file(text): text for text in texts}
    for package in (package_of(*words[2:4]) for words in commands if words[:2] == NEW):
        tables.append(tomllib.loads(package["pyproject.toml"]))
        files |= {n: text for n, text in package.items() if n.endswith(".py") and not n.startswith("test_")}
    return Walk(
        title,
        files,
        {group: entries for t in tables for group, entries in t["project"]["entry-points"].items()},
        tuple(words for words in commands if words[:2] != NEW),
    )


def _file(text: str) -> str:
    found = _FILE.match(text)
    assert found is not None, f"a Python block of a walk must begin with its file's name: {text[:40]}"
    return found[1]
