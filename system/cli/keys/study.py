"""Keys of `noctule montecarlo`, `noctule replay` `noctule centre` and `noctule size`."""

from __future__ import annotations

from system.cli.keys.transient import MEASURED_KEYS, TOLD_KEYS
from system.meaning import meanings
from system.options.block import DIE_KEYS, SILICON_KEYS
from system.options.cards import CARDS_KEYS

INTERVAL_KEYS = """
low   number?  -  lower end; null where there are too few samples to know, or several a die
high  number?  -  upper end, likewise
"""
SHARE_KEYS = """
passed         integer  -  samples that pass, or say yes
value          number?  -  their share of all
interval       object   -  its 95 % interval
interval.low   number?  -  lower end
interval.high  number?  -  upper end
kind           string   -  kind of the interval, as `Clopper-Pearson`, or `Korn-Graubard` where dies have
               several samples each
"""
STATISTICS = {
    **meanings("""
classes          object{}  -  samples by what happened
classes.*.count  integer   -  how many
classes.*.share  number    -  over all
metrics          object{}  -  statistics of each metric
yield            object?   -  share that meets the specifications; null where there are none
yield.specifications  string[]   -  these
yield.causes          integer{}  -  samples that do not pass, by why
"""),
    **meanings(SHARE_KEYS, "yield"),
    **meanings(
        """
unit       string    -  unit of the numbers; empty for plain ones
defined    integer   -  samples that have it
undefined  integer   -  samples that do not
infinite   integer   -  samples of which it is infinite
share      object?   -  of a metric that says yes or no, the share of yes; null for a number
mean       number?   -  mean
sigma      number?   -  standard deviation
skew       number?   -  skewness, a plain number
mean_interval         object     -  95 % interval of the mean
sigma_interval        object     -  of the standard deviation
skew_interval         object     -  of the skewness
quantiles             number?{}  -  quantiles, by their probability
quantile_intervals    object{}   -  their 95 % intervals
""",
        "metrics.*",
    ),
    **meanings(SHARE_KEYS, "metrics.*.share"),
    **meanings(INTERVAL_KEYS, "metrics.*.mean_interval"),
    **meanings(INTERVAL_KEYS, "metrics.*.sigma_interval"),
    **meanings(INTERVAL_KEYS, "metrics.*.skew_interval"),
    **meanings(INTERVAL_KEYS, "metrics.*.quantile_intervals.*"),
}
MONTECARLO = {
    **meanings("""
target             string           -     what was measured
block              string           -     the same
temperature_C      number|number[]|number[][]  degC  temperature; several where there are several
                   conditions; of a course, pairs of time (s) and temperature
corner             string|string[]  -     corner, likewise
lot                string           -     lot of the dies
mismatch           boolean          -     whether their devices differ from each other
process_variation  boolean          -     whether their process differs from the nominal one
variation          string           -     components of variation that they have beside: `plain` none,
                   `transistors`, or `full`
edits              string[]         -     what was changed of its dies by hand, in words
process            string?          -     process that was asked for; null for the block's own
law                string           -     `full` with second-order effects of the process, `ideal` without
at                 string?          -     place on a chip; null for a block by itself
options            string[]         -     what the study sets of a system's runs, as `area=4.0`; all else is
                   as the system has it
first_die          integer          -     number of the first die
plan               string           -     how dies are sampled
seed               integer          -     seed of the sampling
samples            integer          -     samples that were measured
wanted             integer          -     samples that were asked for
engine             string           -     what solved the testbench
device             string           -     where a block's runs went, `cpu` or `gpu`
stopped            boolean          -     whether `--until` or `--require` ended it before
shared             string           -     of which lot and wafers the dies are, where they share these draws
chunks_read        integer          -     chunks that `--resume` found measured
chunks_redone      string[]         -     what it found, but did not believe
"""),
    **CARDS_KEYS,
    **STATISTICS,
    **meanings("""
conditions                object[]  -     the same by condition, where there are several
conditions.corner         string    -     corner
conditions.temperature_C  number    degC  temperature
conditions.samples        integer   -     samples at it
"""),
    **{f"conditions.{key}": each for key, each in STATISTICS.items()},
    **meanings("""
failed                object[]    -     samples that could not be measured
failed.die            integer     -     its die
failed.corner         string      -     its corner
failed.temperature_C  number      degC  its temperature
failed.trial          integer     -     its trial
failed.reason         string      -     why
unmeasured            integer{}   -     samples that did not fail but lack a measure, by the reason
dies      integer[]    -  die of each sample
outcomes  string[]     -  what happened in each, in a word
values    number?[]{}  -  value of each metric in each, in the metric's unit
report    string?      -  page of the report; null without `--output`
contributions                 object[]   -     what the variance of `--contributions` comes from
contributions.metric          string     -     of which metric
contributions.corner          string     -     at which corner
contributions.temperatures_C  number[]   degC  at which temperatures
contributions.logarithm       boolean    -     whether of its logarithm
contributions.model           string     -     model by which the shares were found
contributions.samples         integer    -     samples in all
contributions.defined         integer    -     samples that have the metric
contributions.r2              number     -     share of the variance that the model explains
contributions.unexplained     number     -     share that it does not
contributions.check           number?    -     largest difference of a share from that of a linear regression
contributions.notes           string[]   -     what to know of the shares
contributions.by_device       number{}   -     share of each device
contributions.by_parameter    number{}   -     share of each parameter of devices
contributions.by_block        number{}   -     share of each block
contributions.by_process      number{}   -     share of the process and of mismatch
"""),
    **meanings(TOLD_KEYS),
}
RARE = meanings("""
target                  string    -     what was measured
temperature_C           number    degC  temperature
corner                  string    -     corner
specifications          string[]  -     what a die must meet
seed                    integer   -     seed of the sampling
rare                    object    -     probability that a die fails
rare.method             string    -     how it was estimated
rare.probability        number    -     the estimate
rare.interval           object    -     its 95 % interval
rare.interval.low       number?   -     lower end
rare.interval.high      number?   -     upper end
rare.samples            integer   -     dies that were measured
rare.effective_samples  number?   -     samples of equal weight that say as much; null for an extrapolation
rare.detail             string    -     how it went, in a line
""")
SAMPLE_KEYS = """
class   string   -  what happened, in a word
reason  string   -  why it, or a metric of it, could not be measured; empty where there is nothing to say
*       number?  -  each metric in its unit
"""
REPLAY = {
    **meanings("target  string  -  what was measured"),
    **DIE_KEYS,
    **meanings("""
plan           string   -     how dies are sampled
temperature_C  number|number[][]  degC  temperature; of a course, pairs of time (s) and it
trial          integer  -     trial of the sample
kept           object?  -     sample as the study has it; null where it has none
again          object   -     sample as it was measured now
identical      boolean  -     whether both are equal to the bit
note           string   -     what to know of it; empty where nothing
code_changed   boolean  -     whether the user's file that the study is of has changed since
engine             string      -  of a block's run: `native` or `ngspice`
stimuli            number?{}   -  stimuli in SI units; null for off
testbench_outcome  string      -  what happened in the run of the testbench, in a word
spikes_s           number[]{}  s  times of the spikes of each port
measures           number?{}   -  what was measured of it, in the unit that its name ends with
told               string[]    -  what the run reports by itself
"""),
    **meanings(TOLD_KEYS),
    **meanings(MEASURED_KEYS),
    **meanings(SAMPLE_KEYS, "kept"),
    **meanings(SAMPLE_KEYS, "again"),
}
YIELD_KEYS = f"""
samples  integer    -  fresh dies
causes   integer{{}}  -  dies that do not pass, by why
{SHARE_KEYS}
"""
FRESH = {
    **meanings("""
fresh                object[]  -  report on fresh dies, by what varies
fresh.varied         string    -  `mismatch`, or `mismatch and process`
fresh.before         object    -  yield at the start
fresh.after          object    -  yield at the end
fresh.difference     object    -  what changed, die by die
fresh.difference.pairing              object   -  dies that both have in common
fresh.difference.pairing.both         integer  -  measured at the start and at the end
fresh.difference.pairing.only_first   integer  -  measured at the start alone
fresh.difference.pairing.only_second  integer  -  measured at the end alone
fresh.difference.both_pass            integer  -  pass at the start and at the end
fresh.difference.only_first_passes    integer  -  pass at the start alone
fresh.difference.only_second_passes   integer  -  pass at the end alone
fresh.difference.neither_passes       integer  -  pass at neither
fresh.difference.difference                object   -  yield at the end minus that at the start
fresh.difference.difference.value          number?  -  the difference
fresh.difference.difference.interval       object   -  its 95 % interval
fresh.difference.difference.interval.low   number?  -  lower end
fresh.difference.difference.interval.high  number?  -  upper end
fresh.difference.p_value              number   -  probability of as much or more if both yields were equal
                                                  (McNemar's exact test)
fresh.means          object{}  -  mean of each metric over the dies that have it, in the metric's unit
fresh.means.*.before number?   -  at the start
fresh.means.*.after  number?   -  at the end
"""),
    **meanings(YIELD_KEYS, "fresh.before"),
    **meanings(YIELD_KEYS, "fresh.after"),
}
MOVED = meanings("""
moved           object[]   -     what was moved
moved.name      string     -     its name
moved.unit      string     -     unit of its values
moved.before    number     -     value at the start
moved.after     number     -     value at the end
moved.change    number     -     ratio of both, or of a voltage the difference, V
options         string[]   -     options that give the new values to other commands
""")
SEARCHED = meanings("""
block           string     -     name of the block
specifications  string[]   -     what should pass
temperature_C   number     degC  temperature
lot             string     -     lot of the dies
at              string?    -     place on a chip; null for a block by itself
""")
TUNED_AND_JUDGED = meanings("""
tuning_dies     integer[]  -     first and last die of the search
fresh_dies      integer[]  -     first and last die of the report
""")
CENTRE = {
    **SEARCHED,
    **meanings("""
seed            integer    -     seed of the search
search_level    string     -     level at which it searched: `behavioural` or `transistor`
level           string     -     level of the report
"""),
    **TUNED_AND_JUDGED,
    **MOVED,
    **meanings("""
search               object    -  how the search went
search.scale         number    -  scale of the variation in its last stage
search.share_before  number    -  share of the tuning dies that passed at the start, at that scale
search.share_after   number    -  the same at the end
search.yield_before  number    -  share of the tuning dies that pass at the start, as they are
search.yield_after   number    -  the same at the end
search.best          number?[] -  best objective so far, after each candidate of the first stage
search.candidates    integer   -  candidates that were measured
search.impossible    integer   -  of these, those that no circuit can have
search.measurements  integer   -  dies that were measured, and runs behind gradients
"""),
    **FRESH,
}
SIZE = {
    **SEARCHED,
    **meanings("""
level           string     -     level at which dies were measured
yield_wanted    number     -     share of dies that should pass
verdict         string     -     `met`, `missed` or `undecided`, as fresh dies tell
"""),
    **TUNED_AND_JUDGED,
    **meanings("""
area_before_m2  number     m^2   area of all gates and of the plates of all capacitors at the start
area_after_m2   number     m^2   the same at the end
"""),
    **MOVED,
    **meanings("""
search               object    -  how the search went
search.predicted     number    -  share of dies that pass at the end in the linear theory, at least
search.yield_before  number    -  share of the tuning dies that pass at the start
search.yield_after   number    -  the same at the end
search.met           boolean   -  whether the wanted share of the tuning dies passes at the end
search.rounds        integer   -  how many least areas were sought
search.designs       integer   -  sizes whose gradients were taken
search.impossible    integer   -  of these, those that no circuit can have
search.measurements  integer   -  tuning dies that were measured
"""),
    **FRESH,
}
GRADIENT = {
    **meanings("block  string  -  name of the block"),
    **SILICON_KEYS,
    **meanings("""
metrics                      object[]  -  what was measured
metrics.metric               string    -  its name
metrics.unit                 string    -  its SI unit, empty for a plain number
metrics.value                number?   -  its value in that unit; null where it is not defined
metrics.spread               number?   -  its standard deviation over dies by the gradients, in that unit
metrics.error                number?   -  difference to gradients at ten times the tolerance, of it
metrics.note                 string    -  why it has no value, or where it is not smooth; empty else
metrics.gradients            object[]  -  what moves it, that which moves it most over dies first
metrics.gradients.parameter  string    -  path of the device with its parameter, or what is shared
metrics.gradients.unit       string    -  SI unit of the parameter, empty for a relative one
metrics.gradients.gradient   number    -  derivative, in the unit of the metric over that of the parameter
metrics.gradients.sigma      number    -  standard deviation of the parameter over dies, 0 for none
metrics.gradients.share      number    -  its share of the metric's variance over dies, 0 to 1
"""),
}
SHARE_OF = """
passed    integer  -  trials that succeed
of        integer  -  trials
interval  object   -  95 % interval of their share
"""
BLAME = {
    **meanings("system  string  -  name of the system"),
    **DIE_KEYS,
    **meanings("""
success                  string     -     when a trial counts as a success, in words
seed                     integer    -     seed of the first trial
temperature_C            number     degC  temperature of the chips; at the beginning of a course
trials                   integer    -     runs that were made
guilty                   boolean    -     whether the die is to blame
die_succeeds             object     -     trials on the die
healed_succeeds          object     -     the same on the die healed of all deviations
recalibrated             boolean    -     whether every edited die is calibrated anew
healed_succeeds_at_die_codes  object?  -  trials of the healed die with codes of the die; null unless it is so
finished                 boolean    -     whether the search ended before its trials did
steps                    object[]   -     levels of the search
steps.level              string     -     what its parts are
steps.among              integer    -     parts that were there
steps.kept               string[]   -     paths of the fewest whose healing mends
steps.trials             integer    -     runs made until then
culprits                 object[]   -     the fewest that were found at last
culprits.path            string     -     path, as `--heal` takes it
culprits.devices         integer    -     devices that it means
culprits.deviations      object[]   -     how a single one deviates
culprits.deviations.parameter  string  -  parameter
culprits.deviations.value      number  -  deviation: V of V_T0, else relative; a metre in x or y of a gradient
culprits.deviations.sigma      number  -  its standard deviation, 0 where it was set by hand
culprits.deviations.gradient   number  -  what gradients across the die add to that of a device
mends                    boolean?   -     whether healing them mends; null where nothing was verified
verified                 object?    -     how that was found, on trials that the search has not used
verified.trials          integer    -     pairs of trials
verified.wanted          integer    -     pairs that the power asks for
verified.mended_succeeds object     -     trials on the mended die
verified.healed_succeeds object     -     the same on the healed die
verified.difference      object     -     90 % interval of the difference of both shares
verified.difference.low  number     -     lower end, a one-sided 95 %
verified.difference.high number     -     upper end
random_mends             object?    -     sets of as many devices at random that mend; null where not tried
area_that_mends          number?    -     least area over theirs with which they mend; null where none does
codes                    object[]   -     codes of calibrations that were tried
codes.name               string     -     on which die, of which calibration
codes.succeeds           object?    -     trials with them; null where not tried
story                    string[]   -     what was found, in sentences
runs                     object[]   -     runs of one seed on the die, the mended and the healed one
runs.name                string     -     on which
runs.seed                integer    -     seed
runs.succeeded           boolean    -     whether it succeeded
runs.reason              string     -     why it ended
command                  string     -     command that runs the mended robot
"""),
    **{
        f"{where}.{key}": each
        for where in (
            "die_succeeds", "healed_succeeds", "verified.mended_succeeds", "verified.healed_succeeds",
            "healed_succeeds_at_die_codes", "random_mends", "codes.succeeds",
        )
        for key, each in {
            **meanings(SHARE_OF), **meanings(INTERVAL_KEYS, "interval"),
        }.items()
    },
}  # fmt: skip
