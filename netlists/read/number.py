"""Numbers as SPICE writes them: `1.5k`, `10MEGohm`, `600fF`, `1e-12`.

A number is a mantissa, at most one exponent, at most one suffix, then letters without a meaning. Case does
not count: `M` is milli, `MEG` mega, and `1F` is a femtofarad. `MIL` is 25.4 um, but in an expression and as a
parameter's value ngspice reads it as milli with letters behind.
"""

from __future__ import annotations

import re

SCALES = {"t": 1e12, "g": 1e9, "meg": 1e6, "k": 1e3, "mil": 25.4e-6, "m": 1e-3, "u": 1e-6, "n": 1e-9,
          "p": 1e-12, "f": 1e-15, "a": 1e-18}  # fmt: skip
MIL_OF_EXPRESSION = 1e-3
_EXPONENTS = {"t": 12, "g": 9, "meg": 6, "k": 3, "m": -3, "u": -6, "n": -9, "p": -12, "f": -15, "a": -18}

# possessive, so that no text of digits and letters is read again from its middle
NUMBER = re.compile(
    r"(?P<mantissa>[0-9]++\.?[0-9]*+|\.[0-9]++)(?:e(?P<exponent>[+-]?[0-9]{1,4}))?"
    r"(?P<suffix>meg|mil|[tgkmunpfa])?[a-z\u00b5\u03a9]*+",
    re.IGNORECASE,
)
_SIGNED = re.compile(rf"(?P<sign>[+-]?){NUMBER.pattern}", re.IGNORECASE)


def number_value(match: re.Match[str], mil: float = SCALES["mil"]) -> float:
    """Value of a match of `NUMBER`; infinite where no float is large enough. mil: what the suffix `mil` is.

    The suffix is added to the exponent before the text becomes a float, so that `0.1u` is `1e-07` itself.
    """
    suffix = (match["suffix"] or "").lower()
    exponent = int(match["exponent"] or 0)
    if suffix == "mil":
        return float(f"{match['mantissa']}e{exponent}") * mil
    return float(f"{match['mantissa']}e{exponent + _EXPONENTS.get(suffix, 0)}")


def read_number(text: str, mil: float = SCALES["mil"]) -> float | None:
    """Value of a word that is a number, None for any other word. mil: what the suffix `mil` is."""
    match = _SIGNED.fullmatch(text)
    if match is None:
        return None
    value = number_value(match, mil)
    return -value if match["sign"] == "-" else value
