"""Keys of `noctule mission` and `noctule merge`, whose document is the same."""

from __future__ import annotations

from system.meaning import meanings

MISSION = {
    **meanings("""
system             string    -  name of the robot
success            string    -  when a run is a success: the robot's own sentence, or the text of `--success`
lot                string    -  lot of the dies
mismatch           boolean   -  whether their devices differ from each other
process_variation  boolean   -  whether their process differs from the nominal one
variation          string    -  components of variation that they have beside
edits              string[]  -  what was changed of its dies by hand, in words
law                string    -  `full` with second-order effects of the process, `ideal` without
options            string[]  -  what was asked of the robot, as `area=4`; all else is as a study of it has it
first_die          integer   -  number of the first die
dies               integer   -  dies that were asked for
worlds             integer   -  worlds that each die meets
trials             integer   -  runs in each world
until              number?   -  half-width at which a yield is known well enough; null without `--until`
runs               integer   -  runs that were made
wanted             integer   -  runs that were asked for
shared             string    -  of which lot and wafers the dies are, where they share these draws
report             string?   -  page of the mission; null without `--output`
ways               object[]  -  what was found at each temperature, kind of bias and change
"""),
    **meanings(
        """
name            string     -     its name, and that of its study's folder
temperature_C   number     degC  temperature
bias_kind       string?    -     kind of bias; null for a robot that has no choice of one
change          string?    -     what is changed of the robot; null for the robot as it was asked for
dies            integer    -     dies that were run
runs            integer    -     runs on them
yield           number?    -     share of the runs that are a success
interval        object     -     its 95 % interval, over dies
interval.low    number     -     lower end
interval.high   number     -     upper end
effective_runs  number     -     independent runs from which the yield would be known as well
correlation     number?    -     of two runs on a die, 0 to 1; null where it is not known
not_run         integer{}  -     runs that could not be made, by the reason; none of them is a success
undefined       integer    -     runs in which a metric of the success is not defined; none is a success
causes          object[]   -     what the failures come from; none where no run fails, or all do
causes.name     string     -     `die`, `world`, `noise`, or two that the runs cannot tell apart
causes.share    number     -     share of the failures
causes.interval       object   -  its 95 % interval
causes.interval.low   number   -  lower end
causes.interval.high  number   -  upper end
failing         object[]   -     dies with a run that is no success, the worst first
failing.die     integer    -     number of the die
failing.fails   integer    -     runs on it that are no success
failing.trial   integer    -     the first of them
failing.again   string?    -     command that makes that run again; null without `--output`
""",
        "ways",
    ),
    **meanings(
        """
change          string   -     what is changed
temperature_C   number   degC  temperature
bias_kind       string?  -     kind of bias without the change
dies            integer  -     dies that were run with and without it
gain            number?  -     yield with it less that without it
interval        object   -     95 % interval of the gain
interval.low    number   -     lower end
interval.high   number   -     upper end
verdict         string   -     whether it raises the yield, as far as the interval tells
""",
        "changes",
    ),
    **meanings(
        """
way            string    -  temperature, kind of bias and change, a name among `ways`
shares         object[]  -  what the dies are put on, blocks first
shares.block   string    -  path of the block, of all its cells; that it is not the die, or what was not shown
shares.dies    integer   -  dies on which it was named
shares.share   number    -  of the dies that were blamed, each divided evenly among its devices
shares.interval       object  -  its 95 % interval
shares.interval.low   number  -  lower end
shares.interval.high  number  -  upper end
dies           object[]  -  the dies that were blamed, the first failing ones by their numbers
dies.die       integer   -  number of the die
dies.seed      integer   -  seed of the world of its first run that is no success
dies.guilty    boolean   -  whether the die is to blame
dies.named     string[]  -  paths of the fewest devices that blame names
dies.mends     boolean   -  whether healing them was shown to mend it
dies.area      number?   -  area over theirs with which they mend; null where none that was tried does
dies.trials    integer   -  runs that were made
""",
        "blame",
    ),
    **meanings("blame    object[]?  -  what blame puts failing dies on; null without `--blame`"),
    **meanings("changes  object[]  -  what changes raise the yield by, the largest gain first"),
}
CERTIFY = {
    **MISSION,
    **meanings("""
program             string    -  the program
task                string    -  the task
scores              object[]  -  scores of the task, a row each way
scores.name         string    -  name of the way
scores.score        number?   -  mean score on silicon, 0 to 1; null as the next where no run could be made
scores.interval     object?   -  its 95 % interval, over dies
scores.least        number?   -  score of the worst die
scores.ideal_score  number?   -  mean score of the network that was asked for, in the same worlds
scores.interval.low   number  -  lower end
scores.interval.high  number  -  upper end
bits                object[]  -  weights of so many bits, without silicon, as asked for
bits.bits           integer   -  bits of a weight, its sign among them
bits.score          number    -  score of the task, 0 to 1
bits.lost           number    -  by how much it is lower than with the weights as they are
fewest_bits         integer?  -  the least of these from which on no more than 0.03 is lost; null where none
"""),
}
