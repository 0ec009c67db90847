"""The house itself: the four packages are ours, typed, licensed, and without notes to oneself."""

import re
import tomllib
from importlib.metadata import packages_distributions
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("circuits", "chips", "netlists", "system")
FOLDERS = (*PACKAGES, "tests", "benchmarks", "examples", "docs", ".ci")
TEXTS = {".cfg", ".ini", ".ipynb", ".md", ".py", ".rst", ".toml", ".txt", ".yaml", ".yml", ""}
MARKS = re.compile(
    r"\b(?:TO" + r"DO|FIX" + r"ME|X" + r"XX|HA" + r"CK)\b"
)  # split, so that this file has none


@pytest.mark.parametrize("package", PACKAGES)
def test_no_other_distribution_owns_the_package(package: str) -> None:
    assert set(packages_distributions().get(package, [])) <= {"noctule"}


@pytest.mark.parametrize("package", PACKAGES)
def test_the_package_is_this_one(package: str) -> None:
    spec = find_spec(package)
    assert spec is not None
    assert spec.origin == str(ROOT / package / "__init__.py")


@pytest.mark.parametrize("package", PACKAGES)
def test_the_package_is_typed(package: str) -> None:
    assert (ROOT / package / "py.typed").is_file()


@pytest.mark.parametrize("folder", [*PACKAGES, "tests"])
def test_every_folder_of_modules_is_a_package(folder: str) -> None:
    folders = {path.parent for path in (ROOT / folder).rglob("*.py")}
    assert [str(each) for each in sorted(folders) if not (each / "__init__.py").is_file()] == []


def test_the_licence_is_there_and_said() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["license"] == "GPL-3.0-or-later"
    assert "Private :: Do Not Upload" in project["classifiers"]
    first_lines = (ROOT / "LICENSE").read_text(encoding="utf-8").splitlines()[:2]
    assert [line.strip() for line in first_lines] == ["GNU GENERAL PUBLIC LICENSE", "Version 3, 29 June 2007"]


def test_no_file_has_notes_to_oneself() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in _texts()}
    assert len(texts) > len(PACKAGES)
    assert [str(path.relative_to(ROOT)) for path, text in texts.items() if MARKS.search(text)] == []


def _texts() -> list[Path]:
    inside = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*")]
    files = [path for path in [*ROOT.iterdir(), *inside] if path.is_file() and path.suffix in TEXTS]
    return sorted(path for path in files if "__pycache__" not in path.parts)
