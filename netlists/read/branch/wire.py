"""Sources of 0 V between two nodes, as decks have them to measure a current: in a circuit they are wires.

Both nodes become one, which has the name of a port where one of them is a port. A source between two ports,
or between a port and ground, is no wire that a circuit could have, and stays a source, as does one whose
current an F or H takes, or whose current or node a card `.measure` names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from netlists.read.card import Card, ForeignError, element_words
from netlists.read.expression.scope import Scope
from netlists.read.text.name import is_ground

_WAVEFORMS = {
    "pulse",
    "pwl",
    "sin",
    "sine",
    "exp",
    "sffm",
    "am",
    "trnoise",
    "trrandom",
    "external",
    "portnum",
}


def sensed(cards: Sequence[Card]) -> frozenset[str]:
    """Names of the sources of voltage among elements whose current an F or H among them takes."""
    taken: set[str] = set()
    for card in cards:
        words = element_words(card) if card.text[0] in "fFhH" else []
        taken.update(words[3:4])
    return frozenset(taken & {card.name() for card in cards if card.text[0] in "vV"})


def wires(
    cards: Sequence[Card],
    fixed: Sequence[str],
    scope: Scope,
    sources: frozenset[str] = frozenset(),
    nodes: frozenset[str] = frozenset(),
) -> tuple[dict[str, str], set[Card]]:
    """Names of nodes that are one by the node they become, and the cards that make them so.

    Parameters
    ----------
    cards
        Elements of a section.
    fixed
        Its ports and the global nodes, which keep their names.
    scope
        Parameters in reach.
    sources
        Names of sources that stay ones.
    nodes
        Names of nodes that stay ones.
    """
    parent: dict[str, str] = {}
    taken: set[Card] = set()
    kept = set(fixed)
    for card in cards:
        pair = None if card.name() in sources else _ends(card, scope)
        if pair is None:
            continue
        a, b = (_root(parent, node) for node in pair)
        if a == b or (a in kept and b in kept):
            continue
        a, b = (b, a) if b in kept or (b in nodes and a not in kept) else (a, b)
        if b in nodes:
            continue
        parent[b] = a
        taken.add(card)
    return {node: _root(parent, node) for node in parent}, taken


def _root(parent: Mapping[str, str], node: str) -> str:
    while node in parent:
        node = parent[node]
    return node


def _ends(card: Card, scope: Scope) -> tuple[str, str] | None:
    """Nodes of a floating source of 0 V; None for any other card."""
    if card.text[0] not in "vV":
        return None
    _, *words = element_words(card)
    nodes, values = words[:2], [w for w in words[2:] if w not in {"dc", "="}]
    if len(nodes) < 2 or any(is_ground(n) for n in nodes) or _WAVEFORMS & set(values):
        return None
    try:
        is_zero = not values or scope.number(card, "value", values[0]) == 0.0
    except ForeignError:
        return None
    return (nodes[0], nodes[1]) if is_zero and "ac" not in values else None
