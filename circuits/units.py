"""Quantities as text, at the edges: `"12ms"`, `"600fF"`, `"10MHz"`.

A text is a number, then at most one prefix, then the quantity's own unit, with nothing between:

    value = number x 10^exponent(prefix)

Before a unit a prefix is SI, and case counts: `1MHz` is 1e6 Hz, `1mHz` is 1e-3 Hz, a micro is `u` or its
sign. A prefix may stand alone (`600f` on a capacitance, `2k` on a plain number); there `Meg` in any case is
mega, and `M`, which is mega to SI and milli to SPICE, is refused. So are a number alone where there is a
unit, zero and degrees Celsius apart, and a bare `F`, which is femto to SPICE and farad to everyone else.
What netlists mean by the same letters is in `netlists.read.number`, and holds there only.

quantiphy was tried in its place: it takes `40V` for a current, `12min` as 12 thousandths of an "in", `1Meg`
as 1e6 of an "eg" and `3m` on a length as 3 mm, so that every check here would stay around it.
"""

from __future__ import annotations

import math
import re
from dataclasses import field
from decimal import Decimal
from typing import Any, NamedTuple

from circuits.errors import ParameterError

PREFIXES = {  # letter before a unit -> power of ten
    "a": -18, "f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9, "T": 12,
}  # fmt: skip
_SIGNS_OF_MICRO = str.maketrans("\u00b5\u03bc", "uu")  # the sign, and the Greek letter
_WRITTEN = {exponent: prefix for prefix, exponent in PREFIXES.items()}
_MEGA = "Meg"


class Unit(NamedTuple):
    """A unit of a quantity.

    noun : what has it, as an error says it.
    usual : the unit with the prefix that is usual here, empty where the number stands alone.
    """

    noun: str
    usual: str


UNITS = {  # every unit that an option's number may have; empty for a plain number
    "": Unit("a plain number", ""),
    "A": Unit("a current in A", "pA"),
    "F": Unit("a capacitance in F", "fF"),
    "Hz": Unit("a frequency in Hz", "Hz"),
    "K": Unit("a temperature in K", "K"),
    "Ohm": Unit("a resistance in Ohm", "kOhm"),
    "S": Unit("a conductance in S", "uS"),
    "V": Unit("a voltage in V", "V"),
    "W": Unit("a power in W", "mW"),
    "deg": Unit("an angle in deg", "deg"),
    "degC": Unit("a temperature in degC", ""),
    "lux": Unit("an illuminance in lux", "lux"),
    "m": Unit("a length in m", "m"),
    "m/s": Unit("a speed in m/s", "m/s"),
    "rad": Unit("an angle in rad", "rad"),
    "s": Unit("a time in s", "s"),
    "um": Unit("a length in m", "um"),
}
UNSCALED = frozenset({"deg", "degC"})  # nobody writes a millidegree
MAY_BE_BARE = frozenset({"", "degC"})  # a number without its unit has one reading
_IN_BASE = {"um": ("m", -6)}  # numbers kept in micrometre
_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[eE]([+-]?[0-9]{1,4}))?")
_SIGNIFICANT_DIGITS = 6


def quantity(default: Any, unit: str, least: float | None = None) -> Any:
    """Make a field of a dataclass whose number, or numbers, are in one unit.

    The unit stands in the field's metadata, where the edges look for it, and so does `least`, if there is
    one.

    Parameters
    ----------
    default
        Value of the field unless another is given.
    unit
        SI unit of the field; empty for a plain number.
    least
        The smallest number that a block takes (`circuits.blocks.sizes`), in that unit; unless given a size
        is above zero, and a count at least 1.
    """
    return field(default=default, metadata={"unit": unit} | ({} if least is None else {"least": least}))


def unit_of_name(name: str) -> str:
    """Return the unit that the name of a quantity ends with, as `s` of `t_inh_s`; empty where it has none."""
    first, _, last = name.rpartition("_")
    if first.endswith("_per"):
        return "m/s" if name.endswith("_m_per_s") else ""
    unit = "degC" if last == "C" else last
    return unit if first and unit in UNITS else ""


