"""Keys of `noctule simulate` in all its analyses, and of a run that other commands make."""

from __future__ import annotations

from system.cli.keys.block import DISTURBANCE_KEYS
from system.meaning import meanings
from system.options.block import SILICON_KEYS
from system.options.cards import CARDS_KEYS

TOLD_KEYS = f"""
{DISTURBANCE_KEYS}
uncrossed                object{{}}  -  nodes that crossed no threshold though an event was to come from them
uncrossed.*.low_V        number    V  lowest voltage of the node
uncrossed.*.high_V       number    V  highest one
uncrossed.*.threshold_V  number    V  threshold that it did not cross
"""
MEASURED_KEYS = """
measured         object[]  -  what `--measure` asked for, and a deck's own cards
measured.name    string    -  its name
measured.value   number?   -  its value in SI units; null where it does not occur
measured.unit    string    -  the unit of its expression; empty for a plain number
measured.reason  string?   -  why it does not occur; null where it does
"""
SIMULATE = {
    **meanings("block  string  -  name of the block"),
    **SILICON_KEYS,
    **CARDS_KEYS,
    **meanings(f"""
engine    string                -  `native` or `ngspice`
stimuli   number?{{}}             -  stimuli in SI units; null for off
outcome   string                -  what happened, in a word
spikes_s  number[]|number[]{{}}   s  times of the spikes; by port where there are several
{TOLD_KEYS}
measures        number?{{}}  -  what was measured, in the unit that its name ends with; null where not defined
{MEASURED_KEYS}
steps           integer    -  steps of the solver that were accepted
rejected_steps  integer    -  steps that were not
iterations      integer    -  Newton iterations in all
"""),
}
RUN_KEYS = """
runs                    object[]   -     an analysis a die and temperature
runs.stable             boolean    -     whether its rest state is stable
runs.reason             string?    -     why it has no answer; null where it has one
"""
HEAD_KEYS = """
block         string      -   name of the block
analysis      string      -   `ac` or `noise`
stimuli       number?{}   -   stimuli in SI units; null for off
failed        integer     -   runs that have no answer
frequency_Hz  number[]    Hz  frequencies of the arrays
"""
AC = {
    **meanings(HEAD_KEYS),
    **meanings("""
engine  string  -  `native` or `ngspice`
source  string  -  source whose small signal it is
unit    string  -  unit of the transfer, `V/V` or `V/A`; `V` of the answer to a deck's own AC values
"""),
    **meanings(RUN_KEYS),
    **{f"runs.{key}": each for key, each in SILICON_KEYS.items()},
    **meanings("""
runs.nodes              object{}  -    transfer to each node
runs.nodes.*.magnitude  number[]  -    its size, in the unit above
runs.nodes.*.phase_deg  number[]  deg  its phase, without jumps
"""),
    **meanings(MEASURED_KEYS, "runs"),
}
NOISE = {
    **meanings(HEAD_KEYS),
    **meanings("""
node           string   -  node whose noise it is; `v(A,B)` between two
source         string?  -  source to which it is referred
referred_unit  string?  -  unit of the referred noise, `V^2/Hz` or `A^2/Hz`
flicker        boolean  -  whether flicker noise is in it
"""),
    **meanings(RUN_KEYS),
    **{f"runs.{key}": each for key, each in SILICON_KEYS.items()},
    **meanings("""
runs.rms_V                     number     V       noise at the node, all frequencies
runs.white_rms_V               number     V       its white part
runs.flicker_rms_V             number     V       its flicker part
runs.output_V2_per_Hz          number[]   V^2/Hz  density at the node
runs.referred_per_Hz           number[]?  -       density referred to the source, in the unit above
runs.contributions             object[]   -       parts of the devices
runs.contributions.device      string     -       which one
runs.contributions.white_V2    number     V^2     its white part of the variance
runs.contributions.flicker_V2  number     V^2     its flicker part
runs.contributions.share       number     -       both over the whole variance
"""),
}
TRAN_NOISE = {
    **meanings("""
block     string  -  name of the block
analysis  string  -  `tran-noise`
"""),
    **SILICON_KEYS,
    **meanings("""
stimuli  number?{}  -   stimuli in SI units; null for off
seed     integer    -   seed of the noise
step_s   number     s   step of the noise's grid
band_Hz  number     Hz  highest frequency of the noise
flicker  boolean    -   whether flicker noise is in it
summary                       object{}  -  what was measured of the trials, in the unit of its name
summary.*.count               number    -  trials that have it
summary.*.mean                number?   -  mean
summary.*.standard_deviation  number?   -  standard deviation; null for a single trial
trials           object[]    -  each trial
trials.trial     integer     -  its number
trials.outcome   string      -  what happened, in a word
trials.measures  number?{}   -  what was measured, in the unit of its name; null where not defined
trials.steps     integer     -  steps of the solver
trials.spikes_s  number[]{}  s  times of the spikes of each port
"""),
    **meanings(TOLD_KEYS, "trials"),
}
DECK = meanings(f"""
block         string    -  the deck
engine        string    -  what solved it
analysis      string    -  `dc`, or another of the deck's own in ngspice as it stands: `tran` or `op`
axis          string?   -  source that is swept, or `time`; null for an operating point
points        integer   -  points
vectors       object[]  -  voltages, and in ngspice currents of sources
vectors.name  string    -  its name
vectors.unit  string    -  `V` or `A`
vectors.min   number    -  its lowest value
vectors.max   number    -  its highest
vectors.last  number    -  that at the last point
{MEASURED_KEYS.strip()}
""")
