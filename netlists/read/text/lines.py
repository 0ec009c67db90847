"""The first step of reading a netlist: its lines become cards.

A card is one statement of a netlist, such as an element or a `.param`. Comments are dropped, a line that
continues the one before it is joined to it, and an included file stands where it was included.

Files. `.include FILE` and `.lib FILE SECTION` name files relative to the one they stand in. Links are
resolved before a file is opened. A file that then lies outside the root folder is refused, and so is a file
that includes itself.

Lines. The first line of the outermost file is the title, whatever it says. `*` begins a line of comment; `
;`, ` $ ` and ` //` make the rest of a line a comment; `+` continues a card. Lines that begin with `*%` are
cards: they carry what SPICE cannot say (`netlists.write.annotation`). `.end` ends a file. What stands between
`.control` and `.endc` would be run by a simulator, and is left out, but for its analyses: a command `tran 1u
1m` is the card `.tran 1u 1m`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from circuits.errors import DataError
from netlists.read.card import Card, ForeignError, shown
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.text.files import Files, contents, count, inside, root_folder

ANNOTATION = "*%"
_SPECTRE = re.compile(r"^\s*simulator\s+lang\s*=\s*spectre\b", re.IGNORECASE | re.MULTILINE)
_VERILOG = re.compile(r"^\s*(`include\b|module\b)", re.MULTILINE)
_HEAD = 2000  # characters in which a netlist shows its language
_COMMENT = re.compile(r";|(?:^|\s)\$(?=\s|$)|(?:^|\s)//")
_ALTER = {"alter", "altermod", "alterparam"}  # commands that make another circuit of it
_ANALYSES = {"tran", "op", "dc", "ac", "noise"}  # commands that are the cards of the same name
_OF_A_SCRIPT = re.compile(r"[$<>@;\[\]]")  # what a card has not, such as a script's variable
_FILE = re.compile(r"""(?:"([^"]*)"|'([^']*)'|(\S+))""")

Language = Literal["spice", "spectre", "verilog-a"]
ReadLine = Callable[[str], tuple[str, str]]


@dataclass(slots=True)
class Text:
    """A netlist as its first reader leaves it.

    Attributes
    ----------
    title : str
        The first line.
    cards : list of Card
        The statements in order, those of included files where they were included.
    files : tuple of str
        Names of the files that were read, in order; empty for a text without a file.
    language : str
        `spice`, `spectre` or `verilog-a`, as told from the first lines.
    """

    title: str
    cards: list[Card]
    files: tuple[str, ...]
    language: Language = "spice"


def read_text(
    source: Path | str, root: Path | None, limits: Limits, notes: Notes, *, has_title: bool = True
) -> Text:
    """Read a netlist from a file, or from a text without a file name.

    Parameters
    ----------
    source
        The file's path, or the text itself.
    root
        Folder that included files must lie in. Unless given it is the file's own; a text then includes none.
    limits
        How much may be read.
    notes
        What the reader has to tell; it is added to.
    has_title
        Whether the first line is a title, which no one reads, as in SPICE.

    Raises
    ------
    DataError
        What cannot be read, with its file and line.
    """
    if isinstance(source, Path):
        folder = root_folder(source.parent if root is None else root)
        files, name = Files(folder, limits, notes), source.name
        path = inside(source, folder, name)
        files.open.append((path, ""))
        text = contents(files, path)
    else:
        files, name, text = (
            Files(None if root is None else root_folder(root), limits, notes),
            "netlist",
            source,
        )
        count(files, text, name)
    language = _language(text[:_HEAD])
    if language != "spice":
        own = joined(text, name, 1, limits.card, _READ_LINE[language])
        return Text(text.partition("\n")[0].strip(), list(own), tuple(files.names), language)
    title, _, rest = text.partition("\n") if has_title else ("", "", text)
    if re.match(r"\s*\.[a-z]", title, re.IGNORECASE):
        notes.add("first line is the title and was not read, though it looks like a card", f"{name}:1")
    cards = list(_cards(files, rest, name, 2 if has_title else 1))
    return Text(title.strip(), cards, tuple(files.names))


def _language(head: str) -> Language:
    if _SPECTRE.search(head):
        return "spectre"
    return "verilog-a" if _VERILOG.search(head) else "spice"


def _cards(files: Files, text: str, name: str, first: int, wanted: str = "") -> Iterator[Card]:
    """Cards of one file and of those that it includes; of a library those of the section `wanted`."""
    cards = _outside_control(files, joined(text, name, first, files.limits.card))
    for card in _of_section(files, cards, wanted):
        if card.text[0] != ".":
            yield card
            continue
        word = card.text.split(maxsplit=1)[0].lower()
        if word == ".end":
            files.notes.add("card after .end", card.place, sum(1 for _ in cards))
            return
        if word.startswith((".inc", ".lib")):
            yield from _included(files, card)
        else:
            yield card


def _of_section(files: Files, cards: Iterator[Card], wanted: str) -> Iterator[Card]:
    """Cards outside all sections `.lib NAME` to `.endl`, or those inside the one that is `wanted`."""
    here: Card | None = None
    is_read = not wanted
    for card in cards:
        words = card.text.lower().split(maxsplit=2) if card.text[0] == "." else [""]
        if words[0] == ".lib" and len(words) == 2:
            here, is_read = card, words[1].strip("'\"") == wanted
            if is_read:
                files.sections.add(files.open[-1])
        elif words[0] == ".endl":
            here, is_read = None, not wanted
        elif is_read:
            yield card
        elif not wanted:
            files.notes.add("card of a library's section that is not asked for", card.place)
    if here is not None:
        raise here.error(".lib with one word opens a section, and there is no .endl; write .include FILE")


