"""High-threshold neuron: a single spike for the outgoing call, and none for echoes.

It fires when the envelope rises above `v_threshold`, which echoes never reach, and stays silent from then
until a refractory period after the envelope has fallen below it again: one spike a call, however long.
Its spike is the call input of the ranging chip. Spikes come from the `spike_generator`.

Source: Cheely & Horiuchi 2003, section 4, Triggering and Figure 8; the circuit and every number are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import Block, Values
from circuits.blocks.sonar.rebound_neuron import outcome
from circuits.blocks.sonar.spike_generator import (
    SUPPLY,
    GeneratorParams,
    envelope_testbench,
    generator_biases,
    sound_stimuli,
    spike_generator,
    spike_measures,
)
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params:
    """Capacitor in farad, resistor in ohm; both ours."""

    refractory_capacitance: float = quantity(470e-12, "F")
    refractory_resistance: float = quantity(11e6, "Ohm")  # 3 ms


# Ours: 1 V at the microphone is an envelope of 1.07 V, 2.4 V one of 2.51 V; 1.4 V just fires.
BIASES = (Bias("v_threshold", "v_threshold", "voltage", 1.5), *generator_biases("generator"))


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports envelope (analog in), spike (event out), biases and the supply."""
    generator = spike_generator(
        GeneratorParams(
            refractory_capacitance=params.refractory_capacitance,
            refractory_resistance=params.refractory_resistance,
        )
    )
    connections = generator.wired(v_in="envelope")
    ports = (
        SUPPLY,
        Port("envelope", "analog"),
        Port("spike", "event", "out"),
        *(Port(b.port, "bias") for b in BIASES),
    )
    return Circuit(
        "high_threshold_neuron", ports, (), (Instance("generator", generator, connections),), biases=BIASES
    )


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Trapezoids of the envelope on its pedestal, at 0.5 ms and `delay` later."""
    return envelope_testbench("high-threshold neuron", circuit, stimuli, v_dd)


def measures(result: Result) -> dict[str, float | None]:
    """`latency_s`, `interval_s`, `spike_width_s`, `margin_V` (of the envelope), `supply_power_W`."""
    return spike_measures(result, "envelope", "v_threshold")


BLOCK = Block(
    name="high-threshold-neuron",
    summary="single spike when the envelope passes a threshold that only the call reaches",
    params=Params,
    build=build,
    stimuli=sound_stimuli(2.2),
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("envelope", "spike"),
)
