"""Networks of a working memory that can be stopped, and of a state machine (Stöckel 2017).

Memory: `stored` integrates the `difference` between what is to be learnt and what is stored, and holds it
while the neurons of the difference are silent:

    d stored / dt = rate (input - stored)

Its `done` neurons fire while the difference is small and not silenced.

States are points on the unit circle. `old` and `current` are attractors. While the `trigger` is low `old`
follows `current`; while it is high `old` keeps what it has, and `current` is driven to the state that comes
after it in the table: one transition a rising edge. The activity of each state, low-passed, passes neurons
with hysteresis, and is inverted: `inactive` neurons fire for every state but one, and silence its behaviour.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chips.nef.network.circuits import SUPPRESSION
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Function, Network, Neurons
from circuits.arrays import F64

FITTED = 4000  # points where what draws to the circle is fitted; ours
LONGEST = 1.1  # that is stored; ours
STEEPNESS = 8.0  # of an attractor's choice between states; ours
PULL = 2.0  # weight of what drives `current` and `old` against their own attractors, 1; ours
STATE_SYNAPSE = 0.05  # s; ours
HOLDING = 0.01  # regularisation of what holds a memory, which drifts by what it is off; ours
DONE_SYNAPSE = 0.1  # s, so that a difference that is only beginning does not count as small; ours
CLEAN_UP = 0.1  # s, the low-pass before the hysteresis; ours
ON, OFF = 0.7, 0.3  # activity at which a state begins and ceases to be active; ours


@dataclass(frozen=True, slots=True)
class MemorySize:
    """Neurons of a memory's parts, and its constants.

    rate: 1/s; synapse: of what is stored, s; reach: largest difference that is represented, so that larger
    ones are learnt at a constant speed; near: difference below which it is done; circle: how strongly what is
    stored, a direction, is drawn to length 1, 0 for not at all; holding: regularisation of what holds it.
    """

    stored: int
    difference: int
    done: int
    reach: float
    near: float
    rate: float = 2.0
    synapse: float = 0.1
    circle: float = 0.0
    holding: float = HOLDING


@dataclass(frozen=True, slots=True)
class StateSize:
    """Neurons of a state machine's parts.

    state: of the old and of the current state each; gate: of both gates each; trigger: of it and its
    inversion each; active, inactive: of hysteresis and inversion, a state.
    """

    state: int
    gate: int
    trigger: int
    active: int
    inactive: int


def memory(name: str, dimensions: int, size: MemorySize) -> Network:
    """Return a memory with the parts `name.stored`, `name.difference` and `name.done`.

    The input goes to the difference.
    """
    stored, difference, done = f"{name}.stored", f"{name}.difference", f"{name}.done"
    return Network(
        (
            Ensemble(stored, size.stored, dimensions, radius=LONGEST),
            Ensemble(difference, size.difference, dimensions, radius=size.reach),
            threshold_neurons(done, size.done),
        ),
        connections=(
            _holding(stored, dimensions, size),
            Connection(stored, difference, transform=-1.0),
            Connection(difference, stored, transform=size.rate * size.synapse, synapse=size.synapse),
            Connection(difference, done, near(size.near), synapse=DONE_SYNAPSE),
        ),
    )


def _holding(stored: str, dimensions: int, size: MemorySize) -> Connection:
    """What keeps a memory as it is; it is fitted near the circle if it draws there."""
    if size.circle == 0.0:
        return Connection(stored, stored, synapse=size.synapse, regularisation=size.holding)
    random = np.random.default_rng(0)  # of points that differ from one network to another by nothing
    ray = random.normal(size=(FITTED, dimensions))
    length = np.where(
        np.arange(FITTED) % 4, random.uniform(0.75, 1.15, FITTED), random.uniform(0.0, 1.0, FITTED)
    )
    points = ray * (length / np.sqrt((ray**2).sum(axis=1)))[:, None]

    def drawn(x: F64) -> F64:
        return np.asarray(x * (1.0 + size.circle * (1.0 - (x**2).sum(axis=1, keepdims=True))))

    return Connection(stored, stored, drawn, 1.0, size.synapse, points, size.holding)


def near(distance: float) -> Function:
    """Return a function of a length that is 1 at 0, 0.5 at `distance` and negative beyond.

    It is a parabola, which neurons can decode.
    """
    return lambda x: 1.0 - 0.5 * (x**2).sum(axis=1, keepdims=True) / distance**2


def threshold_neurons(name: str, neurons: int, threshold: float = 0.4) -> Ensemble:
    """Return neurons that are silent below a threshold, so that what they tell is exactly 0 there."""
    return Ensemble(name, neurons, radius=1.2, intercepts=(threshold / 1.2, 0.7), encoders=((1.0,),))


def is_above(threshold: float) -> Function:
    """Return a function that is 1 above the threshold, else 0."""
    return lambda x: np.where(x > threshold, 1.0, 0.0)


def states(count: int) -> F64:
    """Return the points of the states, float64[count, 2]."""
    angle = 2.0 * math.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def choice(x: F64, points: F64) -> F64:
    """Return the share of each state, softly 1 for the nearest, float64[n, states]; x: float64[n, d]."""
    weight = np.exp(STEEPNESS * (np.einsum("nd,sd->ns", x, points)))
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))


def apart(count: int) -> F64:
    """Return unit vectors equally far from each other for states, a simplex, float64[count, count - 1]."""
    away = np.eye(count) - 1.0 / count
    flat = away @ np.linalg.svd(away)[2][: count - 1].T
    return np.asarray(flat / np.sqrt((flat**2).sum(axis=1))[:, None])


def state_machine(name: str, following: Sequence[int], size: StateSize, points: F64) -> Network:
    """States k at points[k], after each of which comes following[k].

    `name.trigger` gets the sum of all signals that a state is over; `name.old`, `name.current` get a state's
    point at the start; `name.inactive` is an array, a number a state. A node `one` must give 1.
    """
    dimensions = points.shape[1]
    after = points[np.asarray(following)]

    def attractor(x: F64) -> F64:
        return np.asarray(np.einsum("ns,sd->nd", choice(x, points), points))

    def activity(x: F64) -> F64:
        return choice(x, points)

    def part(which: str) -> str:
        return f"{name}.{which}"

    stay = ON - OFF
    held = (Ensemble(part(p), size.state, dimensions, radius=1.5) for p in ("old", "current"))
    gates = (Ensemble(part(p), size.gate, dimensions) for p in ("copy", "advance"))
    active = Ensemble(part("active"), size.active, radius=1.5, intercepts=(0.0, 0.9), encoders=((1.0,),))
    return Network(
        (
            *held,
            *gates,
            threshold_neurons(part("trigger"), size.trigger),
            threshold_neurons(part("idle"), size.trigger),
            EnsembleArray(active, len(following)),
            EnsembleArray(threshold_neurons(part("inactive"), size.inactive), len(following)),
        ),
        connections=(
            Connection(part("old"), part("old"), attractor, synapse=STATE_SYNAPSE),
            Connection(part("current"), part("current"), attractor, synapse=STATE_SYNAPSE),
            Connection(part("current"), part("copy")),
            Connection(part("copy"), part("old"), transform=PULL, synapse=STATE_SYNAPSE),
            Connection(
                part("old"), part("advance"), lambda x: np.einsum("ns,sd->nd", choice(x, points), after)
            ),
            Connection(part("advance"), part("current"), transform=PULL, synapse=STATE_SYNAPSE),
            Connection("one", part("idle")),
            Connection(part("trigger"), part("idle"), is_above(0.5), -2.0),
            Connection(part("trigger"), Neurons(part("copy")), is_above(0.5), -SUPPRESSION),
            Connection(part("idle"), Neurons(part("advance")), is_above(0.5), -SUPPRESSION),
            Connection(part("current"), part("active"), activity, synapse=CLEAN_UP),
            Connection(part("active"), part("active"), is_above(ON), stay, synapse=0.02),
            Connection("one", part("inactive"), transform=[[1.0]] * len(following)),
            Connection(part("active"), part("inactive"), is_above(ON), -2.0),
        ),
    )


def unless_active(name: str, state: int, count: int, post: str) -> Connection:
    """Return what silences the neurons of `post` unless the state machine `name` is in this state."""
    only = np.zeros((1, count))
    only[0, state] = -SUPPRESSION
    return Connection(f"{name}.inactive", Neurons(post), is_above(0.5), only)
