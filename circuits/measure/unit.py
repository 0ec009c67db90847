"""Units of what is measured: powers of volt, ampere, second and of what an axis can count.

A unit is derived, never asked for: a crossing has that of the axis, an integral over time that of its
waveform times a second, a quotient the quotient. Those that have a name are written by it, as J for V A s.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.units import format_quantity, parse_quantity

_BASES = ("V", "A", "s", "degC", "dB", "deg")
_NAMED: dict[tuple[int, ...], str] = {
    (1, 1, 0): "W", (1, 1, 1): "J", (0, 1, 1): "C", (-1, 1, 1): "F", (1, -1, 0): "Ohm", (-1, 1, 0): "S",
    (0, 0, -1): "Hz", (1, 0, 1): "V*s",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as powers of the base units, in the order of V, A, s, degC, dB and deg."""

    powers: tuple[int, ...] = (0,) * len(_BASES)

    def __mul__(self, other: Unit) -> Unit:
        return Unit(tuple(a + b for a, b in zip(self.powers, other.powers, strict=True)))

    def __truediv__(self, other: Unit) -> Unit:
        return self * other**-1

    def __pow__(self, exponent: int) -> Unit:
        return Unit(tuple(exponent * a for a in self.powers))

    def root(self) -> Unit | None:
        """The unit of a square root; None where a power is odd."""
        return None if any(a % 2 for a in self.powers) else Unit(tuple(a // 2 for a in self.powers))

    def __str__(self) -> str:
        named = _NAMED.get(self.powers[:3])
        if named is not None and not any(self.powers[3:]):
            return named
        above, below = (
            "*".join(
                base + (f"^{sign * p}" if sign * p > 1 else "")
                for base, p in zip(_BASES, self.powers, strict=True)
                if sign * p > 0
            )
            for sign in (1, -1)
        )
        return above if not below else f"{above or '1'}/{below}"


PLAIN = Unit()
VOLT, AMPERE, SECOND, CELSIUS, DECIBEL, DEGREE = (
    Unit(tuple(int(k == own) for k in range(len(_BASES)))) for own in range(len(_BASES))
)
_BY_NAME = {
    **{base: Unit(tuple(int(b == base) for b in _BASES)) for base in _BASES},
    **{name: Unit((*powers, 0, 0, 0)) for powers, name in _NAMED.items()},
}
_SUFFIXES = sorted((name for name in _BY_NAME if name.isalpha()), key=len, reverse=True)


def unit_named(name: str) -> Unit:
    """The unit of a name as `V` or `Hz`; empty for a plain number."""
    return _BY_NAME[name] if name else PLAIN


def read_number(text: str) -> tuple[float, Unit]:
    """Value in SI units and unit of a number with a prefix and unit, as `1.2ms`, or without, as `10k`.

    Raises `ParameterError` for a text with another unit, or one that can be read in two ways.
    """
    for name in _SUFFIXES:
        if text.endswith(name) and len(text) > len(name):
            return parse_quantity(text, name, "number"), _BY_NAME[name]
    return parse_quantity(text, "", "number"), PLAIN


def value_text(value: float, unit: Unit | str) -> str:
    """A value in SI units for a reader, as `1.2ms`; a unit without a name of its own stands behind it."""
    name = str(unit)
    if name.isalpha() or not name:
        return format_quantity(value, name)
    return f"{value:.6g} {name}"
