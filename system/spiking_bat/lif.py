"""The spike-latency network built of integrate-and-fire neurons alone, with the same synapses.

The paper: Hodgkin-Huxley neurons are not necessary, "the proposed network can produce similar results using
simpler neural models", and gives no numbers of it. Here each of the 2,078 becomes an integrate-and-fire
neuron, and each synapse on it one of these, all numbers ours, so that spikes come when the others' do:

    relay       a box that makes its target spike within 0.06 ms, later by what a driving synapse takes
    charge      0.68 of a threshold, of a coincidence detector that leaks: two within 3 ms are one and more
    silence     a box of inhibition that nothing but a reset outweighs, as long as the conductance's effect
    excitation  of a reset, more than all that silences

INH blocks B for 60 ms a spike, longer than a ping's taps, because a reset can end no box: it makes INH spike
once, and what that blocks has to last until the next ping's taps are through.

Source: Wen & Horiuchi 2022, section 4.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from system.openspace.law import Arcs
from system.spiking_bat.network.network import Conductors, Integrators, Network, Population, Projection, wire
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.topology import populations, projections

_RELAY, _BRIEF = 2e4, 0.1e-3  # thresholds/s for s; spikes in the third step of 0.02 ms
_SPIKES_AFTER = 0.06e-3  # s
_DETECTOR = 2.3e-3  # s from the second spike to a Hodgkin-Huxley detector's; measured
_RECURRENT = 1.3e-3  # s, of a recurrent inhibitory neuron; measured
_SILENCE, _RESET = 1e6, 1e8  # thresholds/s
_WINDOW, _WEAK = 3e-3, 0.68  # s, thresholds


@dataclass(frozen=True, slots=True)
class Synapse:
    """A box of a current (thresholds/s) for `hold` s, `later` (s) than the projection's own delay."""

    weight: float
    hold: float
    later: float = 0.0


def all_lif(arcs: Arcs, numbers: Numbers) -> Network:
    """The network of a bat's arcs, every neuron integrating and firing."""
    table = synapses(numbers)
    pools = {name: _as_integrators(name, p, numbers) for name, p in populations(arcs, numbers).items()}
    wired = [_replaced(p, table) for p in projections(arcs, numbers)]
    return wire(pools, wired, release="onset")


def synapses(s: Numbers) -> dict[str, Synapse]:
    """What stands for each projection to a Hodgkin-Huxley neuron, by its name."""
    relay = Synapse(_RELAY, _BRIEF, s.drive_latency - _SPIKES_AFTER)
    charge = Synapse(_WEAK / _BRIEF, _BRIEF)
    stop = Synapse(_RELAY, _BRIEF, _RECURRENT - _SPIKES_AFTER)
    relays = "ping to delay line", "delay line", "tap to A", "tap to B", "to aim", "head", "body"
    return {
        **dict.fromkeys(relays, relay),
        **dict.fromkeys(("A to CD", "B to CD", "integrating to CD"), charge),
        **dict.fromkeys(("race", "emergency", "second race"), stop),
        "CD to INH": Synapse(-_SILENCE, s.lif_hold),
        "INH to B": Synapse(-_SILENCE, s.lif_block),
        "reset": Synapse(_RESET, _BRIEF),
        "CD to output": replace(relay, later=relay.later + _DETECTOR),
        "recent ping": Synapse(-_SILENCE, s.lif_recent),
        "not recent": Synapse(-_SILENCE, s.lif_gate),
    }


def _as_integrators(name: str, population: Population, s: Numbers) -> Population:
    """The population, or what stands for it."""
    if not isinstance(population, Conductors):
        return population
    if name == "cd":
        # 0.68 (1 + e^(-leak window)) = 1
        return Integrators(population.shape, -math.log(1.0 / _WEAK - 1.0) / _WINDOW, refractory=5e-3)
    drive = 1.0 / s.lif_tonic if population.current > 0.0 else 0.0
    return Integrators(population.shape, 0.0 if drive else s.leak, drive)


def _replaced(projection: Projection, table: dict[str, Synapse]) -> Projection:
    """The projection, or what stands for it."""
    if projection.name not in table:
        return projection
    synapse = table[projection.name]
    delay = projection.delay + synapse.later
    return replace(projection, weight=synapse.weight, delay=delay, hold=synapse.hold)
