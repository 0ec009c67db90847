"""Keys of `noctule sweep`."""

from __future__ import annotations

from system.meaning import meanings
from system.options.block import SILICON_KEYS

SWEEP = {
    **meanings("block  string  -  name of the block"),
    **SILICON_KEYS,
    **meanings("""
engine    string     -  `native` or `ngspice`
analysis  string     -  `dc` or `tran`
stimuli   number?{}  -  stimuli in SI units; null for off
over      object[]   -  what was swept, the innermost first
over.kind    string            -  `source`, `bias`, `param`, `stimulus` or `silicon`
over.name    string            -  its name
over.unit    string            -  unit of its values; empty for plain numbers and words
over.values  number[]|string[]  -  its values
way          string     -  `up`, `down` or `both`
dimensions   string[]   -  axes of the voltages, currents and `stable`, which are lists over them, the last
             fastest
shape        integer[]  -  length of each of these axes
measured     object{}   -  what `--measure` asked for, by its name
measured.*.unit        string     -  unit of its expression; empty for a plain number
measured.*.expression  string     -  the expression
measured.*.dimensions  string[]   -  axes of its values; the innermost of points is not among them
measured.*.values      number?[]  -  its values over them, the last fastest; null where it does not occur
unmeasured   integer{}  -  how many values there are not, by the reason
failures     string[]   -  where no operating point was found
voltages_V   number?[]{}  V  of operating points: voltage of each node
currents_A   number?[]{}  A  current of each device and source
stable       boolean[]    -  whether each point is stable
"""),
}
