"""Keys of `noctule run bench` and of `noctule labs`."""

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
board     object?     -  what was taken of an identified die's file; null of a nominal board
board.file           string    -     the file
board.temperature_C  number    degC  temperature at which it was measured
board.identified     string[]  -     unknowns of the circuit that the measurements fixed, and that were taken
board.nominal        string[]  -     those that they left free, which are nominal
set       string[]    -  columns of what was set; of a record its time
columns   number[]{}  -  a number a point or sample by the column's name, which ends with its unit: `V`, `A`,
          `s`, `counts`, or `code` for a fine code
"""),
}
LABS = meanings("""
folder   string     -  of what was given out: the folder that was written
dies     integer[]  -  of what was given out: the die of each student
silent   integer    -  of what was given out: how many dies were passed over, since a neuron stays silent
die      integer    -  of a check: the student's die
numbers  object{}   -  of a check: each number of the student, by its name
numbers.*.value   number   -  the student's, in the unit that its name ends with
numbers.*.error   number?  -  by how much it may be off, in that unit; null where the die has none
numbers.*.inside  boolean  -  whether it is not farther from the die's own
outside  integer    -  of a check: how many are farther
""")
