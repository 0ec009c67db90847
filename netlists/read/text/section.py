"""The second step of reading a netlist: its cards are sorted into sections.

A section is the top level or a sub-circuit (`.subckt`), with its elements, parameters and models. These cards
make and fill sections:

    .subckt NAME port ... [PARAMS:] [name=value ...]      .ends [NAME]
    .param name=value ...      .model NAME type [(name=value ...)]      .global node ...
    .func NAME(argument, ...) {expression}      .if (condition) / .elseif (condition) / .else / .endif

What stands under `.if` is kept with its conditions: an element is taken or left each time that its section is
elaborated, a declaration of the top level once the parameters there are known.

A section may stand inside another one. What a section names is looked up in itself first, then in the section
around it, and so on outwards.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest

from circuits.errors import DataError
from netlists.read.card import Card, arguments, shown
from netlists.read.expression.arithmetic import Function
from netlists.read.expression.scope import Condition
from netlists.read.note import Notes

_NESTING = 16  # sections inside sections, and .if inside .if
_VOLTAGES = {".ic", ".nodeset"}
_BRANCHES = {".if", ".elseif", ".else", ".endif"}
_ASSIGNED = re.compile(r"(?P<name>[^\s=,()]+)\s*=(?!=)")
_EQUAL = re.compile(r"(?<![<>=!])=(?!=)")  # which in a condition compares
_DEFINED = re.compile(r"\s*(?P<name>[a-z_]\w*)\s*\((?P<arguments>[^()]*)\)\s*=?\s*(?P<text>.*)")


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
    section : Section or None
        The section that it stands in, whose parameters its figures use; None outside a netlist.
    """

    name: str
    type: str
    parameters: dict[str, str]
    card: Card
    section: Section | None = None


Conditions = tuple[Condition, ...]


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
    bins : dict of str to Model
        The first of the models in bins (`name.1`), by the name that they share.
    conditions : dict of Card to tuple of Condition
        What must hold for an element under `.if`.
    children : dict of str to Section
        The sub-circuits that are defined in it, by name.
    voltages : list of Card
        The `.ic` and `.nodeset` cards of a sub-circuit, which hold for each call of it.
    """

    name: str
    card: Card
    parent: Section | None
    ports: tuple[str, ...] = ()
    defaults: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, tuple[str, Card]] = field(default_factory=dict)
    elements: list[Card] = field(default_factory=list)
    models: dict[str, Model] = field(default_factory=dict)
    bins: dict[str, Model] = field(default_factory=dict)
    conditions: dict[Card, Conditions] = field(default_factory=dict)
    children: dict[str, Section] = field(default_factory=dict)
    voltages: list[Card] = field(default_factory=list)

    def find_section(self, name: str) -> Section | None:
        """Return the sub-circuit of that name as seen from here, None where there is none."""
        return next((each.children[name] for each in self.outwards() if name in each.children), None)

    def find_model(self, name: str) -> Model | None:
        """Return the model of that name as seen from here, None where there is none.

        Of a model in bins, `name.1` and on, it is the first.
        """
        for each in self.outwards():
            found = each.models.get(name) or each.bins.get(name)
            if found is not None:
                return found
        return None

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
    functions : dict of str to Function
        The functions of `.func` cards by name.
    conditional : list of (Card, tuple of Condition)
        Declarations of the top level that stand under `.if`, in order.
    """

    top: Section
    size: int  # cards
    global_nodes: dict[str, None] = field(default_factory=dict)
    controls: list[Card] = field(default_factory=list)
    functions: dict[str, Function] = field(default_factory=dict)
    conditional: list[tuple[Card, Conditions]] = field(default_factory=list)


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
    branches: list[Conditions] = []  # of the .if cards that are open, each with its conditions so far
    for card in cards:
        word = card.text.split(maxsplit=1)[0].lower()
        if word in _BRANCHES:
            _branch(branches, card, word)
        elif card.text[0] != ".":
            here.elements.append(card)
            if branches:
                here.conditions[card] = tuple(c for each in branches for c in each)
        elif word == ".subckt":
            here = _open(here, card, card.words(), notes)
        elif word in {".ends", ".eom"}:
            here = _close(here, card, card.words(), notes)
        else:
            _declare_under(branches, deck, here, card, notes)
    if branches:
        raise branches[-1][0].card.error(".if without .endif; close it")
    if here.parent is not None:
        raise here.card.error(f".subckt {shown(here.name)}: not closed; write .ends")
    return deck


def sections(top: Section) -> Iterator[Section]:
    """Yield all sections below one, each before those inside it."""
    for section in top.children.values():
        yield section
        yield from sections(section)


def _declare_under(branches: list[Conditions], deck: Deck, here: Section, card: Card, notes: Notes) -> None:
    """Take a declaration, which waits for the parameters where it stands under `.if`."""
    if not branches:
        declare(deck, here, card, notes)
    elif here.parent is None:
        deck.conditional.append((card, tuple(c for each in branches for c in each)))
    else:
        raise card.error(f"{card.name()}: under .if in a sub-circuit; move it to the top level")


def declare(deck: Deck, here: Section, card: Card, notes: Notes) -> None:
    """Take a declaration into its section, or a card about the run into the deck.

    Raises `DataError` for a name that is given twice and for what is not supported.
    """
    word = card.name()
    if word in _DECLARATIONS:
        _DECLARATIONS[word](deck, here, card, card.words(), notes)
    elif word in _VOLTAGES and here.parent is not None:
        here.voltages.append(card)
    else:
        deck.controls.append(card)


