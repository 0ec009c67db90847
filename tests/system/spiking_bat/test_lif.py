"""The network of integrate-and-fire neurons alone: its size, and all that Figure 12 says of the other."""

import math

import pytest

from system.openspace.law import Bat, arcs_of
from system.papers.wen2022.fig12 import rows
from system.spiking_bat.lif import all_lif, synapses
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.scene import tell
from system.spiking_bat.topology import projections, published

ARCS, S = arcs_of(Bat(ping_rate=10.0)), Numbers()


def test_every_neuron_is_there_and_integrates() -> None:
    network, other = all_lif(ARCS, S), published(ARCS, S)
    assert (network.wiring.conductors, network.wiring.decay.size) == (0, 2931 + 2078)
    assert network.wiring.target.size == other.wiring.target.size


def test_every_synapse_of_a_conductor_is_replaced() -> None:
    targets = {"a", "b", "cd", "inh", "tap", "out", "body", "head", "recency", "aim", "rin"}
    named = {p.name for p in projections(ARCS, S) if p.target in targets}
    assert named == set(synapses(S))


def test_one_weak_input_does_not_spike_and_two_within_3_ms_do() -> None:
    charge = synapses(S)["A to CD"]
    one = charge.weight * charge.hold
    leak = -math.log(1.0 / one - 1.0) / 3e-3
    assert one < 1.0
    assert one * (1.0 + math.exp(-leak * 3e-3)) == pytest.approx(1.0)


def test_figure_12_goes_as_with_the_other_neurons() -> None:
    found = {row.name: row.agrees for row in rows(tell(build=all_lif))}
    sizes = ("integrate_and_fire_neurons", "hodgkin_huxley_neurons")
    assert [name for name, agrees in found.items() if not agrees and name not in sizes] == []
