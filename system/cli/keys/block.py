"""Keys of `noctule show` and `noctule op`."""

from __future__ import annotations

from system.meaning import meanings
from system.options.block import SILICON_KEYS

PORT_KEYS = """
name       string     -  its name
kind       string     -  `event`, `analog`, `bias` or `supply`
direction  string     -  `in` or `out`
shape      integer[]  -  how many there are along each axis; empty for one
"""
BIAS_KEYS = """
name   string           -  its name
port   string           -  port to which it goes
kind   string           -  `gate`, `ideal`, `generator` or `voltage`
value  number|number[]  -  in the unit beside it; an array has one for each element of the port
"""
SIZED_KEYS = """
node_count    integer   -  nodes, ground not among them
device_count  integer   -  devices in all its places
ports         object[]  -  its ports
biases        object[]  -  its biases
"""
DISTURBANCE_KEYS = """
disturbance            object?   -  what moved the run out of an unstable rest state; null where nothing did
disturbance.nodes      string[]  -  nodes that were moved
disturbance.voltage_V  number    V  how far
"""
SHOW = {
    **meanings("""
block    string  -  name of the block
summary  string  -  what it is
"""),
    **SILICON_KEYS,
    **meanings(SIZED_KEYS),
    **meanings(PORT_KEYS, "ports"),
    **meanings(BIAS_KEYS, "biases"),
    **meanings("""
biases.unit                     string           -     unit of the value
biases.device                   string?          -     transistor that it biases; null for a voltage
biases.reference_temperature_C  number           degC  at which the value holds
biases.voltage_V                number|number[]  V     what it puts on its port at the silicon's temperature
parameters                      object[]         -     sizes that `--param` sets
parameters.name                 string           -     its name
parameters.value                number           -     in the unit beside it
parameters.unit                 string           -     unit of the value; empty for a plain number
stimuli                         object[]         -     knobs of the testbench that `--stimulus` sets
stimuli.name                    string           -     its name
stimuli.unit                    string           -     unit of the default; empty for a plain number
stimuli.default                 number?          -     in the unit beside it; null for off
stimuli.summary                 string           -     what it does
stimuli.can_be_off              boolean          -     whether `off` is taken
metrics                         object[]         -     what a study can measure
metrics.name                    string           -     its name, for `--metric`
metrics.unit                    string           -     its unit; empty for a plain number
metrics.summary                 string           -     what it is
metrics.nominal                 number?          -     value on the nominal die; null without `--metrics`
closed_forms                    object[]         -     quantities that equations of the paper give
closed_forms.equation           integer          -     number of the equation
closed_forms.name               string           -     the quantity, which ends with its unit
closed_forms.printed            number           -     by the equation as printed, in that unit
closed_forms.corrected          number?          -     by it as corrected; null where the print holds
equations                       object[]         -     equations of the paper
equations.number                integer          -     its number
equations.name                  string           -     what it gives
equations.printed               string           -     as printed
equations.corrected             string?          -     as corrected; null where the print holds
equations.difference            string           -     what differs and why
devices                         object[]         -     devices in all their places
devices.path                    string           -     where it is
devices.type                    string           -     as `transistor`
devices.polarity                string           -     of a transistor: `n` or `p`
devices.quantity                string           -     of a source: `voltage` or `current`
devices.terminals               string{}         -     node of each terminal
devices.sizes                   number{}         -     its parameters in SI units, lengths in m
"""),
}
SHOW_CHIP = {
    **meanings("""
chip                      string     -  name of the chip
summary                   string     -  what it is
circuits                  object[]   -  circuits that it is made of
circuits.name             string     -  its name
circuits.instances        object[]   -  what stands in it
circuits.instances.name   string     -  its name
circuits.instances.shape  integer[]  -  how many there are along each axis; empty for one
"""),
    **meanings(SIZED_KEYS, "circuits"),
    **meanings(PORT_KEYS, "circuits.ports"),
    **meanings(BIAS_KEYS, "circuits.biases"),
    **meanings("circuits.biases.unit  string  -  unit of the value"),
}
SHOW_ROLLS = {
    **meanings("""
chip     string  -  name of the chip
summary  string  -  what it is
"""),
    **SILICON_KEYS,
    **meanings("""
bias_kind               string     -   kind of the biases: `gate`, `ideal` or `generator`
bias_file               string?    -   codes that were given; null for the chip's own
fi_current_A            number[]   A   input currents of the f-I curves
fi_rate_Hz              number[][] Hz  rate of each neuron at each of them
fi_nominal_rate_Hz      number[]   Hz  rate of the nominal neuron at each
rheobase_A              number[]   A   least current at which each neuron fires
fires_without_input     integer[]  -   neurons that fire without input
membrane_time_constant_s  number[]    s  of each neuron
refractory_period_s       number[]    s  of each neuron
filter_time_constant_s    number[]{}  s  of each neuron's synapses, by their kind
pulse_length_s            number[]    s  of each neuron's input pulses
spread            object{}  -  mean and spread over the neurons of what its name says, in its unit
spread.*.mean      number   -  mean
spread.*.cv        number?  -  standard deviation over the mean
spread.*.least     number   -  least value
spread.*.greatest  number   -  greatest value
weights                    object[]    -  levels of the synapses' weights
weights.level              integer     -  level; negative ones inhibit
weights.nominal_current_A  number      A  current of the level in the nominal synapse
weights.current_A          number      A  its mean over the neurons
weights.charge_C           number      C  mean charge of an event
weights.charge_cv          number?     -  standard deviation of this charge over its mean
missing_levels             string{}    -  why a level was not measured, by the level
cautions                   string[]    -  what the chip warns of
power                          object    -   power of the neurons and their synapses
power.paper_typical_W          number    W   what the paper calls typical
power.biases_W                 number    W   of the biases
power.generator_W              number    W   of the splitters of the bias generator
power.rest_W                   number    W   of all neurons, filters, synapses and extenders at rest
power.static_W                 number{}  W   the same by block
power.at_rest                  object    -   power without spikes and events
power.at_rest.static_W         number    W   leakage and rest currents of neurons, filters and synapses
power.at_rest.bias_W           number    W   of the biases' branches and the generator's splitters
power.at_rest.dynamic_W        number    W   of spikes and events, here none
power.at_rest.total_W          number    W   sum of these three
power.spike_rate_Hz            number[]  Hz  rates at which the energy of a spike was measured
power.spike_energy_J           number[]  J   energy of a spike at each
power.column_event_energy_J    number    J   energy of an event in a column's circuits
power.synaptic_event_energy_J  number{}  J   energy of an event in a synapse, by its level
power.virtual_event_energy_J   number{}  J   energy of an event at a virtual synapse, by its sign
power.at_rate                  object[]  -   power of the chip
power.at_rate.rate_Hz          number    Hz  rate of all neurons
power.at_rate.unconnected_W    number    W   without latched synapses
power.at_rate.all_to_all_W     number?   W   with all synapses at level 1
plastic_power                           object?   -   of the plastic array; null where it lacks biases
plastic_power.learning_circuits_rest_W  number    W   of the neurons' learning circuits at rest
plastic_power.weight_rest_W             object    -   of a weight at rest
plastic_power.weight_rest_W.low         number    W   of a low one
plastic_power.weight_rest_W.high        number    W   of a high one
plastic_power.column_event_energy_J     number    J   energy of an event in a column's circuits
plastic_power.weight_event_energy_J     object    -   energy of an event in a weight
plastic_power.weight_event_energy_J.low   number  J   in a low one
plastic_power.weight_event_energy_J.high  number  J   in a high one
plastic_power.spike_rate_Hz             number[]  Hz  rates at which the energy of a spike was measured
plastic_power.spike_energy_J            number[]  J   energy of a spike in the learning circuit at each
plastic_power.at_rate                   object[]  -   power of the array
plastic_power.at_rate.rate_Hz           number    Hz  rate of all neurons
plastic_power.at_rate.all_low_W         number    W   with all weights low
plastic_power.at_rate.all_high_W        number    W   with all weights high
depression_power                 object?  -  of cells of depression; null where they lack biases
depression_power.step_current_A  number   A  current of a cell's step
depression_power.rest_W          number   W  of all cells at rest
depression_power.event_energy_J  number   J  energy of an exciting event of a synapse
"""),
}
STATE_KEYS = f"""
stable      boolean   -  whether the state is stable
{DISTURBANCE_KEYS}
voltages_V  number{{}}  V  voltage of each node
element_currents_A  number{{}}  A  current of each inductor, and of each source between two nodes
devices                        object[]  -    transistors, resistors and diodes
devices.name                   string    -    where it is
devices.type                   string    -    `nfet`, `pfet`, `resistor` or `diode`
devices.current_A              number    A    into the drain; from a resistor's first node, or the anode, on
devices.inversion_coefficient  number?   -    current over the specific current
devices.g_m_S                  number?   S    transconductance
devices.g_m_over_i_d_per_V     number?   1/V  transconductance over current
devices.g_ds_S                 number?   S    output conductance
devices.v_ds_V                 number?   V    drain-source voltage, its size
devices.v_ds_sat_V             number?   V    least one for saturation
devices.headroom_V             number?   V    how much more there is than that
devices.inversion              string    -    `off`, `weak`, `moderate` or `strong`
devices.region                 string    -    `saturated` or `linear`
source_currents_A              number{{}}  A    what each source, and that behind a bias, delivers
"""
OP = {
    **meanings("block  string  -  name of the block"),
    **SILICON_KEYS,
    **meanings("""
stimuli       number?{}  -  stimuli in SI units; null for off
start_V       number{}   V  voltages that `--start` gave
other_states  object[]   -  states that are found without them
"""),
    **meanings(STATE_KEYS),
    **meanings(STATE_KEYS, "other_states"),
}
