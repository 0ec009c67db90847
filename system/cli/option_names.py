"""Translation of the names of fields in errors and lines into options of the command line.

Code below the command line names a field before the colon of an error (`ping_rate: 3 Hz, must be ...`), and
other fields between backquotes, alone or with a value (`` `cells=chip` ``). At the command line these become
`--ping-rate: ...` and `--cells chip`; names that are no option of the command stay as they are.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Mapping

PARAM = "--param "  # before a name of a study's system
_HEAD = re.compile(r"(?:[a-z0-9-]+\.scenario\.)?([a-z][a-z0-9_]*)(?=: )")
_QUOTED = re.compile(r"`([a-z][a-z0-9_]*)(?:=([^`]*))?`")


def as_options(text: str, options: Mapping[str, str]) -> str:
    """Replace the names of fields in a text by the options that set them.

    options: the option that stands for each field or parameter, by its name.
    """
    head = _HEAD.match(text)
    if head is not None and head[1] in options:
        text = options[head[1]] + text[head.end() :]

    def said(found: re.Match[str]) -> str:
        name, value = found[1], found[2]
        if name not in options:
            return found[0]
        if value in {None, "True"}:
            return options[name]
        return f"{options[name]}{'=' if options[name].startswith(PARAM) else ' '}{value}"

    return _QUOTED.sub(said, text)


def field_named(text: str) -> str:
    """Give the name of the field that an error names before its colon, empty where it names none."""
    head = _HEAD.match(text)
    return head[1] if head is not None else ""


def option_of(name: str) -> str:
    """Give the option that stands for the name of a field, as `--ping-rate` for `ping_rate`."""
    return f"--{name.replace('_', '-')}"


def words_of(options: Iterable[tuple[str, str]]) -> list[str]:
    """Give the words of a command line from pairs of the name of an option and its text."""
    return [word for name, text in options for word in (option_of(name), text)]


def replay_of(folder: str, options: Iterable[tuple[str, str]]) -> str:
    """Give the command that measures a sample of the study in `folder` again."""
    return shlex.join(["noctule", "replay", folder, *words_of(options)])