def joined(text: str, name: str, first: int, most: int, read: ReadLine | None = None) -> Iterator[Card]:
    """Yield the cards of one text, with the lines that continue a card joined to it.

    Parameters
    ----------
    text
        The text.
    name, first
        The file's name and the number of the text's first line, which the cards keep for error texts.
    most
        Characters that a card may have at most.
    read
        What tells a line's kind; `spice_line` unless given.

    Raises
    ------
    DataError
        A line continues nothing, or a card is too long.
    """
    read = spice_line if read is None else read
    parts: list[str] = []
    begin = size = 0
    goes_on = False  # after a line that ends with two backslashes, the next one whatever it begins with
    for number, raw in enumerate(text.split("\n"), first):
        mark, line = ("+", raw.strip()) if goes_on else read(raw)
        if not mark:
            continue
        glued, goes_on = goes_on, line.endswith("\\\\")
        line = line[:-2] if goes_on else line
        if mark == " ":
            if parts:
                yield Card("".join(parts), name, begin)
            parts, begin, size = [line], number, len(line)
            continue
        if not parts or (mark == "%") != parts[0].startswith(ANNOTATION):
            raise DataError(f"{name}:{number}: + continues nothing; put a card before it")
        size += len(line) + 1
        if size > most:
            raise DataError(f"{name}:{begin}: more than {most} characters, a card's limit; split it")
        parts += [line] if glued else [" ", line]
    if parts:
        yield Card("".join(parts), name, begin)


def spice_line(raw: str) -> tuple[str, str]:
    """Tell what kind of line `raw` is in SPICE, and return the kind with the line's text.

    The kind is one character: a space for a new card, `+` for more of a card, `%` for more of a `*%` card. It
    is empty for a line that says nothing, such as a comment.
    """
    line = raw.strip()
    if not line:
        return "", ""
    if line[0] == "*":
        if line.startswith("*%+"):
            return "%", line[3:].strip()
        return " " if line.startswith(ANNOTATION) else "", line
    if ";" in line or "$" in line or "//" in line:
        line = _COMMENT.split(line, maxsplit=1)[0].rstrip()
    if line.startswith("+"):
        return "+", line[1:].strip()
    return " " if line else "", line


def spectre_line(raw: str) -> tuple[str, str]:
    """Tell what kind of line `raw` is in Spectre, as `spice_line` does for SPICE.

    Spectre's comments begin with `//`, and one that begins with `//%` becomes a `*%` card.
    """
    line = raw.strip()
    if line.startswith("//%+"):
        return "%", line[4:].strip()
    if line.startswith("//%"):
        return " ", ANNOTATION + line[3:]
    if not line or line.startswith(("//", "*")):
        return "", ""
    return ("+", line[1:].strip()) if line[0] == "+" else (" ", line)


def verilog_line(raw: str) -> tuple[str, str]:
    """Tell what kind of line `raw` is in Verilog-A, as `spice_line` does for SPICE.

    Every line that is no comment is a card as it stands.
    """
    line = raw.strip()
    if line.startswith("//"):
        return spectre_line(raw)
    return (" ", line) if line else ("", "")


_READ_LINE: dict[Language, ReadLine] = {
    "spice": spice_line,
    "spectre": spectre_line,
    "verilog-a": verilog_line,
}


def _outside_control(files: Files, cards: Iterator[Card]) -> Iterator[Card]:
    for card in cards:
        if card.text[:8].lower() != ".control":
            yield card
            continue
        skipped = 0
        for inner in cards:
            if inner.text[:5].lower() == ".endc":
                break
            word = inner.name()
            if word in _ALTER:
                _altered(files.notes, inner, word)
            if word in _ANALYSES and not _OF_A_SCRIPT.search(inner.text):
                yield Card(f".{inner.text}", inner.file, inner.line)
                continue
            skipped += 1
        else:
            raise card.error(".control without .endc; close it")
        files.notes.add("command between .control and .endc, never run", card.place, skipped)


def _altered(notes: Notes, card: Card, word: str) -> None:
    try:
        notes.leave_out(card, word, word, "write the value into the netlist")
    except ForeignError as error:
        notes.keep(card, error)


def _included(files: Files, card: Card) -> Iterator[Card]:
    word, _, rest = card.text.partition(" ")
    is_library = word.lower() == ".lib"
    if word.lower() not in {".inc", ".incl", ".include", ".lib"}:
        raise card.error(f"{shown(word)}: unknown card; write .include FILE or .lib FILE SECTION")
    names = [next(filter(None, groups), "") for groups in _FILE.findall(rest)]
    if not names or not names[0] or len(names) > 1 + is_library:
        raise card.error(f"{shown(rest) or 'nothing'}: must be one file; write {shown(word)} FILE")
    yield from _file_cards(files, card, names[0], names[1].lower() if len(names) == 2 else "")


def _file_cards(files: Files, card: Card, name: str, section: str) -> Iterator[Card]:
    if files.root is None:
        raise card.error(f"{shown(name)}: a text without a root folder includes no files; give the root")
    folder = files.open[-1][0].parent if files.open else files.root
    path = inside(folder / name, files.root, name, card.place)
    if (path, section) in files.open:
        raise card.error(f"{shown(name)}: a cycle of includes; remove one of them")
    if len(files.open) > files.limits.include_depth:
        raise card.error(f"files inside files deeper than {files.limits.include_depth}, the limit; join some")
    text = contents(files, path, card.place)
    files.open.append((path, section))
    yield from _cards(files, text, path.name, 1, section)
    here = files.open.pop()
    if section and here not in files.sections:
        raise card.error(f"section {shown(section)}: not in the file; name one of its .lib sections")
