"""Circuits of ensembles that Stöckel (2017) builds brains from: basal ganglia and an oscillator.

Basal ganglia select the action of the largest salience (Stewart, Choo and Eliasmith 2010, after Gurney,
Prescott and Redgrave 2001): D1 and D2 neurons of the striatum and the subthalamic nucleus get saliences, the
internal pallidus is silent for the action that is selected and fires for all others. All pass
max(0, x - threshold), the weights and thresholds are the source's; 2 ms for excitation, 8 ms for inhibition.

The oscillator turns a vector on the unit circle, dx/dt = 2 pi f R x + k x (1 - |x|^2).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Function, Network, Neurons
from circuits.arrays import F64

# of the basal ganglia: thresholds of each nucleus and weights between them
D, STN, GPE, GPI = 0.2, -0.25, -0.2, -0.2
W_D1, W_D2, W_STN = 1.2, 0.8, 1.0  # w_s (1 + l_g), w_s (1 - l_e), w_t
W_P, W_E, W_M, W_G = 0.9, 0.3, 1.0, 1.0
EXCITES, INHIBITS = 0.002, 0.008  # s
STRETCH = 1.5  # radius of its ensembles

RESTORING = 4.0  # /s, k of the oscillator; ours
OSCILLATOR_SYNAPSE = 0.1  # s; ours
SUPPRESSION = 500.0  # current into neurons that are to be silent, whatever excites them; ours
QUIET = 50.0  # the same where inputs stay in the radius, which excite by less than 40; ours


def basal_ganglia(name: str, actions: int, neurons: int) -> Network:
    """Return a network that selects among actions, with `neurons` an action in each of five nuclei."""

    def nucleus(part: str, threshold: float) -> EnsembleArray:
        each = Ensemble(
            f"{name}.{part}",
            neurons,
            radius=STRETCH,
            intercepts=(threshold / STRETCH, 0.95),
            encoders=((1.0,),),
        )
        return EnsembleArray(each, actions)

    def joined(pre: str, post: str, transform: ArrayLike, synapse: float) -> Connection:
        threshold = {"d1": D, "d2": D, "stn": STN, "gpe": GPE}[pre]
        return Connection(f"{name}.{pre}", f"{name}.{post}", above(threshold), transform, synapse)

    every = np.ones((actions, actions))
    return Network(
        (nucleus("d1", D), nucleus("d2", D), nucleus("stn", STN), nucleus("gpe", GPE), nucleus("gpi", GPI)),
        connections=(
            joined("d1", "gpi", -W_M, INHIBITS),
            joined("d2", "gpe", -W_M, INHIBITS),
            joined("stn", "gpi", W_P * every, EXCITES),
            joined("stn", "gpe", W_P * every, EXCITES),
            joined("gpe", "gpi", -W_E, INHIBITS),
            joined("gpe", "stn", -W_G, INHIBITS),
        ),
    )


def saliences(
    pre: str, name: str, transform: ArrayLike, synapse: float, function: Function | None = None
) -> tuple[Connection, ...]:
    """Return what tells the basal ganglia `name` how salient actions are, a transform of `pre`."""
    given = np.asarray(transform, dtype=float)
    return tuple(
        Connection(pre, f"{name}.{part}", function, weight * given, synapse)
        for part, weight in (("d1", W_D1), ("d2", W_D2), ("stn", W_STN))
    )


def unless_selected(name: str, action: int, actions: int, post: str) -> Connection:
    """Return what silences the neurons of `post` unless the basal ganglia `name` select this action."""
    only = np.zeros((1, actions))
    only[0, action] = -QUIET / -GPI
    return Connection(f"{name}.gpi", Neurons(post), above(GPI), only, INHIBITS)


def above(threshold: float) -> Function:
    """Return the function max(0, x - threshold)."""
    return lambda x: np.maximum(x - threshold, 0.0)


def oscillator(name: str, neurons: int, frequency: float) -> Network:
    """Return a network whose vector turns on the unit circle; frequency: Hz."""
    turn = 2.0 * math.pi * frequency * np.array([[0.0, -1.0], [1.0, 0.0]])

    def back(x: F64) -> F64:
        rate = np.einsum("nd,ed->ne", x, turn) + RESTORING * x * (1.0 - (x**2).sum(axis=1, keepdims=True))
        return np.asarray(x + OSCILLATOR_SYNAPSE * rate)

    ensemble = Ensemble(name, neurons, 2, radius=1.2)
    return Network((ensemble,), connections=(Connection(name, name, back, synapse=OSCILLATOR_SYNAPSE),))
