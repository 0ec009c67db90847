"""Quantities as text, at the edges: `"12ms"`, `"600fF"`, `"10MEG"`.

A text is a number, then at most one suffix, then at most the quantity's own unit, with nothing between:

    value = number x 10^exponent(suffix)

Suffixes mean what they mean in SPICE and ignore case: f p n u m k meg g t, so `M` is milli and `MEG` is mega.
Units keep their case (`S` is not `s`). A text that can be read both as a suffix and as a unit is refused:
`1F` is a femtofarad to SPICE and a farad to everyone else.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal

from circuits.errors import ParameterError

_EXPONENTS = {"f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "meg": 6, "g": 9, "t": 12}
_SUFFIXES = {exponent: suffix for suffix, exponent in _EXPONENTS.items()}
_PREFIXES = {
    "f": "femto",
    "p": "pico",
    "n": "nano",
    "u": "micro",
    "m": "milli",
    "k": "kilo",
    "g": "giga",
    "t": "tera",
}
_NOUNS = {
    "": "a plain number",
    "A": "a current in A",
    "F": "a capacitance in F",
    "Hz": "a frequency in Hz",
    "K": "a temperature in K",
    "Ohm": "a resistance in Ohm",
    "S": "a conductance in S",
    "V": "a voltage in V",
    "W": "a power in W",
    "deg": "an angle in deg",
    "degC": "a temperature in degC",
    "m": "a length in m",
    "m/s": "a speed in m/s",
    "rad": "an angle in rad",
    "s": "a time in s",
}
_UNSCALED = frozenset({"deg", "degC"})  # nobody writes a millidegree
_CONVERTIBLE = frozenset(
    {"K", "deg", "degC", "rad"}
)  # another unit may need arithmetic, not only another spelling
_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[eE]([+-]?[0-9]{1,4}))?")
_SIGNIFICANT_DIGITS = 6


def parse_quantity(text: str, unit: str, name: str) -> float:
    """Read a quantity with SPICE suffixes.

    Parameters
    ----------
    text
        What the user wrote: `12ms`, `600f`, `10MEG`, `5V`, `0.3`.
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
        If the text is no finite number, has another unit, or is ambiguous (`1F` on a capacitance).
    """
    match = _NUMBER.match(text.strip())
    if match is None:
        raise ParameterError(f'{name}: "{text}", must be {_noun(unit)}; write {_correction("", "?", unit)}')
    number, rest = match.group(), text.strip()[match.end() :]
    suffixes = _readings(rest, unit)
    if not suffixes:
        raise ParameterError(
            f'{name}: "{text}", must be {_noun(unit)}; write {_correction(number, rest, unit)}'
        )
    if len(suffixes) > 1:
        raise ParameterError(
            f'{name}: "{text}", must be {_noun(unit)} without a bare {rest}, which is also '
            f"{_PREFIXES[rest.lower()]}; write {number} for {number} {unit}, or {number}{rest.lower()}{unit}"
        )
    mantissa, exponent = match.groups(default="0")
    value = float(f"{mantissa}e{int(exponent) + _EXPONENTS[suffixes[0]]}")
    if not math.isfinite(value):
        raise ParameterError(f'{name}: "{text}", must be {_noun(unit)} and finite; write a smaller number')
    return value


def format_quantity(value: float, unit: str) -> str:
    """Write a quantity for a human, in engineering notation with six significant digits.

    The text is one that `parse_quantity` reads back. So a value whose unit alone would read as a suffix is
    written in thousandths: 3 m is `3000mm`. Plain numbers and degrees get no suffix.

    Parameters
    ----------
    value
        The value in `unit`.
    unit
        The quantity's unit; empty for a plain number.

    Returns
    -------
    Text such as `12ms`, `600fF`, `10megOhm`; `nan` and infinities are written as such.
    """
    if not math.isfinite(value):
        return f"{value} {unit}".rstrip()
    if not unit or unit in _UNSCALED:
        return f"{value:.{_SIGNIFICANT_DIGITS}g}{unit}"
    rounded = Decimal(f"{value:.{_SIGNIFICANT_DIGITS - 1}e}")
    exponent = 3 * (rounded.adjusted() // 3) if rounded else 0
    exponent = min(max(exponent, min(_SUFFIXES)), max(_SUFFIXES))
    if exponent == 0 and unit.lower() in _EXPONENTS:
        exponent = -3
    return f"{float(rounded.scaleb(-exponent)):.{_SIGNIFICANT_DIGITS}g}{_SUFFIXES[exponent]}{unit}"


def _readings(rest: str, unit: str) -> list[str]:
    """Every suffix with which `rest`, the text after the number, makes sense."""
    suffixes = [""] if unit in _UNSCALED else list(_EXPONENTS)
    return [s for s in suffixes if rest[: len(s)].lower() == s and rest[len(s) :] in {"", unit}]


def _noun(unit: str) -> str:
    return _NOUNS.get(unit, f"a quantity in {unit}")


def _correction(number: str, rest: str, unit: str) -> str:
    """What the user probably meant: the same suffix with the quantity's own unit."""
    if not unit or unit in _CONVERTIBLE:
        return f"a plain number, in {unit}" if unit else "the number alone"
    spelt = rest.replace("\u00b5", "u").replace("\u03bc", "u")  # micro sign, Greek mu
    known = {each.lower() for each in _NOUNS} | {unit.lower()}
    for suffix in _EXPONENTS:
        if spelt[: len(suffix)].lower() == suffix and spelt[len(suffix) :].lower() in known:
            return f"{number}{suffix}{unit}"
    return f"a number with its suffix and unit, such as 12m{unit}"
