"""Elements that ngspice has and no circuit of ours: they are named, checked a little, and kept as text.

A card of such an element must have its nodes, and where its kind goes by a model that model must be there
with a fitting type, so that a text that is no netlist, or a deck without one of its libraries, is refused in
one line.
"""

from __future__ import annotations

from dataclasses import dataclass

from netlists.read.card import Arguments, Card, ForeignError, element_words, shown
from netlists.read.text.section import Model, Section

REMEDY = "run the deck in ngspice"


@dataclass(frozen=True, slots=True)
class Kind:
    """An element of ngspice's.

    what
        What it is called.
    nodes
        How many words stand before its model, or must at least stand behind its name where it has none.
    types
        Types of its model: empty for an element without one, `*` for any type.
    """

    what: str
    nodes: int
    types: tuple[str, ...] = ()


KINDS = {
    "a": Kind("an XSPICE code model", 1, ("*",)),
    "d": Kind("a diode", 2, ("d", "numd", "numd2")),
    "e": Kind("a voltage source that another voltage controls", 3),
    "f": Kind("a current source that a current controls", 3),
    "h": Kind("a voltage source that a current controls", 3),
    "j": Kind("a junction field-effect transistor", 3, ("njf", "pjf")),
    "k": Kind("a coupling of inductors", 3),
    "l": Kind("an inductor", 3),
    "n": Kind("a device by a compiled or numerical model", 1, ("*",)),
    "o": Kind("a lossy line", 4, ("ltra",)),
    "p": Kind("coupled lines", 3, ("cpl",)),
    "q": Kind("a bipolar transistor", 3, ("npn", "pnp", "nbjt", "pbjt", "nbjt2", "pbjt2")),
    "s": Kind("a switch that a voltage controls", 4, ("sw", "vswitch", "aswitch")),
    "t": Kind("a line without loss", 5),
    "u": Kind("a distributed RC line, or a digital part", 3),
    "w": Kind("a switch that a current controls", 3, ("csw", "iswitch")),
    "y": Kind("a line with loss", 3, ("txl",)),
    "z": Kind("a MESFET", 3, ("nmf", "pmf", "nhfet", "phfet")),
}


def foreign_element(card: Card, section: Section, used: set[Card]) -> ForeignError:
    """Say why a card is for ngspice only; its model is added to `used`.

    Raises `DataError` for one that ngspice cannot have either.
    """
    name, *words = element_words(card) or [card.text.lower()]
    letter = name[0]
    kind = KINDS.get(letter)
    if kind is None:
        known = ", ".join(sorted({*KINDS, *"bcgimrvx"})).upper()
        raise card.error(f"{shown(name)}: unknown element; known are {known}")
    plain = [w for w in words if w not in {"(", ")", "[", "]", "="}]
    if len(plain) < kind.nodes + bool(kind.types):
        raise card.error(f"{shown(name)}: {len(plain)} words, {kind.what} has more; complete the card")
    if kind.types:
        used |= {model.card for model in _models(card, name, kind, plain, section)}
    return card.foreign(f"{shown(name)}: {kind.what}, which the native solver has not; {REMEDY}")


def foreign_transistor(card: Card, words: Arguments, section: Section) -> ForeignError:
    """Say why an M card of other than five words is for ngspice only.

    Raises `DataError` where none of its words is a model.
    """
    name = shown(card.words()[0])
    count = len(words.positional)
    if count < 4 or not any(section.find_model(w) for w in words.positional[3:]):
        raise card.error(f"{name}: {count} words, must be 4 nodes and a model; write M d g s b MODEL W= L=")
    return card.foreign(f"{name}: a transistor of {count - 1} nodes, must be 4 nodes and a model; {REMEDY}")


def _models(card: Card, name: str, kind: Kind, words: list[str], section: Section) -> list[Model]:
    """Models that a card names; raises `DataError` for none, or one of another type."""
    found = [m for m in map(section.find_model, words[kind.nodes :]) if m is not None]
    if not found:
        called = words[-1 if kind.types == ("*",) else kind.nodes]
        types = "" if kind.types == ("*",) else f" of type {' or '.join(kind.types[:2])}"
        raise card.error(f"{shown(name)}: model {shown(called)}: unknown; add its .model card{types}")
    if kind.types != ("*",) and not any(m.type in kind.types or m.type.startswith("ako") for m in found):
        raise card.error(
            f"{shown(name)}: model {shown(found[0].name)}: type {shown(found[0].type)}, must be"
            f" {' or '.join(kind.types[:2])}; see {found[0].card.place}"
        )
    return found
