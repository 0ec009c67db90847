"""The directives `stated`, `schema` and `netcdf`: fields of a file, from its type or from the file itself.

`stated` is for files whose columns or keys are options of a dataclass (`system.rows`, `system.table`): their
units, limits, defaults and help are the options' own. `schema` is for JSON that is held against a type
(`system.files.document`): its JSON schema, each field with what its class says of it in its docstring.
`netcdf` shows what stands in a file of this repository.

    ```{stated} system.worlds.sound.targets:_Row
    ```
    ```{schema} system.study.manifest:_Manifest
    ```
"""

from __future__ import annotations

import inspect
import json
import pkgutil
import re
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from itertools import takewhile, zip_longest
from pathlib import Path
from typing import Any, get_args

import msgspec
import xarray as xr
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from _extension.running import ROOT
from _extension.table import paragraph, table
from system.option import OPTION, Setting, rules_of, settings

ENTRY = re.compile(
    r"(?:(?<=[.;-] )|^)(?P<names>\w+(?:, \w+)*) ?: "
)  # of a docstring, before what the fields are
NAMES = re.compile(r"(?P<names>\w+(?:, \w+)*)(?: : .*)?")  # a line of numpydoc above what the fields are
MANY = "[]"


class StatedDirective(SphinxDirective):
    """Columns or keys that are options."""

    required_arguments = 1
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        kind = pkgutil.resolve_name(self.arguments[0])
        return list(_tables(kind, "", set()))


class SchemaDirective(SphinxDirective):
    """Keys of a JSON document by its type."""

    required_arguments = 1
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        kind = pkgutil.resolve_name(self.arguments[0])
        _, parts = msgspec.json.schema_components([kind], ref_template="{name}")
        top = next(name for name, part in parts.items() if part["title"] == kind.__name__)
        rows = list(_keys(top, parts, ""))
        missing = [row[0] for row in rows if not row[-1]]
        if missing:
            raise self.error(f"schema: {', '.join(missing)}: no docstring says what it is")
        return [paragraph(_first(parts[top])), table(("key", "type", "unless given", "what it is"), rows)]


class NetcdfDirective(SphinxDirective):
    """What stands in a netCDF file of the repository."""

    required_arguments = 1
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        return [netcdf(ROOT / self.arguments[0])]


def netcdf(path: Path) -> nodes.Node:
    """Coordinates and variables of a file with their dimensions."""
    with xr.open_dataset(path, engine="h5netcdf") as data:
        size = {dim: f"{dim} ({count})" for dim, count in data.sizes.items()}
        rows = [
            (f"`{name}`", " x ".join(size[d] for d in one.dims), str(one.dtype), one.attrs.get("units", ""))
            for name, one in data.variables.items()
        ]
        rows += [(f"`{name}`", "attribute", type(value).__name__, "") for name, value in data.attrs.items()]
    return table(("name", "over", "type", "unit"), rows)


def _tables(kind: type, path: str, seen: set[type]) -> Iterator[nodes.Node]:
    """A table of a dataclass's options, then those of the tables in it, each once."""
    seen.add(kind)
    inner: list[tuple[type, str]] = []
    rows = []
    for name, one in settings(kind).items():
        rows.append((f"`{name}`", _unit(one), ", ".join(_rules(one)), _default(one), _help(one)))
        inner += [(each, name) for each in _parts(one.kind) if each not in seen]
    yield paragraph(f"{f'`{path}`: ' if path else ''}{_first_of(kind)}")
    yield table(("key", "unit", "must be", "unless given", "what it is"), rows)
    for each, name in inner:
        if each not in seen:
            yield from _tables(each, f"{path}.{name}".strip("."), seen)


def _parts(kind: Any) -> Iterator[type]:
    """Dataclasses with options in a type."""
    if is_dataclass(kind) and isinstance(kind, type):
        if any(OPTION in each.metadata for each in fields(kind)):
            yield kind
        return
    for each in get_args(kind):
        yield from _parts(each)


def _unit(one: Setting) -> str:
    return f"`{one.option.unit}`" if one.option.unit else ""


def _rules(one: Setting) -> list[str]:
    """What a value must be, in words."""
    words = [" or ".join(f"`{choice}`" for choice in one.choices)] if one.choices else []
    fewest = [f"at least {one.option.fewest} of them"] if one.option.fewest else []
    return [*words, *rules_of(one.option), *fewest]


