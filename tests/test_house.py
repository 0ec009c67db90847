"""The house itself: four packages, ours, typed, licensed, without notes to oneself or hidden imports."""

import ast
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from importlib.util import find_spec
from pathlib import Path

import networkx as nx
import pytest

from tests.house import PACKAGES, ROOT, called, import_graph, imported, late_imports, trees, without_assertion

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


# Who imports a module by its name: the catalogue behind every registry, and the one place of each extra
# library.
IMPORTS_BY_NAME = {
    "system.animation.movie": "imageio_ffmpeg",
    "circuits.catalogue": None,
    "circuits.programs.gpu": "cupy",
    "chips.rolls.program.nir": "nir",
    "netlists.ngspice.library": "PySpice.Spice.NgSpice.Shared",
    "netlists.verilog_a.host.module": "openvaf_py",
    "system.files.aedat4": "faery",
    "system.spikes.neo_file": "neo",
}
MOST_MODULES = 15  # in a folder
LONGER_FOLDERS = {"system/cli"}  # one file a verb
LONGER_BELOW = ("circuits/blocks/", "system/papers/")  # one circuit, or one experiment, a file


def test_no_import_is_a_cycle_late_and_named_ones_included() -> None:
    graph = import_graph()
    # the graph has what it is there to find: a named import, and one of every package
    assert graph.has_edge("system.cli.shared_options", "system.study.replay")
    assert graph.has_edge("system.cli.command_line", "system.cli.show")
    assert {name.partition(".")[0] for name in graph if graph.out_degree(name)} == set(PACKAGES)
    assert [sorted(part) for part in nx.strongly_connected_components(graph) if len(part) > 1] == []
    assert list(nx.selfloop_edges(graph)) == []


def test_a_cycle_through_a_late_or_a_named_import_would_be_found() -> None:
    late = ast.parse("def f():\n    from system.study import replay")
    named = ast.parse('loaded("system.study.replay:die_of")')
    typed = ast.parse("if TYPE_CHECKING:\n    import system.study.replay")
    assert ["system.study.replay" in imported(tree) for tree in (late, named, typed)] == [True, True, False]
    assert [len(late_imports(tree)) for tree in (late, named)] == [1, 0]


def test_no_import_statement_is_within_a_function() -> None:
    assert {name: found for name, tree in trees().items() if (found := late_imports(tree))} == {}


def test_modules_are_imported_by_name_in_the_catalogue_and_at_extras_alone() -> None:
    found = {}
    for name, tree in trees().items():
        calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
        for node in calls:
            if called(node) in {"import_module", "__import__", "extra"}:
                argument = node.args[0]
                found[name] = argument.value if isinstance(argument, ast.Constant) else None
    assert found == IMPORTS_BY_NAME


def test_every_test_asserts_something() -> None:
    trees = {
        path: ast.parse(path.read_text(encoding="utf-8")) for path in (ROOT / "tests").rglob("test_*.py")
    }
    assert {str(path): found for path, tree in trees.items() if (found := without_assertion(tree))} == {}
    assert without_assertion(ast.parse("def test_nothing():\n    check()")) == ["test_nothing"]


def test_no_folder_has_too_many_modules() -> None:
    folders = Counter(
        str(path.parent.relative_to(ROOT))
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
        if path.name != "__init__.py"
    )
    most = {folder: count for folder, count in folders.items() if count > MOST_MODULES}
    assert {f for f in most if f not in LONGER_FOLDERS and not f.startswith(LONGER_BELOW)} == set()


def _texts() -> list[Path]:
    inside = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*")]
    files = [path for path in [*ROOT.iterdir(), *inside] if path.is_file() and path.suffix in TEXTS]
    return sorted(path for path in files if "__pycache__" not in path.parts)


OPTION = re.compile(r"(?:^|[\s`'\"(])--[a-z]")


def _strings(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Strings of a module, those of formatted ones too, but no docstrings."""
    told = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and ast.get_docstring(node) is not None
        if isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            yield node.lineno, node.value


def test_options_are_named_by_the_command_line_alone() -> None:
    """Below it errors name fields (`ping_rate: ...`), which the command line turns into its options."""
    spoken = ("system.cli", "system.papers")
    found = [
        f"{module}:{line}: {text}"
        for module, tree in trees().items()
        if not module.startswith(spoken)
        for line, text in _strings(tree)
        if OPTION.search(text)
    ]
    assert found == []
