"""Which virtual synapses an event of the sensor stimulates: the task of the Parallella (Milde et al. 2017).

Plain (section 2.4): an event of the lower half of the sensor goes to every neuron of the obstacle population
of its side, from columns 23 to 104: the paper's Figure 13 shows such a region "between two vertical lines",
the numbers are in the authors' notebook ("Basic Obstacle Avoidance"). Graded (section 3.4): neurons own four
columns each, so that it goes to one of them, the first neuron of a population to the edge. All columns count:
the weights take care of the periphery, and within 20 degrees of its heading a robot loses sight of what is
5 cm beside its way, which it is too wide to pass, from 14 cm before the lens on. An event of the upper half
goes to the neuron of the target field that owns its column (section 2.4.1). Each goes to `synapses` virtual
synapses of a neuron.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from chips.rolls.chip import Inputs
from chips.rolls.program.address import VIRTUAL_EXCITATORY
from chips.rolls.program.network import Network
from circuits.arrays import F64, I64
from system.worlds.camera.event import Events

Wiring = Literal["plain", "graded"]

ROWS, COLUMNS = 128, 128
HALF_ROWS, HALF_COLUMNS = ROWS // 2, COLUMNS // 2
EDGE = 23  # columns on either side that the plain obstacle populations do not see
KICK, KICK_RATE = 0.05, 1000.0  # s and 1/s: events that start exc; ours


def obstacle_inputs(network: Network, events: Events, wiring: Wiring, synapses: int) -> Inputs:
    """Inputs of the obstacle populations from the events of the lower half."""
    parts = []
    edge = EDGE if wiring == "plain" else 0
    inside = (events.y < HALF_ROWS) & (events.x >= edge) & (events.x < COLUMNS - edge)
    for name, sees in (("OL", events.x < HALF_COLUMNS), ("OR", events.x >= HALF_COLUMNS)):
        seen = np.flatnonzero(sees & inside)
        times, neurons = events.time[seen], np.array(network[name].neurons)
        if wiring == "plain":
            parts.append(to_all(times, neurons, synapses))
        else:
            outward = events.x[seen] if name == "OL" else COLUMNS - 1 - events.x[seen]
            place = outward * neurons.size // HALF_COLUMNS
            parts.append(fan_out(times, neurons[place], synapses))
    return merged(parts)


def target_inputs(network: Network, events: Events, synapses: int) -> Inputs:
    """Inputs of the target field from the events of the upper half."""
    neurons = np.array(network["target"].neurons)
    seen = np.flatnonzero(events.y >= HALF_ROWS)
    return fan_out(events.time[seen], neurons[events.x[seen] * neurons.size // COLUMNS], synapses)


def kick(network: Network, synapses: int) -> Inputs:
    """Inputs that start exc, from time 0 on, evenly for KICK s."""
    neurons = np.array(network["exc"].neurons)
    times = np.arange(round(KICK * KICK_RATE)) / KICK_RATE
    return to_all(times, neurons, synapses)


def to_all(times: F64, neurons: I64, synapses: int) -> Inputs:
    """At each time one event for the first `synapses` excitatory virtual synapses of every neuron."""
    one = fan_out(np.zeros(neurons.size), neurons, synapses)
    wide = (times.size, one.times.size)
    return Inputs(
        np.repeat(times, one.times.size),
        np.broadcast_to(one.neurons, wide).reshape(-1),
        np.broadcast_to(one.columns, wide).reshape(-1),
    )


def fan_out(times: F64, neurons: I64, synapses: int) -> Inputs:
    """One event each for the first `synapses` excitatory virtual synapses of the neurons."""
    columns = VIRTUAL_EXCITATORY + np.arange(synapses)
    return Inputs(np.repeat(times, synapses), np.repeat(neurons, synapses), np.tile(columns, times.size))


def merged(parts: list[Inputs]) -> Inputs:
    """Several inputs in order of time, those of one time in the order of the parts."""
    parts = [p for p in parts if p.times.size > 0] or parts[:1]
    if len(parts) == 1 and bool(np.all(parts[0].times[1:] >= parts[0].times[:-1])):
        return parts[0]
    times = np.concatenate([p.times for p in parts])
    order = np.argsort(times, kind="stable")
    return Inputs(
        times[order],
        np.concatenate([p.neurons for p in parts])[order],
        np.concatenate([p.columns for p in parts])[order],
    )
