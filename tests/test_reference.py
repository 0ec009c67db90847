"""The names that users call: each is told with its parameters, their units and shapes, and its errors."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module

import pytest

from circuits.arrays import F64
from circuits.errors import ParameterError
from docs._extension.names import constant_text, grouped
from tests.docstring import has_unit, missing, raised
from tests.documents import DOCUMENTS, EXAMPLES, fenced
from tests.house import PACKAGES, ROOT, trees

MOST = 400
CODE = {"python", "{code-cell}"}
CELL_OPTIONS = (":", "%", "!", "---")
LISTS = sorted(name for name in trees() if name.split(".")[1:2] == ["api"])


@cache
def names(module: str) -> tuple[str, ...]:
    """The list of a module."""
    return tuple(import_module(module).__all__)


def origin(module: str, name: str) -> str:
    """Module from which a list has a name."""
    for node in trees()[module].body:
        if isinstance(node, ast.ImportFrom) and any(alias.name == name for alias in node.names):
            return str(node.module)
    return ""


def test_every_package_has_a_list_and_all_are_short_enough_to_read() -> None:
    assert {name.split(".")[0] for name in LISTS} == set(PACKAGES)
    assert 0 < sum(len(names(module)) for module in LISTS) <= MOST


@pytest.mark.parametrize("module", LISTS)
def test_a_list_only_names_what_stands_elsewhere_each_once(module: str) -> None:
    assert len(set(names(module))) == len(names(module))
    kinds = {type(node) for node in trees()[module].body}
    assert kinds <= {ast.Expr, ast.ImportFrom, ast.Assign}
    assert {name for name in names(module) if not origin(module, name)} == set()


@pytest.mark.parametrize(("module", "name"), [(m, n) for m in LISTS for n in names(m)])
def test_a_name_is_told_with_parameters_units_shapes_and_errors(module: str, name: str) -> None:
    thing = getattr(import_module(module), name)
    if callable(thing):
        assert missing(name, thing) == []
    else:
        assert constant_text(import_module(module), name)


def test_every_list_is_on_a_page_and_every_name_below_a_heading() -> None:
    pages = "\n".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs/reference/api").glob("*.md"))
    assert sorted(re.findall(r"^\.\. names:: (\S+)$", pages, re.MULTILINE)) == LISTS
    for module in LISTS:
        groups = grouped(import_module(module))
        assert [name for group in groups.values() for name in group] == list(names(module))
        assert all(groups.values())


def imported_from_us(text: str) -> Iterator[tuple[str, str]]:
    """Module and name of each import from our packages in a page or an example."""
    blocks = [body for language, body in fenced(text) if language in CODE] or [text]
    for block in blocks:
        lines = [line for line in block.split("\n") if not line.startswith(CELL_OPTIONS)]
        for node in ast.walk(ast.parse("\n".join(lines))):
            if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] in PACKAGES:
                yield from ((str(node.module), alias.name) for alias in node.names)


def test_pages_and_examples_import_listed_names_alone() -> None:
    things = {id(getattr(import_module(module), name)) for module in LISTS for name in names(module)}
    texts = {page: page.read_text(encoding="utf-8") for page in (*DOCUMENTS, *EXAMPLES)}
    python = {p: t for p, t in texts.items() if p.suffix == ".py" or any(k in CODE for k, _ in fenced(t))}
    used = {(page.name, *each) for page, text in python.items() for each in imported_from_us(text)}
    assert len(used) > MOST // 10
    assert [
        use for use in sorted(used) if id(getattr(import_module(use[1]), use[2], None)) not in things
    ] == []


def untold(length: float, times: F64, /, count: int = 1) -> float:
    """Do what is done to `length`, and more."""
    if length < 0.0:
        raise ParameterError("length")
    return length * count


def told(length: float, times: F64, count: int = 1) -> F64:
    """Positions at all times, m, float64[T].

    length: of the way, m. times: s, float64[T].

    Parameters
    ----------
    count
        How many there are.

    Raises
    ------
    ParameterError
        `length` is negative.
    """
    if length < 0.0:
        raise ParameterError("length")
    return length * count * times


def test_what_is_not_told_is_found() -> None:
    assert missing("untold", untold) == [
        "untold(length): no unit",
        "untold(times): not told",
        "untold(count): not told",
        "untold -> result: no unit",
        "untold: raises ParameterError, not told",
    ]
    assert missing("told", told) == []
    assert raised(told) == {"ParameterError"}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("length, m", True), ("a supply of 5 V", True), ("in degC", True), ("V^2/Hz", True), ("(F)", True),
        ("a share of all", True), ("A circuit.", False), ("the transistor's name", False),
    ],
)  # fmt: skip
def test_a_unit_is_no_word(text: str, found: bool) -> None:
    assert has_unit(text) is found