def parse_quantity(text: str, unit: str, name: str) -> float:
    """Read a quantity.

    Parameters
    ----------
    text
        What the user wrote: `12ms`, `600fF`, `10MHz`, `0.3`.
    unit
        The quantity's own unit, the only one that may follow: `s`, `F`, `Ohm`, `degC`; empty for none.
    name
        What the quantity is called, for the error's text.

    Returns
    -------
    The value in `unit`.

    Raises
    ------
    ParameterError
        If the text is no finite number, lacks its unit or has another one, or has two readings.
    """
    match = _NUMBER.match(text.strip())
    number, rest = (match.group(), text.strip()[match.end() :]) if match else ("12", "?")
    exponent = _exponent(rest, unit)
    if match is None or exponent is None:
        raise ParameterError(f'{name}: "{text}", must be {_noun(unit)}; {_remedy(number, rest, unit)}')
    mantissa, power = match.groups(default="0")
    value = float(f"{mantissa}e{int(power) + exponent}")
    if not math.isfinite(value):
        raise ParameterError(f'{name}: "{text}", must be {_noun(unit)} and finite; write a smaller number')
    if not rest and value != 0.0 and unit not in MAY_BE_BARE:
        raise ParameterError(
            f'{name}: "{text}", must be {_noun(unit)}; write the unit too, as in {_spelt(number, unit)}'
        )
    if rest == unit == "F":
        raise ParameterError(
            f'{name}: "{text}", must be {_noun(unit)} without a bare F, which is also femto;'
            f" write {1e3 * value:g}mF, or {number}fF"
        )
    return value


def format_quantity(value: float, unit: str) -> str:
    """Write a quantity for a human, in engineering notation with six significant digits.

    The text is one that `parse_quantity` reads back. So farads are written in thousandths: 3 F is `3000mF`.
    Plain numbers and degrees get no prefix.

    Parameters
    ----------
    value
        The value in `unit`.
    unit
        The quantity's unit; empty for a plain number.

    Returns
    -------
    Text such as `12ms`, `600fF`, `10MOhm`; `nan` and infinities are written as such.
    """
    if not math.isfinite(value):
        return f"{value} {unit}".rstrip()
    value += 0.0  # no -0
    if not unit or unit in UNSCALED:
        return f"{value:.{_SIGNIFICANT_DIGITS}g}{unit}"
    base, shift = _IN_BASE.get(unit, (unit, 0))
    rounded = Decimal(f"{value:.{_SIGNIFICANT_DIGITS - 1}e}").scaleb(shift)
    exponent = 3 * (rounded.adjusted() // 3) if rounded else 0
    exponent = min(max(exponent, min(_WRITTEN)), max(_WRITTEN))
    if exponent == 0 and base == "F":
        exponent = -3
    return f"{float(rounded.scaleb(-exponent)):.{_SIGNIFICANT_DIGITS}g}{_WRITTEN[exponent]}{base}"


def _exponent(rest: str, unit: str) -> int | None:
    """Power of ten of `rest`, the text after the number; None where it is no prefix and unit."""
    base, shift = _IN_BASE.get(unit, (unit, 0))
    prefix = rest.removesuffix(base).translate(_SIGNS_OF_MICRO)
    if unit in UNSCALED:
        return None if prefix else 0
    if prefix.lower() == _MEGA.lower():
        return PREFIXES["M"] - shift
    if prefix not in PREFIXES or rest == "M":
        return None
    return PREFIXES[prefix] - shift


def _noun(unit: str) -> str:
    return UNITS[unit].noun if unit in UNITS else f"a quantity in {unit}"


def _spelt(number: str, unit: str) -> str:
    """The number with its unit: with a power of ten it is SI, without one in the size that is usual."""
    if "e" in number.lower():
        return format_quantity(float(number), unit)
    return number + (UNITS[unit].usual if unit in UNITS else unit)


def _remedy(number: str, rest: str, unit: str) -> str:
    """What the user may have meant where only case or the unit is wrong; else what such a text looks like."""
    base = _IN_BASE.get(unit, (unit, 0))[0]
    prefixes = [""] if unit in UNSCALED else list(PREFIXES)
    meant = [p for p in prefixes if rest.lower() in {(p + base).lower(), p.lower()}]
    if meant and (rest in meant or rest not in UNITS):  # a bare A is amperes, not atto
        spelt = (_MEGA if p == "M" and not base else p for p in meant)
        return "write " + " or ".join(f"{number}{p}{base}" for p in spelt)
    alone = "the number alone" if unit in MAY_BE_BARE else "a number and its unit"
    return f"write {alone}, such as {_spelt(number, unit)}"
