"""The import graph of the four packages: what is read from their texts, late and named imports included."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
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


@cache
def trees() -> dict[str, ast.Module]:
    """Syntax trees of all modules of the four packages, by the module's name."""
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): ast.parse(
            path.read_text(encoding="utf-8")
        )
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    }


def import_graph() -> nx.DiGraph:
    """Which module imports which: at the top, within a function, or by a literal name."""
    graph = nx.DiGraph()
    graph.add_nodes_from(trees())
    for module, tree in trees().items():
        graph.add_edges_from((module, name) for name in imported(tree) if name in trees())
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
    return _dotted(node.func).rpartition(".")[2]


def late_imports(tree: ast.Module) -> list[str]:
    """Import statements within functions."""
    functions = [n for n in _statements(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    inside = [node for function in functions for node in _statements(function)]
    return [ast.unparse(node) for node in inside if isinstance(node, ast.Import | ast.ImportFrom)]


def without_assertion(tree: ast.Module) -> list[str]:
    """Names of tests that assert nothing: neither by themselves nor by a function of their own module."""
    functions = {n.name: n for n in _statements(tree) if isinstance(n, ast.FunctionDef)}
    asserting = {name for name, node in functions.items() if _asserts(node)}
    return [
        name
        for name, node in functions.items()
        if name.startswith("test_") and name not in asserting and not asserting & set(_called(node))
    ]


def _asserts(function: ast.FunctionDef) -> bool:
    return any(isinstance(node, ast.Assert) for node in ast.walk(function)) or any(
        name.startswith(ASSERTING) for name in _called(function)
    )


def _called(function: ast.FunctionDef) -> Iterator[str]:
    return (_dotted(node.func) for node in ast.walk(function) if isinstance(node, ast.Call))


def _dotted(function: ast.expr) -> str:
    """`module.name` of what is called; of what has no name, that of its attribute, `.name`."""
    match function:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=value, attr=name):
            return f"{_dotted(value)}.{name}"
        case _:
            return ""


def _named(node: ast.Call) -> Iterator[str]:
    """The module of `import_module("module")` or `loaded("module:attribute")`."""
    place = node.args[0]
    if isinstance(place, ast.Constant) and isinstance(place.value, str):
        yield (NAMING[called(node)] + place.value).partition(":")[0]


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Statements below a node, without the expressions in them, which are nine tenths of a tree."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield child
            yield from _statements(child)


def _run(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes that are run at some time: not those under `if TYPE_CHECKING`."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield from _run(child)
