"""Names of a netlist turned into names that a circuit allows, and back.

Two different names never become the same one. A circuit's names are letters, digits and `_`, without a digit
in front. Upper and lower case do not differ in either world, and lower case is kept. The rule, in this order:

1. every other character becomes `_x` + its code in hexadecimal + `_`: `net-3` is `net_x2d_3`, `v_mem#3` is
   `v_mem_x23_3`; an `_` that already begins such an escape (`_x2d`) is escaped itself, `_x5f_x2d`;
2. a node `ground` or `gnd!`, which is like any other in SPICE, has its first letter written by rule 1;
3. a name that begins with a digit, or with `_`s and then a digit, gets one `_` in front: `1` is `_1`, `_1` is
   `__1`; an empty name cannot occur.
"""

from __future__ import annotations

import re
from functools import lru_cache

_GROUNDS = {"0", "gnd"}
_NOT_GROUND = {"gnd!", "ground"}  # nodes like any other in SPICE, by names that a circuit refuses
_PLAIN = re.compile(r"[a-z][a-wyz0-9]*(?:_[a-wyz0-9]+)*")  # no x, so that no escape can be in it
_ESCAPED = re.compile(r"_(?=x[0-9a-f]{2})|[^a-z0-9_]")
_ESCAPE = re.compile(r"_x([0-9a-f]{2,6})_")
_DIGIT_FIRST = re.compile(r"_*[0-9]")


def is_ground(name: str) -> bool:
    """Whether a node of a netlist is ground."""
    return name.lower() in _GROUNDS


@lru_cache(maxsize=100_000)
def circuit_name(name: str) -> str:
    """Return the name that `name` of a netlist has in a circuit, by the rule of this module."""
    lower = name.lower()
    if lower in _NOT_GROUND:
        return f"_x67_{lower[1:].replace('!', '_x21_')}"
    if _PLAIN.fullmatch(lower):
        return lower
    escaped = _ESCAPED.sub(lambda found: f"_x{ord(found.group()):02x}_", lower)
    return f"_{escaped}" if _DIGIT_FIRST.match(escaped) else escaped


def original_name(name: str) -> str:
    """Return the netlist's own name, in lower case, of a `name` that `circuit_name` made."""
    stripped = name[1:] if name.startswith("_") and _DIGIT_FIRST.match(name) else name
    return _ESCAPE.sub(lambda found: chr(int(found.group(1), 16)), stripped)
