"""The second step of reading a netlist: its cards are sorted into sections.

A section is the top level or a sub-circuit (`.subckt`), with its elements, parameters and models. These cards
make and fill sections:

    .subckt NAME port ... [PARAMS:] [name=value ...]      .ends [NAME]
    .param name=value ...      .model NAME type [(name=value ...)]      .global node ...

A section may stand inside another one. What a section names is looked up in itself first, then in the section
around it, and so on outwards.
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
    """A `.model` card, which gives a name to a kind of device.

    Attributes
    ----------
    name : str
        The model's name, in lower case.
    type : str
        Kind of device, such as `nmos`.
    parameters : dict of str to str
        The card's parameters by name, as text.
    card : Card
        The card itself, for an error's place.
    """

    name: str
    type: str
    parameters: dict[str, str]
    card: Card


@dataclass(slots=True, eq=False)
class Section:
    """The top level of a netlist or one of its sub-circuits; all names are in lower case.

    Attributes
    ----------
    name : str
        Name of the sub-circuit; empty for the top level.
    card : Card
        The card that opened it.
    parent : Section or None
        The section around it; None for the top level.
    ports : tuple of str
        Names of its ports in order.
    defaults : dict of str to str
        Parameters of its `.subckt` card, as text.
    parameters : dict of str to (str, Card)
        Value, as text, and card of each `.param` in it.
    elements : list of Card
        Its devices, sources and calls, in order.
    models : dict of str to Model
        Its models by name.
    children : dict of str to Section
        The sub-circuits that are defined in it, by name.
    """

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
    """A whole netlist in sections.

    Attributes
    ----------
    top : Section
        The top level; the sub-circuits are its children, and theirs.
    size : int
        Number of cards.
    global_nodes : dict of str to None
        Nodes that `.global` cards name, in order.
    controls : list of Card
        Cards that belong to no section, such as `.tran`.
    """

    top: Section
    size: int  # cards
    global_nodes: dict[str, None] = field(default_factory=dict)
    controls: list[Card] = field(default_factory=list)


def read_deck(title: str, cards: Sequence[Card], notes: Notes) -> Deck:
    """Sort the cards of a netlist into sections.

    Parameters
    ----------
    title
        The netlist's first line.
    cards
        Its cards in order (`netlists.read.text.lines`).
    notes
        What the reader has to tell; it is added to.

    Raises
    ------
    DataError
        A section is not closed, a name is given twice, or a card would change the circuit and is not
        supported.
    """
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
    """Make the error for an element `name` of `card` whose name the element of card `other` has already."""
    return card.error(f"{shown(name)}: duplicate name, also at {other.place}; rename one")
