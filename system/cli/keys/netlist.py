"""Keys of `noctule export`, `noctule import` and `noctule compare`."""

from __future__ import annotations

from system.cli.keys.block import BIAS_KEYS, PORT_KEYS
from system.meaning import meanings
from system.options.block import SILICON_KEYS
from system.options.cards import CARDS_KEYS

WRITTEN_KEYS = """
file     string?  -  file that was written; null for stdout
lines    integer  -  lines of the netlist
netlist  string   -  the netlist, where it goes to stdout
"""
NOTE_KEYS = """
what   string   -  what it is
place  string   -  file and line where it stands first
count  integer  -  how often
"""
EXPORT = {
    **meanings("""
block         string     -  name of the block
dialect       string     -  in which simulator's text
level         string     -  `transistor` or `behavioural`
models        string     -  what transistors are: `ekv` or `bsim3`
parasitics    integer    -  capacitances that were merged in
definitions   integer    -  subcircuits that the netlist defines
devices       integer    -  devices in all its places
cells         integer    -  behavioural cells, in the place of both
mapping       string?    -  foundry's process; null for the block's own
mapped_sizes  string?    -  which sizes the transistors have there
unwritten     string[]   -  what a deck asks for that is not in what was written of it
"""),
    **SILICON_KEYS,
    **CARDS_KEYS,
    **meanings("stimuli  number?{}  -  stimuli in SI units; null for off"),
    **meanings(WRITTEN_KEYS),
}
EXPORT_ROLLS = {
    **meanings("""
block          string     -     name of the chip
at             string     -     row that was written
dialect        string     -     in which simulator's text
models         string     -     what transistors are: `ekv` or `bsim3`
"""),
    **{key: each for key, each in SILICON_KEYS.items() if key != "at"},
    **meanings("""
synapses            object[]  -  latched synapses of the row
synapses.element    integer   -  number of its element in the netlist
synapses.column     integer   -  neuron whose spikes it takes
synapses.level      integer   -  level of its weight; negative ones inhibit
virtual_excitatory  integer   -  virtual synapses that excite
virtual_inhibitory  integer   -  virtual synapses that inhibit
slow_leak           boolean   -  whether the neuron has the slow leak
starts_at_rest      boolean   -  whether the run starts at rest; not so where the neuron fires by its bias
devices             integer   -  devices in all places of the row
"""),
    **meanings(WRITTEN_KEYS),
}
IMPORT = {
    **meanings("""
file             string       -     netlist that was read
dialect          string       -     of which simulator it is
models           string?      -     what its transistors are, where its notes say so
title            string       -     its title
temperature_C    number?      degC  temperature that it states
die              string?      -     die that its notes name
circuit          string       -     name of the circuit at the top
circuits         string[]     -     names of all circuits
devices          integer{}    -     devices in all places, by their type
node_count       integer      -     nodes, ground not among them
deviation_count  integer      -     devices whose deviations its notes have
parasitic_count  integer      -     capacitances that were merged in
ports            object[]     -     ports of the circuit
biases           object[]     -     biases of the circuit
sources          object[]     -     sources of the testbench
sources.name     string       -     its name
sources.node     string       -     node that it drives
sources.quantity string       -     `voltage` or `current`
sources.waveform string       -     as `constant` or `pulse`
sources.*        number       -     numbers of the waveform by name in V or A, times in s, a rate in Hz
stop_s           number       s     end of the run
analyses         object[]     -     analyses that it asks for
analyses.analysis string      -     `tran`, `op` or `dc`
analyses.step    number|number[]  -  of `tran` the interval of printed points, s; of `dc` the steps, V or A
analyses.stop    number|number[]  -  where it ends: at a time, s, or at values of the sources, V or A
analyses.start   number|number[]  -  where it begins, likewise
analyses.max_step number?     s     largest step of the solver; null where none is given
analyses.uic     boolean      -     whether it begins with given voltages
analyses.sources string[]     -     sources that are swept, the innermost first
analyses.scale   string       -     of `ac` and `noise`: `dec`, `oct` or `lin`
analyses.points  integer      -     frequencies a decade, an octave, or in all
analyses.low     number       Hz    first frequency
analyses.high    number       Hz    last frequency
analyses.output  string       -     node whose noise it is
analyses.reference string     -     node against which it is; `0` for ground
analyses.source  string       -     source that the noise is referred to
steps            object[]     -     what it steps, which `sweep` goes over
steps.name       string       -     the source or parameter, or `temp`
steps.values     number[]     -     its values, V, A, degC or in the parameter's unit
steps.place      string       -     `file:line` of the card
steps.is_parameter  boolean   -     whether it is a parameter
measures         object[]     -     measures that it asks for
measures.analysis string      -     `tran`, `dc` or `ac`
measures.text    string       -     name and expression, as `--measure` takes it
foreign          object[]     -     cards for ngspice only, which the circuit lacks
foreign.text     string       -     the card
foreign.place    string       -     its file and line
foreign.reason   string       -     why it is for ngspice only
notes            object[]     -     what was not taken over, and changes no circuit
dropped          object[]     -     what `--drop` let go
names            string{}     -     names in the netlist of what is called otherwise here
"""),
    **meanings(PORT_KEYS, "ports"),
    **meanings(BIAS_KEYS, "biases"),
    **meanings("""
biases.device                   string?  -     transistor that it biases; null for a voltage
biases.reference_temperature_c  number   degC  at which the value holds
biases.place                    any      -     place on a chip; null for a circuit by itself
"""),
    **meanings(NOTE_KEYS, "notes"),
    **meanings(NOTE_KEYS, "dropped"),
}
COMPARE = {
    **meanings("""
first             string     -  the first netlist
second            string     -  the second
equal             boolean    -  whether their circuits are equal
devices           integer[]  -  devices of each
nodes             integer[]  -  nodes of each, ground not among them
size_tolerance    number     -  relative difference up to which sizes are equal
not_compared      string[]   -  what may differ all the same
dropped           object[]   -  what `--drop` let go, of both
differences       object[]   -  what differs
differences.kind  string     -  a port, a device or node, or a size
differences.path  string     -  where
differences.text  string     -  how, in a line
"""),
    **meanings(NOTE_KEYS, "dropped"),
}
