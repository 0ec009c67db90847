"""A card: one statement of a netlist with its continuation lines joined, and where it stands.

Words. A card falls into words at blanks and commas; `( ) =` are words by themselves, `{...}` and quoted texts
are one word each. Case does not count.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from circuits.errors import DataError


class ForeignError(DataError):
    """A card that ngspice may run, and that no circuit of ours can hold."""


_WORD = re.compile(r"""\{[^{}]*\}|'[^']*'|"[^"]*"|[()=]|[^\s(){}'"=,]+|[{}'"]""")
_SHOWN = 60  # characters of a user's text in an error


@dataclass(frozen=True, slots=True)
class Card:
    """Text of a card, and the file and line (from 1) where it begins."""

    text: str
    file: str
    line: int

    @property
    def place(self) -> str:
        """`file:line`."""
        return f"{self.file}:{self.line}"

    def error(self, text: str) -> DataError:
        """Error with the place in front of `text`."""
        return DataError(f"{self.place}: {text}")

    def foreign(self, text: str) -> ForeignError:
        """Error for what ngspice may run though no circuit of ours holds it, with the place before `text`."""
        return ForeignError(f"{self.place}: {text}")

    def name(self) -> str:
        """First word in lower case; empty for a card of commas alone."""
        found = _WORD.search(self.text)
        return found.group().lower() if found else ""

    def words(self) -> list[str]:
        """Words in lower case; raises `DataError` for a bracket or quote without its other half."""
        words = _WORD.findall(self.text.lower())
        for word in words:
            if len(word) == 1 and word in "{}'\"":
                raise self.error(f"{word} without its other half; close it on the same card")
        return words

    def check_name(self, name: str, most: int) -> None:
        """Raise `DataError` for a name of more than `most` characters."""
        if len(name) > most:
            raise self.error(f"a name of more than {most} characters, the limit; shorten it")


@dataclass(slots=True)
class Arguments:
    """Words of a card apart: `positional`, then `named` values in `name = value`; brackets drop out."""

    positional: list[str] = field(default_factory=list)
    named: dict[str, str] = field(default_factory=dict)


def arguments(card: Card, words: Sequence[str]) -> Arguments:
    """Part words into positional and named ones; raises `DataError` for a name without its value."""
    if "=" not in words:
        return Arguments([w for w in words if w not in {"(", ")"}])
    found = Arguments()
    kept = [w for w in words if w not in {"(", ")"}]
    k = 0
    while k < len(kept):
        if kept[k] == "=":
            raise card.error(f"= after {shown(kept[k - 1]) if k else 'nothing'}; write name=value")
        if k + 1 < len(kept) and kept[k + 1] == "=":
            k = _named(card, kept, k, found.named)
        else:
            found.positional.append(kept[k])
            k += 1
    return found


def element_words(card: Card) -> list[str]:
    """Words of an element, its name first; raises `DataError` for a card `name = value`."""
    words = card.words()
    if words[1:2] == ["="]:
        raise card.error(f"{shown(words[0])}=: no element; write its nodes first, or .param for a parameter")
    return words


def element_arguments(card: Card) -> tuple[str, Arguments]:
    """Name of an element, and the words behind it apart."""
    name, *words = element_words(card)
    return name, arguments(card, words)


def shown(text: str) -> str:
    """A user's text for an error: one line, printable, cut to 60 characters."""
    if len(text) <= _SHOWN and text.isprintable():
        return text
    plain = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text[: _SHOWN + 1])
    return plain if len(plain) <= _SHOWN else plain[:_SHOWN] + "..."


def _named(card: Card, words: list[str], k: int, named: dict[str, str]) -> int:
    """Take `name = value` at `k`; returns the position behind it."""
    name = words[k]
    if k + 2 >= len(words) or words[k + 2] == "=":
        raise card.error(
            f"{shown(name)}=: no value; write {shown(name)}=number, or braces around an expression"
        )
    if name in named:
        raise card.error(f"{shown(name)}: given twice; keep one")
    named[name] = words[k + 2]
    return k + 3
