"""Cards -> sections: the top level and each `.subckt`, with its elements, parameters and models.

    .subckt NAME port ... [PARAMS:] [name=value ...]      .ends [NAME]
    .param name=value ...      .model NAME type [(name=value ...)]      .global node ...

Sections may stand in one another; a name is looked up from the inside out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from circuits.errors import DataError
from netlists.read.card import Card, arguments, shown
from netlists.read.note import Notes

_NESTING = 16  # sections inside sections


@dataclass(frozen=True, slots=True)
class Model:
    """A `.model` card: its type (`nmos`) and its parameters as written."""

    name: str
    type: str
    parameters: dict[str, str]
    card: Card


@dataclass(slots=True, eq=False)
class Section:
    """The top level (no parent) or a sub-circuit, everything in lower case."""

    name: str
    card: Card
    parent: Section | None
    ports: tuple[str, ...] = ()
    defaults: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, tuple[str, Card]] = field(default_factory=dict)
    elements: list[Card] = field(default_factory=list)
    models: dict[str, Model] = field(default_factory=dict)
    children: dict[str, Section] = field(default_factory=dict)

    def find_section(self, name: str) -> Section | None:
        """Return the sub-circuit of that name as seen from here, None where there is none."""
        return next((each.children[name] for each in self.outwards() if name in each.children), None)

    def find_model(self, name: str) -> Model | None:
        """Return the model of that name as seen from here, None where there is none."""
        return next((each.models[name] for each in self.outwards() if name in each.models), None)

    def outwards(self) -> Iterator[Section]:
        """Yield this section and all that it stands in, from the inside out."""
        each: Section | None = self
        while each is not None:
            yield each
            each = each.parent


@dataclass(slots=True)
class Deck:
    """Sections of a netlist under its top level, global nodes, and the cards that are neither (`.tran`)."""

    top: Section
    size: int  # cards
    global_nodes: dict[str, None] = field(default_factory=dict)
    controls: list[Card] = field(default_factory=list)


def read_deck(title: str, cards: Sequence[Card], notes: Notes) -> Deck:
    """Sort cards into sections; raises `DataError` for a section that is not closed or a name given twice."""
    first = Card(title, "netlist", 1)
    deck = Deck(Section("", first, None), len(cards))
    here = deck.top
    for card in cards:
        if card.text[0] != ".":
            here.elements.append(card)
            continue
        words = card.words()
        if words[0] == ".subckt":
            here = _open(here, card, words)
        elif words[0] in {".ends", ".eom"}:
            here = _close(here, card, words)
        elif words[0] in _DECLARATIONS:
            _DECLARATIONS[words[0]](deck, here, card, words, notes)
        else:
            deck.controls.append(card)
    if here.parent is not None:
        raise here.card.error(f".subckt {shown(here.name)}: not closed; write .ends")
    return deck


def _open(here: Section, card: Card, words: list[str]) -> Section:
    given = arguments(card, [w for w in words[1:] if w not in {"params:", "params"}])
    if not given.positional:
        raise card.error(".subckt: no name; write .subckt NAME PORT ...")
    name, *ports = given.positional
    if name in here.children:
        other = here.children[name].card.place
        raise card.error(f".subckt {shown(name)}: duplicate name, also at {other}; rename one")
    twice = next((p for p, count in Counter(ports).items() if count > 1), None)
    if twice is not None:
        raise card.error(f".subckt {shown(name)}: port {shown(twice)} given twice; remove one")
    if sum(1 for _ in here.outwards()) > _NESTING:
        raise card.error(
            f".subckt {shown(name)}: deeper than {_NESTING} sub-circuits, the limit; move it out"
        )
    here.children[name] = Section(name, card, here, tuple(ports), given.named)
    return here.children[name]


def _close(here: Section, card: Card, words: list[str]) -> Section:
    if here.parent is None:
        raise card.error(".ends without .subckt; remove it")
    if len(words) > 1 and words[1] != here.name:
        raise card.error(
            f".ends {shown(words[1])}: closes {shown(here.name)}; write .ends {shown(here.name)}"
        )
    return here.parent


def _parameters(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    given = arguments(card, words[1:])
    if given.positional or not given.named:
        word = shown(given.positional[0]) if given.positional else "nothing"
        raise card.error(f".param {word}: must be name=value; put braces around an expression with blanks")
    for name, value in given.named.items():
        if name in here.parameters:
            other = here.parameters[name][1].place
            raise card.error(f".param {shown(name)}: given twice, also at {other}; keep one")
        here.parameters[name] = (value, card)


def _model(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    given = arguments(card, words[1:])
    if len(given.positional) < 2:
        raise card.error(".model: no name or no type; write .model NAME nmos (name=value ...)")
    name, kind = given.positional[:2]
    if name in here.models:
        raise card.error(
            f".model {shown(name)}: duplicate name, also at {here.models[name].card.place}; rename one"
        )
    here.models[name] = Model(name, kind, given.named, card)


def _global(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    deck.global_nodes |= dict.fromkeys(words[1:])


def _unsupported(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    raise card.error(f"{words[0]}: not supported, it would change what is read; write the netlist without it")


_Declaration = Callable[[Deck, Section, Card, list[str], Notes], None]
_DECLARATIONS: dict[str, _Declaration] = {
    ".param": _parameters, ".params": _parameters, ".parameter": _parameters, ".model": _model,
    ".global": _global, ".if": _unsupported, ".elseif": _unsupported, ".else": _unsupported,
    ".endif": _unsupported, ".alter": _unsupported, ".func": _unsupported, ".macro": _unsupported,
    ".lib": _unsupported, ".endl": _unsupported, ".connect": _unsupported, ".del": _unsupported,
}  # fmt: skip


def duplicate(card: Card, name: str, other: Card) -> DataError:
    """Error for an element whose name another one of its section has."""
    return card.error(f"{shown(name)}: duplicate name, also at {other.place}; rename one")
