"""The import graph of the four packages: what is read from their texts, late and named imports included."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import networkx as nx

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("circuits", "chips", "netlists", "system")
NAMING = {
    "import_module": "",
    "loaded": "",
    "verb": "system.cli.",
}  # functions, and what stands before a name
ASSERTING = ("np.testing.assert_", "pytest.raises", "pytest.warns", "pytest.fail")  # beside `assert`

TREES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): ast.parse(
        path.read_text(encoding="utf-8")
    )
    for package in PACKAGES
    for path in sorted((ROOT / package).rglob("*.py"))
}


def import_graph() -> nx.DiGraph:
    """Which module imports which: at the top, within a function, or by a literal name."""
    graph = nx.DiGraph()
    graph.add_nodes_from(TREES)
    for module, tree in TREES.items():
        graph.add_edges_from((module, name) for name in imported(tree) if name in TREES)
    return graph


def imported(tree: ast.AST) -> Iterator[str]:
    """Names of modules that a tree imports, whenever it does; those for types alone are none."""
    for node in _run(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and called(node) in NAMING and node.args:
            yield from _named(node)


def called(node: ast.Call) -> str:
    """Name of the function that is called, without what it is an attribute of."""
    return ast.unparse(node.func).rpartition(".")[2]


def late_imports(tree: ast.AST) -> list[str]:
    """Import statements within functions."""
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    inside = [node for function in functions for node in ast.walk(function)]
    return [ast.unparse(node) for node in inside if isinstance(node, ast.Import | ast.ImportFrom)]


def without_assertion(tree: ast.Module) -> list[str]:
    """Names of tests that assert nothing: neither by themselves nor by a function of their own module."""
    functions = {n.name: n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)}
    asserting = {name for name, node in functions.items() if _asserts(node)}
    return [
        name
        for name, node in functions.items()
        if name.startswith("test_") and name not in asserting and not asserting & set(_called(node))
    ]


def _asserts(function: ast.FunctionDef) -> bool:
    by_call = any(name.startswith(ASSERTING) for name in _called(function))
    return by_call or any(isinstance(node, ast.Assert) for node in ast.walk(function))


def _called(function: ast.FunctionDef) -> Iterator[str]:
    return (ast.unparse(node.func) for node in ast.walk(function) if isinstance(node, ast.Call))


def _named(node: ast.Call) -> Iterator[str]:
    """The module of `import_module("module")` or `loaded("module:attribute")`."""
    place = node.args[0]
    if isinstance(place, ast.Constant) and isinstance(place.value, str):
        yield (NAMING[called(node)] + place.value).partition(":")[0]


def _run(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes that are run at some time: not those under `if TYPE_CHECKING`."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield from _run(child)
