"""Notes: what a netlist says that its circuit and testbench do not carry, counted, with its place."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Note:
    """`count` times `what`, first at `place` (`file:line`)."""

    what: str
    place: str
    count: int = 1

    def __str__(self) -> str:
        times = f" ({self.count} times)" if self.count > 1 else ""
        return f"{self.place}: {self.what}{times}"


@dataclass(slots=True)
class Notes:
    """Collects notes, equal ones together."""

    found: dict[str, Note] = field(default_factory=dict)

    def add(self, what: str, place: str, count: int = 1) -> None:
        """Count `what` once more, or `count` times; none at all for a count of 0."""
        if count:
            old = self.found.get(what)
            self.found[what] = Note(what, old.place if old else place, count + (old.count if old else 0))

    def all(self) -> tuple[Note, ...]:
        """Return all notes in the order in which they arose."""
        return tuple(self.found.values())
