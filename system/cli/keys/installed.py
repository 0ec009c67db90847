"""Keys of `noctule list`, `doctor`, `new`, `reproduce`, `calibrate` and what fits or predicts."""

from __future__ import annotations

from system.meaning import Meaning, meanings
from system.options.block import SILICON_KEYS

NAMED_KEYS = """
name     string  -  its name
summary  string  -  what it is
"""
KINDS = ("blocks", "chips", "calibrations", "systems", "experiments", "metrics", "dialects")
LIST: dict[str, Meaning] = {}
for _kind in KINDS:
    LIST |= meanings(f"{_kind}  object[]  -  all {_kind}")
    LIST |= meanings(NAMED_KEYS, _kind)
PIECE_KEYS = """
name   string   -  its name
found  string?  -  its version; null where it is missing
cost   string   -  what cannot be done without it
mend   string?  -  line that brings it; null where nothing is to be mended
"""
WRONG_KEYS = """
cost  string?  -  what cannot be done as it is; null where nothing is wrong
mend  string?  -  what mends it
"""
DOCTOR = {
    **meanings("""
noctule                string?    -  its version
checkout               string?    -  folder of the checkout that it runs from; null for an installed package
python                 string     -  version of Python
platform               string     -  operating system and processor
cores                  integer    -  cores that may be used
ngspice                object     -  ngspice's library
ngspice.library        string?    -  its file
ngspice.version        string?    -  its version
kernel_cache           object     -  where compiled functions are kept
kernel_cache.folders   string[]   -  folders
kernel_cache.writable  boolean    -  whether all can be written
kernel_cache.kernels   integer    -  functions that are kept
record_cache           object     -  where measured models are kept
record_cache.folder    string     -  the folder
record_cache.writable  boolean    -  whether it can be written
required               object[]   -  packages that it needs
optional               object[]   -  its extras
missing                string[]   -  what is missing, with what cannot be done without it
mends                  string?[]  -  line that mends each, in the same order
"""),
    **meanings(WRONG_KEYS, "ngspice"),
    **meanings(WRONG_KEYS, "kernel_cache"),
    **meanings(WRONG_KEYS, "record_cache"),
    **meanings(PIECE_KEYS, "required"),
    **meanings(PIECE_KEYS, "optional"),
}
NEW = meanings("""
kind    string    -  `block`, `chip`, `robot` or `experiment`
name    string    -  its name
folder  string    -  folder that was written
files   string[]  -  files in it
""")
CHARACTERISE = meanings("""
block    string     -  name of the block
process  string     -  process that it was measured in
law      string     -  `full` with second-order effects of the process, `ideal` without
file     string     -  record that was written
key      string     -  hash of circuits, process, measurement and grid
errors   number?{}  -  errors of the model on other dies, in the units of their names
seconds  number     s  time that it took
*        number?    -  what the model tells of itself, in the unit that its name ends with
""")
FITTED_KEYS = """
measurement   string   -  its name
column        string   -  its column
points        integer  -  points that were fitted
noise_factor  number   -  factor of the readings' noise, by their residuals
"""
EXTRACT = meanings("""
process                        string    -     name of the process that was made
source                         string    -     foundry's process, or table of currents, that it was fitted to
file                           string    -     file that was written
from_A                         number    A     least current of a foundry's that is fitted
to_A                           number    A     largest one
distances                      object[]  -     how far the law is off, by polarity and size
distances.polarity             string    -     `n` or `p`
distances.role                 string    -     of a size `fitted` or `held out`, of all `judged`
distances.width_um             number?   um    width of the device; null for all sizes
distances.length_um            number?   um    its length; null for all sizes
distances.points               integer   -     how many currents
distances.median               number    -     median of the relative error's magnitude
distances.worst                number    -     relative error of the farthest ratio to the currents
distances.worst_temperature_C  number    degC  where that is: temperature
distances.worst_drain_V            number    V     drain to bulk there, a pFET's mirrored
distances.worst_gate_V            number    V     gate to bulk there
distances.worst_source_V            number    V     source to bulk there
distances.worst_A              number    A     current there
numbers                        object[]  -     what was fitted
numbers.polarity               string    -     `n` or `p`
numbers.name                   string    -     number of the model, or its term of the size as `v_t0 1/L`
numbers.value                  number?   -     SI, of `mu_cox` the logarithm; null where it is free
numbers.error                  number?   -     its standard error
notes                          string[]  -     what the process leaves out
""")
EXTRACT_FIT = {
    **meanings("""
process        string     -    name of the process that was made
source         string     -    folder of measurements, or `coach`
file           string     -    file that was written
numbers        object[]   -    numbers of the process that can be fitted
measurements   object[]   -    what was fitted, by measurement and column
a_vt_Vm        number?    V m  A_VT of a pair; null where the measurements do not fix it
a_vt_error_Vm  number?    V m  its standard error
free           string[]   -    numbers that the measurements do not fix: as in the base
correlation    number[][] -    of the errors of the numbers that are fixed, in their order
"""),
    **meanings(
        """
polarity  string   -  `n` or `p`
name      string   -  number of the model, or its term of the size as `v_t0 1/L`
unit      string   -  its unit; `ln` for a logarithm of SI
value     number?  -  in that unit; null where it is free
error     number?  -  its standard error
""",
        "numbers",
    ),
    **meanings(FITTED_KEYS, "measurements"),
}
IDENTIFY = {
    **meanings("""
process       string    -  name of the process
source        string    -  folder of measurements, or `coach`
file          string    -  file that was written
unknowns      object[]  -  all that was not known, of the process, of devices and of the bench
measurements  object[]  -  what was fitted, by measurement and column
free          string[]  -  unknowns that the measurements do not fix
"""),
    **meanings(
        """
name         string  -  its name
kind         string  -  `process`, `device` or `nuisance`
unit         string  -  its unit; `ln` for a logarithm
mean         number  -  mean after the fit, in that unit
sd           number  -  standard deviation after it
mean_before  number  -  mean before
sd_before    number  -  standard deviation before
""",
        "unknowns",
    ),
    **meanings(FITTED_KEYS, "measurements"),
}
PREDICT = {
    **meanings("""
chip          string    -  the chip
process       string    -  name of its process
die           string    -  file of its die
folder        string    -  folder that was written
draws         integer   -  draws behind a band
measurements  object[]  -  what was predicted
"""),
    **meanings(
        """
measurement  string   -  its name
points       integer  -  rows of its file
lost_draws   integer  -  draws for which the solver found no curve
metrics      integer  -  numbers of it in `metrics.json`
""",
        "measurements",
    ),
}
CALIBRATE = {
    **meanings("""
chip             string       -     name of the calibration, which is that of its chip or of what is on it
bias_kind        string       -     what stands behind the bias currents
silicon          object       -     on what, and at which temperature
biases           integer[][]{}  -   coarse and fine codes of each bias's lines, by its name
off              integer[]{}  -     numbers of what is switched off by its address, by the name of its array
trims            number[]{}   -     values of trims of the board by name, in SI units
measured         object[]     -     what the bench measured
measured.name    string       -     what it is
measured.unit    string       -     unit of its numbers
measured.wanted  number       -     what the design wants
measured.before  number?      -     at the usual codes; null where nothing could be measured
measured.after   number?      -     at the codes that were found; null where nothing could be measured
bench_s          number       s     time that the chip was run on the bench
unmended         string[]     -     what stays off, a sentence each
failed           string       -     why the chip cannot be used; empty where it can
file             string?      -     file that was written; null for none
seconds          number       s     time that it took
"""),
    **{f"silicon.{name}": meaning for name, meaning in SILICON_KEYS.items()},
}
REPRODUCE = meanings("""
experiment      string                   -  name of the experiment
rows            object[]                 -  each value beside the paper's
rows.name       string                   -  its name, which ends with its unit
rows.paper      number?|string|boolean   -  the paper's value; null where it gives none
rows.ours       number?|string|boolean   -  the value that was found
rows.rule       string                   -  when ours agrees, in words
rows.tolerance  number?                  -  the number of the rule; null where it has none
rows.fitted     boolean                  -  whether the value was used to choose parameters
rows.agrees     boolean?                 -  the verdict; null where the rule gives none
scores          object[]                 -  how many of the rows hold, for ours, nulls and the paper
scores.name     string                   -  `ours`, the name of a null, or `paper` for the paper's own values
scores.held     integer                  -  rows that hold
scores.judged   integer                  -  rows with a verdict; of the paper those whose value can be judged
scores.p        number?                  -  probability by a sign test over the rows that ours holds so many
                                            more than a null by chance; null of ours and the paper
notes           string[]                 -  sentences for the reader
""")