def _default(one: Setting) -> str:
    """What holds where a file leaves it out."""
    if one.default is MISSING:
        return "must be given"
    named = {value: word for word, value in one.option.words.items()}
    if isinstance(one.default, float) and one.default in named:
        return f"`{named[one.default]}`"
    if one.default is None or one.default == () or is_dataclass(one.default):
        return "none" if not is_dataclass(one.default) else "as below"
    if isinstance(one.default, bool):
        return f"`{str(one.default).lower()}`"
    return f"`{one.default:g}`" if isinstance(one.default, float) else f"`{one.default}`"


def _help(one: Setting) -> str:
    return one.option.help[:1].upper() + one.option.help[1:]


def _first_of(kind: type) -> str:
    """First paragraph of a class's docstring."""
    return " ".join((inspect.getdoc(kind) or "").partition("\n\n")[0].split())


def _first(part: dict[str, Any]) -> str:
    """First paragraph of what a schema says of itself."""
    return " ".join(part.get("description", "").partition("\n\n")[0].split())


def _keys(name: str, parts: dict[str, Any], path: str) -> Iterator[tuple[str, str, str, str]]:
    """Rows of a part's keys, those of the parts in it after each."""
    part = parts[name]
    about = entries(part.get("description", ""))
    for key, each in part.get("properties", {}).items():
        where = f"{path}{key}"
        inner = _reference(each)
        said = about.get(key) or (_first(parts[inner[0]]) if inner else "")
        usual = (
            "must be given" if key in part.get("required", ()) else f"`{json.dumps(each.get('default', {}))}`"
        )
        if inner:
            many = MANY if inner[1] else ""
            yield f"`{where}{many}`", "table" if not many else "list of tables", usual, said
            yield from _keys(inner[0], parts, f"{where}{many}.")
        else:
            yield f"`{where}`", _type(each), usual, said


def _reference(each: dict[str, Any]) -> tuple[str, bool] | None:
    """Name of the part that a key has, and whether it has many."""
    if "$ref" in each:
        return each["$ref"], False
    if "$ref" in each.get("items", {}) if isinstance(each.get("items"), dict) else False:
        return each["items"]["$ref"], True
    return None


def _type(each: dict[str, Any]) -> str:
    """A type in words."""
    if "enum" in each:
        return " or ".join(f"`{word}`" for word in each["enum"])
    if "anyOf" in each:
        return " or ".join(dict.fromkeys(_type(one) for one in each["anyOf"]))
    if "prefixItems" in each:
        return f"{len(each['prefixItems'])} of {_type(each['prefixItems'][0])}"
    simple = {None: "anything", "null": "`null`"}
    known = each.get("type")
    many = {"array": ("list of {}", "items"), "object": ("{} by name", "additionalProperties")}
    if known in many:
        words, inside = many[known]
        of = each.get(inside)
        return (
            words.format(_type(of)) if isinstance(of, dict) else {"array": "list", "object": "table"}[known]
        )
    return simple.get(known, str(known))


def entries(docstring: str) -> dict[str, str]:
    """What a docstring says of each field, as a section of numpydoc or by `name : words`, `name: words;`."""
    found: dict[str, str] = {}
    lines = inspect.cleandoc(docstring).splitlines()
    for line, after in zip(lines, [*lines[1:], ""], strict=True):
        mark = NAMES.fullmatch(line)
        if mark and after.startswith(" "):
            start = lines.index(line) + 1
            words = " ".join(w.strip() for w in takewhile(lambda each: each.startswith(" "), lines[start:]))
            found |= dict.fromkeys(mark["names"].split(", "), words.rstrip("."))
    if found:
        return found
    text = " ".join(docstring.split())
    marks = list(ENTRY.finditer(text))
    for mark, following in zip_longest(marks, marks[1:]):
        words = text[mark.end() : following.start() if following else len(text)]
        words = words.partition(" Raises ")[0].rstrip(" ;.")
        found |= dict.fromkeys(mark["names"].split(", "), words)
    return found


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives."""
    app.add_directive("stated", StatedDirective)
    app.add_directive("schema", SchemaDirective)
    app.add_directive("netcdf", NetcdfDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
