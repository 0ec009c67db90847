"""The verb `noctule new`: writes a small package of a user's own, which runs and whose test passes."""

from __future__ import annotations

import re
import shutil
import tempfile
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from chips.registry import chip_names
from circuits.errors import DataError, ParameterError
from circuits.registry import block_names
from system.cli.output import print_json, print_line
from system.cli.verbs import New
from system.registry import experiment_names, system_names

_NAME = re.compile(r"[a-z][a-z0-9]*(?:-[a-z0-9]+)*")
_TAKEN = {"block": block_names, "chip": chip_names, "robot": system_names, "experiment": experiment_names}
_FILES = {
    "module": "{module}.py",
    "test": "test_{module}.py",
    "readme": "README.md",
    "pyproject": "pyproject.toml",
}


def new_command(asked: New) -> None:
    """Write the package into a folder of its name, and say what to do with it."""
    package = package_of(asked.kind, asked.name)
    folder = Path(asked.output or ".") / asked.name
    write_package(package, folder)
    if asked.as_json:
        print_json({"kind": asked.kind, "name": asked.name, "folder": str(folder), "files": sorted(package)})
        return
    print_line(f"{folder}: {', '.join(sorted(package))}\n")
    print_line(package["README.md"].rstrip())


def package_of(kind: str, name: str) -> dict[str, str]:
    """Give the files of a package by their names.

    Raises `ParameterError` for a name that is none, or that something of this kind or a module has already.
    """
    if not _NAME.fullmatch(name):
        raise ParameterError(
            f"{name[:80]}: is no name, must be small letters, digits and hyphens; write as my-{kind}"
        )
    module = name.replace("-", "_")
    if name in _TAKEN[kind]() or find_spec(module) is not None:
        owner = f"a {kind}" if name in _TAKEN[kind]() else "a module of Python"
        raise ParameterError(f"{name}: is the name of {owner} already; give another, as my-{name}")
    folder = files("system.cli") / "templates" / kind
    return {
        called.format(module=module): (folder / f"{part}.txt")
        .read_text(encoding="utf-8")
        .replace("@module@", module)
        .replace("@name@", name)
        for part, called in _FILES.items()
    }


def write_package(package: dict[str, str], folder: Path) -> None:
    """Write a package's files into a folder that is not there yet: all of them, or none.

    Raises `DataError` where the folder is there, or cannot be written.
    """
    if folder.exists():
        raise DataError(f"{folder}: is there already; give another name, or --output DIR")
    try:
        with tempfile.TemporaryDirectory(dir=folder.parent) as made:
            for name, text in package.items():
                (Path(made) / name).write_text(text, encoding="utf-8")
            shutil.copytree(made, folder)
    except OSError as error:
        raise DataError(
            f"{folder}: cannot be written, {error.strerror or error}; give --output DIR"
        ) from None
