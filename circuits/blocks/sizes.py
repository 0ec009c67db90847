"""Sizes of a block: the numbers that its circuit is built of, checked once where they are given."""

from __future__ import annotations

from dataclasses import Field, dataclass, fields
from typing import Any

from circuits.checks import require_no_less, require_positive
from circuits.count import whole_number
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes and counts that a block is built of; it adds its own.

    Counts are the fields whose default is a whole number, sizes those whose default is another number. Raises
    `ParameterError` for a size that is not above zero, or is below what its field allows (`least` of
    `circuits.units.quantity`), and for a count that cannot be built.
    """

    def __post_init__(self) -> None:
        """Check all fields."""
        for each in fields(self):
            _check(self, each)

    def size(self, part: str) -> tuple[float, float]:
        """Width and length (um) of the transistors of a part: the fields `{part}_width`, `{part}_length`."""
        return getattr(self, f"{part}_width"), getattr(self, f"{part}_length")

    def sizes(self, *parts: str) -> tuple[tuple[float, float], ...]:
        """The `size` of each of several parts, um."""
        return tuple(map(self.size, parts))


def um(default: float, least: float | None = None) -> Any:
    """Make a field of `Sizes` that is a width or a length of transistors, in um.

    default, least : as of `circuits.units.quantity`, um.
    """
    return quantity(default, "um", least)


def _check(sizes: Sizes, each: Field[Any]) -> None:
    least = each.metadata.get("least")
    if isinstance(each.default, int):
        whole_number(each.name, getattr(sizes, each.name), 1 if least is None else least)
    elif isinstance(each.default, float) and least is not None:
        require_no_less(sizes, each.name, least=least)
    elif isinstance(each.default, float):
        require_positive(sizes, each.name)
