"""The published spike-latency network, neuron by neuron: Wen & Horiuchi 2022, section 3, Figures 6 to 8.

The paper gives 2,931 integrate-and-fire and 2,078 Hodgkin-Huxley neurons in all. This allocation adds up; it
is ours, as far as the text does not say it:

    integrate-and-fire: head map 471, five body maps 5 x 471, neurons that inhibit the maps 5, integrating
    33, first layer 33, second layer 33, emergency 1;
    Hodgkin-Huxley: 33 memories x 15 units x (A, B, CD, INH), delay line 15, output 33, body motor 33, head
    motor 5, recency 5, delay of the ping's direction 5, recurrent inhibition 2.

Ping onset, direction of the ping, echoes, goal and reset are given spikes. The added delays (7) are delays of
synapses. A recency neuron spikes tonically and inhibits the body motors of its group; a ping in its direction
silences it for a while, which is the recency memory.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64
from system.openspace.law import ARCS, DIRECTIONS, Arcs
from system.spiking_bat.maps import blocking, places
from system.spiking_bat.network.network import (
    Conductors,
    Inputs,
    Integrators,
    Network,
    Population,
    Projection,
    wire,
)
from system.spiking_bat.numbers import DIRECTION_PRIORITY, Numbers

CUT = 3.0  # standard deviations at which the inhibition of the first layer ends; the paper's
_ONCE = math.inf  # refractory, or on, until the next ping


def published(arcs: Arcs, numbers: Numbers) -> Network:
    """Return the network of a bat's arcs."""
    return wire(populations(arcs, numbers), projections(arcs, numbers), release="onset")


def projections(arcs: Arcs, numbers: Numbers) -> list[Projection]:
    """Return all synapses of the network."""
    return [
        *_sensory(arcs, numbers),
        *_memory(numbers),
        *_selection(arcs, numbers),
        *_motors(arcs, numbers),
    ]


def populations(arcs: Arcs, s: Numbers) -> dict[str, Population]:
    """Return all neurons and inputs of the network by name."""
    n, memory = len(places()), (ARCS, s.taps)
    passive = passive_current(arcs, s)
    return {
        "a": Conductors(memory, s.tau_drive),
        "b": Conductors(memory, s.tau_drive, s.tau_block),
        "cd": Conductors(memory, s.tau_coincidence),
        "inh": Conductors(memory, s.tau_hold, s.tau_hold, s.tonic),
        "tap": Conductors((s.taps,), s.tau_drive),
        "out": Conductors((ARCS,), s.tau_drive),
        "body": Conductors((ARCS,), s.tau_drive, s.tau_block),
        "head": Conductors((DIRECTIONS,), s.tau_drive),
        "recency": Conductors((DIRECTIONS,), s.tau_drive, s.tau_recent, s.tonic),
        "aim": Conductors((DIRECTIONS,), s.tau_drive),
        "rin": Conductors((2,), s.tau_drive),
        "head_map": Integrators((n,), s.leak),
        "body_map": Integrators((DIRECTIONS, n), s.leak),
        "map_inh": Integrators((DIRECTIONS,), s.leak),
        "integrating": Integrators((ARCS,), refractory=_ONCE, released=True),
        "wta1": Integrators((ARCS,), drive=passive, refractory=_ONCE, released=True),
        "wta2": Integrators((ARCS,), refractory=_ONCE, released=True),
        "emergency": Integrators((1,), drive=1.0 / s.emergency, refractory=_ONCE, released=True),
        "onset": Inputs((1,)),
        "ping": Inputs((DIRECTIONS,)),
        "echo": Inputs((n,)),
        "goal": Inputs((ARCS,)),
        "reset": Inputs((1,)),
    }


def passive_current(arcs: Arcs, s: Numbers) -> F64:
    """I_exc of the first layer's neurons, thresholds a second, float64[ARCS]."""
    share = arcs.curvature / np.abs(arcs.curvature).max()
    return np.asarray((1.0 - s.sharp_turn_cost * share**2) / s.race)


def suppression(s: Numbers) -> F64:
    """I_i that a memory (row) turns on in a neuron of the first layer (column), thresholds a second."""
    apart = np.abs(np.subtract.outer(np.arange(ARCS), np.arange(ARCS)))
    weight = np.exp(-(apart**2) / (2.0 * s.suppression_sigma**2))
    weight[apart > CUT * s.suppression_sigma] = 0.0
    return np.asarray(s.suppression / s.race * weight)


def goal_charge(s: Numbers) -> F64:
    """Q_goal that a goal neuron (row) gives the first layer (column), thresholds; the analog model's form."""
    apart = np.subtract.outer(np.arange(ARCS), np.arange(ARCS))
    return np.asarray(s.goal * np.exp(-(apart**2) / s.goal_sigma**2))


