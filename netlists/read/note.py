"""Notes: what a netlist says that its circuit and testbench do not carry, counted, with its place.

What changes no circuit (`.print`, an AC value) is noted. What would change it, and cannot be honoured, is
refused unless the user said by name that it may go; then it is told among what was dropped. Where the netlist
is read to be looked at or run in ngspice, it is kept as text instead, as a card for ngspice only.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from netlists.read.card import Card, ForeignError, shown


@dataclass(frozen=True, slots=True)
class Note:
    """`count` times `what`, first at `place` (`file:line`)."""

    what: str
    place: str
    count: int = 1

    def __str__(self) -> str:
        times = f" ({self.count} times)" if self.count > 1 else ""
        return f"{self.place}: {self.what}{times}"


@dataclass(frozen=True, slots=True)
class Foreign:
    """A card for ngspice only.

    text
        The card as it stands, its continuations joined.
    place
        Its `file:line`.
    reason
        Why no circuit of ours holds it, and what to do.
    """

    text: str
    place: str
    reason: str


@dataclass(slots=True)
class Notes:
    """Collects notes, equal ones together; `drop`: names, in lower case, of what may go.

    `keeps`: whether cards that only ngspice has are kept as text; they are refused otherwise.
    """

    drop: frozenset[str] = frozenset()
    keeps: bool = False
    found: dict[str, Note] = field(default_factory=dict)
    gone: dict[str, dict[str, None]] = field(default_factory=dict)  # places of what was dropped
    kept: dict[str, Foreign] = field(default_factory=dict)  # by place

    def add(self, what: str, place: str, count: int = 1) -> None:
        """Count `what` once more, or `count` times; none at all for a count of 0."""
        if count:
            old = self.found.get(what)
            self.found[what] = Note(what, old.place if old else place, count + (old.count if old else 0))

    def leave_out(self, card: Card, name: str, what: str, remedy: str, *, under: str = "") -> None:
        """Drop `what` if the user named it, as `name` or `under`; raises `DataError` otherwise."""
        if not self.drop & {name, under}:
            raise card.foreign(f"{what}: not honoured; {remedy}, or leave it out by `drop={shown(name)}`")
        self.gone.setdefault(what, {})[card.place] = None

    def keep(self, card: Card, error: ForeignError) -> None:
        """Keep a card for ngspice only; raises the error where such cards are refused."""
        if not self.keeps:
            raise error
        reason = str(error).removeprefix(f"{card.place}: ")
        self.kept.setdefault(card.place, Foreign(card.text, card.place, reason))

    def foreign(self) -> tuple[Foreign, ...]:
        """Return the cards for ngspice only in the order in which they were met."""
        return tuple(self.kept.values())

    def dropped(self) -> tuple[Note, ...]:
        """Return what was dropped, each place counted once."""
        return tuple(Note(what, next(iter(places)), len(places)) for what, places in self.gone.items())

    def all(self) -> tuple[Note, ...]:
        """Return all notes in the order in which they arose."""
        return tuple(self.found.values())


def drop_names(names: Iterable[str]) -> frozenset[str]:
    """Names of what may go: in lower case, and apart where commas join them."""
    return frozenset(part.strip().lower() for name in names for part in name.split(",") if part.strip())
