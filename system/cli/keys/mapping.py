"""Keys of `noctule map`, `noctule show PROGRAM.toml` and `noctule run PROGRAM.toml`."""

from __future__ import annotations

from system.meaning import meanings
from system.options.block import DIE_KEYS

_FOUND = """
chip                   string    -  the chip
neurons                integer   -  neurons of the network
channels               integer   -  channels of its inputs
exact                  integer   -  findings within 1 %
approximate            integer   -  findings beyond
findings               object[]  -  what the chip makes of the network
findings.where         string    -  population, connection, input or kind of synapses
findings.what          string    -  what of it
findings.how           string    -  `exact` or `approximate`
findings.error         number    -  by how much it is off, as a share
findings.note          string    -  what that is of
findings.asked         number?   -  what was asked for, in `unit`; null where it is no one number
findings.got           number?   -  what the nominal die has
findings.unit          string    -  unit of both
"""
_MAPPED = meanings(f"""{_FOUND}
synapses               integer   -  synapses between neurons
populations            object[]  -  where each population stands
populations.name       string    -  its name
populations.first      integer   -  its first neuron on the chip; the others follow
populations.slow_leak  boolean   -  whether its leak is IF_TAU1
filters                object[]  -  filters of synapses that are in use
filters.name           string    -  its name
filters.tau_s          number    s  its time constant on the nominal die
filters.power          number    -  of its current over what comes in
filters.weights_A      number[]  A  what an event of each level adds to what it integrates
""")
_VALUES = meanings(f"""{_FOUND}
ensembles             object[]  -  where each ensemble stands
ensembles.name        string    -  its name
ensembles.first       integer   -  its first neuron on the chip; the others follow
ensembles.neurons     integer   -  how many it has
ensembles.dimensions  integer   -  length of its vector
filters               integer   -  filters that are in use
""")
_WRITTEN = meanings("""
network      string    -  file of the network
file         string    -  program that was written
nodes        object[]  -  nodes of a graph of NIR, as they are read; none of another network
nodes.where  string    -  its name, of one in a graph within as `graph.node`
nodes.type   string    -  its type
nodes.how    string    -  `faithful` or `approximate`
nodes.note   string    -  what it becomes
""")
_SHOWN = meanings("file  string  -  the program")
MAP, MAP_NEF = {**_WRITTEN, **_MAPPED}, {**_WRITTEN, **_VALUES}
TRAIN = meanings("""
network      string    -  file of the network
file         string    -  network that was written
dies         integer   -  drawn dies in the loop; 0 for the nominal one
seed         integer   -  of what was drawn
weights      integer   -  weights that were trained
loss_first   number    -  mean loss of the first tenth of the steps, on the differentiable form
loss_last    number    -  that of the last tenth
right_first  number    -  mean share of samples that are right there, of the first tenth
right_last   number    -  that of the last tenth
losses       number[]  -  of each step
right        number[]  -  of each step
""")
SHOW_PROGRAM, SHOW_PROGRAM_NEF = {**_SHOWN, **_MAPPED}, {**_SHOWN, **_VALUES}
_RUN = """
program                           string    -     the program
chip                              string    -     the chip
temperature_C                     number    degC  temperature at the beginning
bias_kind                         string    -     what stands behind the bias currents
codes                             string    -     `calibrated`, or `default` for the program's own
begin_s                           number    s     from when on rates and outputs count
duration_s                        number    s     length of the run
outputs                           object[]  -     the network's probes
outputs.name                      string    -     its name
outputs.from_asked                number?   -     rms difference over the largest value; null where that is 0
"""
RUN_PROGRAM = {
    **meanings(f"""{_RUN}
populations                       object[]  -     the populations
populations.name                  string    -     its name
populations.asked_Hz              number    Hz    mean rate in the network that was asked for
populations.expected_Hz           number    Hz    in what the mapping makes of it
populations.rate_Hz               number    Hz    on the die
populations.trains_from_asked     number    -     van Rossum distance of the die's spike trains, 20 ms, rms
populations.trains_from_expected  number    -     likewise
outputs.from_expected             number?   -     likewise
events_lost                       integer   -     events that the input bus lost
spikes_lost                       integer   -     spikes that the output bus lost
events_later                      integer   -     events for times after the end of the run, not sent
held                              integer   -     filters times steps at the end of a filter's table
cautions                          string[]  -     what the chip tells of itself
"""),
    **DIE_KEYS,
}
RUN_PROGRAM_NEF = {
    **meanings(f"""{_RUN}
outputs.from_ideal        number?  -  likewise, from a run of ideal neurons
outputs.ideal_from_asked  number?  -  likewise, of ideal neurons from what was asked for
spikes                    integer  -  spikes of all neurons
spikes_dropped            integer  -  spikes that the router dropped
values_clipped            integer  -  steps in which a converter was at its end
values_lost               integer  -  steps in which more was lost than its accumulator holds
rows_later                integer  -  rows of the inputs for times after the end of the run, not used
"""),
    **DIE_KEYS,
}
