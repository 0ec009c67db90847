"""High-threshold neuron: it spikes once for the outgoing call, and never for echoes.

It fires when the envelope rises above `v_threshold`, which echoes never reach, and stays silent from then
until a refractory period after the envelope has fallen below it again: one spike for a call, however long.
Its spike is the call input of the ranging chip. The spikes come from the circuit of
`circuits.blocks.sonar.spike_generator`.

Source: Cheely & Horiuchi 2003, section 4, Triggering and Figure 8. The circuit and every number are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.ports import SUPPLY, analog_in, biased, event_out
from circuits.blocks.sonar import spike_generator
from circuits.circuit import Bias, Circuit
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params:
    """Capacitor (F) and resistor (Ohm) of the refractory period; ours."""

    refractory_capacitance: float = quantity(470e-12, "F")
    refractory_resistance: float = quantity(11e6, "Ohm")  # 3 ms


# Ours: 1 V at the microphone is an envelope of 1.07 V, 2.4 V one of 2.51 V; 1.4 V just fires.
BIASES = (Bias("v_threshold", "v_threshold", "voltage", 1.5), *spike_generator.BIASES)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports envelope (in), spike (event out), biases and the supply."""
    refractory = params.refractory_capacitance, params.refractory_resistance
    generator = spike_generator.generator(*refractory, "envelope")
    ports = (SUPPLY, *analog_in("envelope"), *event_out("spike"))
    return biased("high_threshold_neuron", ports, BIASES, (), (generator,))


BLOCK = spike_generator.listening_block(
    name="high-threshold-neuron",
    build=build,
    amplitude=2.2,
    plotted=("envelope", "spike"),
    signal="envelope",
)
