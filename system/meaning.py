"""What a key of a JSON document means: its type, its unit and words, which stand in tables beside the code.

A table is a text with a line a key: the key, its type, its unit (`-` for none) and its words. A line that
begins with spaces goes on with the words of the one before it.

    calls         number   -  calls that were made
    first_call_s  number?  s  time of the first of them

A key within an object is told by its path, as `trips.cost`, whether the object stands in an array or not; `*`
stands for names that differ from run to run. A type is one of `KINDS`. `[]` behind it is an array of these,
`{}` an object of these by name, and `?` says that it may be null; `|` stands between two types of
which it has one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from typing import Any, Literal, final, get_args, get_origin

KINDS = ("any", "boolean", "integer", "number", "object", "string")
ANY_NAME = "*"
SUMMARY = "summary"  # key under which a run's document has its numbers
_LINE = re.compile(r"(?P<key>\S+) +(?P<kind>\S+) +(?P<unit>\S+) +(?P<words>\S.*)")
_TYPE = re.compile(rf"(?:{'|'.join(KINDS)})(?:\[\]|\{{\}}|\?)*")


@final
@dataclass(frozen=True, slots=True)
class Meaning:
    """What a key of a JSON document holds.

    kind : type of its value, as `number[]?`.
    unit : its unit as a user writes it; empty for a plain number and for what is none.
    words : what it is.
    """

    kind: str
    unit: str
    words: str


Meanings = Mapping[str, Meaning]


def meanings(table: str, within: str = "") -> dict[str, Meaning]:
    """Return the meanings of a table by their keys.

    Parameters
    ----------
    table
        The text, as above.
    within
        Path of the object in which all of its keys stand; empty for the document itself.

    Raises
    ------
    ValueError
        A line is none of a table, a type is unknown, or a key is told twice.
    """
    found: dict[str, Meaning] = {}
    for line in _joined(table):
        parts = _LINE.fullmatch(line)
        if parts is None:
            raise ValueError(f"{line!r}: must be a key, a type, a unit and words")
        key, unit = parts["key"], parts["unit"].removeprefix("-")
        if not all(_TYPE.fullmatch(each) for each in parts["kind"].split("|")):
            raise ValueError(f"{key}: type {parts['kind']}, must be of {', '.join(KINDS)}")
        path = f"{within}.{key}" if within else key
        if path in found:
            raise ValueError(f"{path}: told twice, must be once")
        found[path] = Meaning(parts["kind"], unit, parts["words"])
    return found


def of_run(numbers: Meanings, document: Meanings) -> dict[str, Meaning]:
    """Return the meanings of a run's own keys: its `numbers`, which the summary has, and its `document`."""
    return {**{f"{SUMMARY}.{name}": each for name, each in numbers.items()}, **document}


def numbers_of(told: Meanings) -> tuple[str, ...]:
    """Return the names of the numbers that stand in a run's summary, by its own meanings (`of_run`)."""
    names = (key.removeprefix(f"{SUMMARY}.") for key in told if key.startswith(f"{SUMMARY}."))
    return tuple(name for name in names if "." not in name)


def kind_of(hint: Any, *, nullable: bool) -> str:
    """Return the type in JSON of a field by its type in Python; `any` where JSON has it in another form."""
    null = "?" if nullable else ""
    if get_origin(hint) in (tuple, frozenset):
        return f"{kind_of(get_args(hint)[0], nullable=False)}[]{null}"
    if get_origin(hint) is Literal or is_dataclass(hint):  # what is a thing of its own is in words
        return f"string{null}"
    simple = {bool: "boolean", int: "integer", float: "number", str: "string"}
    return f"{simple[hint]}{null}" if hint in simple else "any"


def _joined(table: str) -> Iterator[str]:
    """Lines of a table, each with those that go on with it."""
    line = ""
    for each in table.strip("\n").splitlines():
        if each.startswith(" "):
            line += f" {each.strip()}"
        elif each:
            if line:
                yield line
            line = each
    if line:
        yield line