def _branch(branches: list[Conditions], card: Card, word: str) -> None:
    """Open, turn or close an `.if`."""
    if word == ".if":
        if len(branches) == _NESTING:
            raise card.error(f".if: deeper than {_NESTING}, the limit; join the conditions")
        branches.append((_condition(card),))
        return
    if not branches:
        raise card.error(f"{word} without .if; remove it")
    done = branches.pop()
    if word == ".endif":
        return
    failed = (*done[:-1], replace(done[-1], holds=False))
    branches.append(failed if word == ".else" else (*failed, _condition(card)))


def _condition(card: Card) -> Condition:
    text = card.text.partition(" ")[2].strip().lower() or card.text[3:].strip().lower()
    if not text:
        raise card.error(f"{card.text}: no condition; write .if (expression)")
    return Condition(_EQUAL.sub("==", text), card)


def _open(here: Section, card: Card, words: list[str], notes: Notes) -> Section:
    given = arguments(card, [w for w in _without_optional(words[1:]) if w not in {"params:", "params"}])
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


def _without_optional(words: list[str]) -> list[str]:
    """Words of a sub-circuit without PSpice's optional nodes, between `optional:` and `params:`."""
    if "optional:" not in words:
        return words
    first = words.index("optional:")
    last = words.index("params:") if "params:" in words[first:] else len(words)
    return words[:first] + words[last:]


def _close(here: Section, card: Card, words: list[str], notes: Notes) -> Section:
    if here.parent is None:
        raise card.error(".ends without .subckt; remove it")
    if len(words) > 1 and words[1] != here.name:
        notes.add(f".ends {shown(words[1])} closes {shown(here.name)}", card.place)
    return here.parent


def _parameters(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    text = card.text.lower().partition(" ")[2]
    if _DEFINED.match(text):
        _function(deck, here, card, words, notes)
        return
    starts = list(_ASSIGNED.finditer(_hidden(text)))
    if not starts or text[: starts[0].start()].strip(" ,\t"):
        word = shown(text.split()[0]) if text.split() else "nothing"
        raise card.error(f".param {word}: must be name=value")
    for found, after in zip_longest(starts, starts[1:]):
        name, value = found["name"], text[found.end() : after.start() if after else None].strip(" ,\t")
        if not value:
            raise card.error(f".param {shown(name)}=: no value; write {shown(name)}=number")
        if name in here.parameters:
            place = here.parameters[name][1].place
            notes.add(f".param {shown(name)} given twice, of which the last counts", place)
        here.parameters[name] = (value, card)


def _hidden(text: str) -> str:
    """The text with what stands in braces, quotes and brackets blanked, of the same length."""
    depth, quote, kept = 0, "", []
    for c in text:
        is_quote = c in "'\"" and quote in {"", c}
        quote = ("" if quote else c) if is_quote else quote
        depth += (c in "{(") - (c in "})") if not quote else 0
        kept.append(" " if depth > 0 or quote or is_quote or c in "})" else c)
    return "".join(kept)


def _function(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    found = _DEFINED.match(card.text.lower().partition(" ")[2])
    if found is None or not found["text"].strip():
        raise card.error(".func: must be NAME(argument, ...) and its value; write .func f(x) {2*x}")
    names = tuple(n.strip() for n in found["arguments"].split(",") if n.strip())
    made = Function(names, found["text"].strip())
    if deck.functions.setdefault(found["name"], made) != made:
        raise card.error(f".func {shown(found['name'])}: given twice, and not alike; rename one")


def _model(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    plain = [w for w in words[1:] if w not in {"(", ")"}]
    if len(plain) < 2 or "=" in plain[:2]:
        raise card.error(".model: no name or no type; write .model NAME nmos (name=value ...)")
    name, kind = plain[:2]
    if name in here.models:
        place = here.models[name].card.place
        notes.keep(card, card.foreign(f".model {shown(name)}: duplicate name, also at {place}; rename one"))
        return
    given = {plain[k - 1]: plain[k + 1] for k in range(3, len(plain) - 1) if plain[k] == "="}
    here.models[name] = Model(name, kind, given or dict.fromkeys(plain[2:], ""), card, here)
    shared, _, number = name.rpartition(".")
    if shared and number.isdigit():
        here.bins.setdefault(shared, here.models[name])


def _global(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    deck.global_nodes |= dict.fromkeys(words[1:])


def _unsupported(deck: Deck, here: Section, card: Card, words: list[str], notes: Notes) -> None:
    raise card.error(f"{words[0]}: not supported, it would change what is read; write the netlist without it")


_Declaration = Callable[[Deck, Section, Card, list[str], Notes], None]
_DECLARATIONS: dict[str, _Declaration] = {
    ".param": _parameters, ".params": _parameters, ".parameter": _parameters, ".model": _model,
    ".global": _global, ".func": _function, ".alter": _unsupported, ".macro": _unsupported,
    ".connect": _unsupported, ".del": _unsupported,
}  # fmt: skip


def duplicate(card: Card, name: str, other: Card) -> DataError:
    """Make the error for an element `name` of `card` whose name the element of card `other` has already."""
    return card.error(f"{shown(name)}: duplicate name, also at {other.place}; rename one")
