"""Keys of `noctule run bench`."""

from __future__ import annotations

from system.meaning import meanings
from system.options.block import SILICON_KEYS

BENCH = {
    **meanings("""
chip      string  -  name of the chip
circuit   string  -  name of the circuit that the script chooses
"""),
    **{key: each for key, each in SILICON_KEYS.items() if key != "at"},
    **meanings("""
seed      integer     -  keys what differs from one reading to the next
set       string[]    -  columns of what was set; of a record its time
columns   number[]{}  -  a number a point or sample by the column's name, which ends with its unit: `V`, `A`,
          `s`, `counts`, or `code` for a fine code
"""),
}