def layer_delays(s: Numbers) -> F64:
    """Delay of the second layer in each group, s, float64[DIRECTIONS]."""
    delays = np.empty(DIRECTIONS)
    delays[list(DIRECTION_PRIORITY)] = s.first + s.between * np.arange(DIRECTIONS)
    return delays


def _sensory(arcs: Arcs, s: Numbers) -> list[Projection]:
    """Echoes, maps, and their inhibition, to the integrating neurons."""
    n = len(places())
    every = np.arange(n)
    maps = np.arange(DIRECTIONS)[:, None]
    pinged, other = np.nonzero(~np.eye(DIRECTIONS, dtype=bool))
    found = blocking(arcs, places(), s.constant_delay)
    return [
        Projection("echo", "echo", "head_map", (every, every), s.sensory, hold=s.relay),
        Projection("to maps", "head_map", "body_map", (every, maps * n + every), s.sensory, hold=s.relay),
        Projection("not pinged", "ping", "map_inh", (pinged, other), s.sensory, hold=s.relay),
        Projection("silence", "map_inh", "body_map", (maps, maps * n + every), -s.silence, hold=s.silent),
        Projection(
            "to memories", "body_map", "integrating", (found.direction * n + found.place, found.arc),
            1.0 / s.integration, found.delay, s.step_current,
        ),
    ]  # fmt: skip


def _memory(s: Numbers) -> list[Projection]:
    """Delay line and latency units."""
    every = np.arange(ARCS * s.taps)
    arc, unit = every // s.taps, every % s.taps
    tap = np.arange(s.taps - 1)
    hop = s.tap_delay - s.drive_latency
    pair = s.coincidence
    return [
        Projection("ping to delay line", "onset", "tap", (0, 0), s.drive, hop),
        Projection("delay line", "tap", "tap", (tap, tap + 1), s.drive, hop),
        Projection("tap to A", "tap", "a", (unit, every), s.drive),
        Projection("tap to B", "tap", "b", (unit, every), s.drive),
        Projection("A to CD", "a", "cd", (every, every), pair),
        Projection("B to CD", "b", "cd", (every, every), pair),
        Projection("integrating to CD", "integrating", "cd", (arc, every), pair),
        Projection("CD to INH", "cd", "inh", (every, every), -s.hold),
        Projection("INH to B", "inh", "b", (every, every), -s.block),
        Projection("reset", "reset", "inh", (0, every), s.reset),
        Projection("CD to output", "cd", "out", (every, arc), s.drive),
    ]


def _selection(arcs: Arcs, s: Numbers) -> list[Projection]:
    """Both layers that race to the first spike, and the emergency neuron."""
    every = np.arange(ARCS)
    slow = suppression(s)
    memory, target = np.nonzero(slow)
    group = arcs.group
    goal = goal_charge(s)
    each, to = np.nonzero(goal > 0.0)
    direction = np.arange(DIRECTIONS)
    stop = -s.inhibit
    return [
        Projection("memory", "out", "wta1", (memory, target), -slow[memory, target], hold=_ONCE),
        Projection("goal", "goal", "wta1", (each, to), goal[each, to] / s.pulse, s.goal_delay, s.pulse),
        Projection("to aim", "ping", "aim", (direction, direction), s.drive, s.direction_delay),
        Projection("aim", "aim", "wta1", (group, every), s.direction / s.pulse, hold=s.pulse),
        Projection("race", "wta1", "rin", (every, 0), s.recurrent),
        Projection("stop", "rin", "wta1", (0, every), stop, hold=_ONCE),
        Projection("no emergency", "rin", "emergency", (0, 0), stop, hold=_ONCE),
        Projection("emergency", "emergency", "rin", (0, 0), s.recurrent),
        Projection("second", "wta1", "wta2", (every, every), 1.0 / layer_delays(s)[group], hold=_ONCE),
        Projection("second race", "wta2", "rin", (every, 1), s.recurrent),
        Projection("second stop", "rin", "wta2", (1, every), stop, hold=_ONCE),
    ]


def _motors(arcs: Arcs, s: Numbers) -> list[Projection]:
    """Motors of head and body, and the recency that lets the body's through."""
    every, direction = np.arange(ARCS), np.arange(DIRECTIONS)
    return [
        Projection("head", "wta2", "head", (every, arcs.group), s.drive),
        Projection("body", "wta2", "body", (every, every), s.drive),
        Projection("recent ping", "ping", "recency", (direction, direction), -s.recent),
        Projection("not recent", "recency", "body", (arcs.group, every), -s.block),
    ]
