"""The check that a netlist's lines are those that its notes write.

They are compared card after card; numbers may differ in their last digits.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from itertools import zip_longest

from circuits.errors import DataError
from netlists.read.card import Card, shown
from netlists.read.notes.syntax import Syntax
from netlists.read.number import NUMBER, number_value

TOLERANCE = 1e-9  # relative: another machine may round the last digits of a constant otherwise
_BEFORE = 20  # characters shown before the first that differs
_LITERAL = re.compile(rf"(?<![\w#.]){NUMBER.pattern}(?![\w#])", re.IGNORECASE)


def verify(cards: Sequence[Card], again: Iterable[Card], syntax: Syntax) -> None:
    """Hold `cards` against what writing them again gives; raises `DataError` where they differ."""
    own = [c for c in cards if not syntax.is_control(c)]
    written = [c for c in again if not syntax.is_control(c)]
    for card, expected in zip_longest(own, written):
        if card is None:
            raise own[-1].error(f"{shown(expected.text)}: missing behind this line; write the netlist again")
        if expected is None or not _alike(card.text, expected.text):
            raise _edited(card, expected)


def _edited(card: Card, expected: Card | None) -> DataError:
    remedy = "edit both, or remove the noctule note to read the netlist without notes"
    if expected is None:
        return card.error(f"{shown(card.text)}: added, its notes have nothing here; {remedy}")
    pairs = enumerate(zip_longest(card.text, expected.text))
    at = max(next((k for k, (a, b) in pairs if a != b), 0) - _BEFORE, 0)
    read, wanted = (shown(text[at:]) or "nothing" for text in (card.text, expected.text))
    return card.error(f"{shown(card.text.split()[0])}: edited, {read} is {wanted} by its notes; {remedy}")


def _alike(a: str, b: str) -> bool:
    if a == b or a.split() == b.split():
        return True
    a, b = " ".join(a.lower().split()), " ".join(b.lower().split())
    if a == b:
        return True
    if _LITERAL.sub("?", a) != _LITERAL.sub("?", b):
        return False
    pairs = zip(_LITERAL.finditer(a), _LITERAL.finditer(b), strict=True)
    return all(math.isclose(number_value(m), number_value(n), rel_tol=TOLERANCE) for m, n in pairs)
