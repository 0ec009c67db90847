"""Brains of neurons: a network between the senses and the motor, 10 ms at a time (Stöckel 2017, III.A)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, final

import numpy as np

from chips.nef.build import Built
from chips.nef.network.memory import apart, states
from chips.nef.network.network import Network
from chips.nef.simulation import Simulation
from circuits.arrays import F64, I64
from circuits.errors import ParameterError, unknown_name
from system.bug import neural0 as bug_neural0
from system.bug import neural2 as bug_neural2
from system.bug.body import STEP, Senses
from system.bug.brain import FOLLOW, GO, MEMORISE, STATES, nearness

Nodes = Mapping[str, Callable[[Senses], float | F64]]

SETTLING = 0.3  # s; ours
FEWEST, MOST = 300, 40_000  # neurons of a network; ours
_NODES: Nodes = {
    "ranges": lambda senses: nearness(senses.ranges),
    "ahead": lambda senses: senses.ahead,
    "touch": lambda senses: senses.contact,
}


@final
class NeuralBrain:
    """A brain of neurons: what is sensed goes to the nodes of its network, and its motor steers.

    A network remembers neither its map nor where it hit a wall, so that it never finds out that the goal
    cannot be reached.

    Parameters
    ----------
    built : the network on its neurons.
    nodes : by the names of the network's nodes, what each is told of the senses.
    first : the state at time 0, one of `STATES`.
    read : reads the state off the simulation.
    begin : is called once the senses of time 0 are set, before the first 10 ms.
    """

    __slots__ = ("_began", "_begin", "_nodes", "_read", "simulation", "state", "verdict")

    def __init__(
        self, built: Built, nodes: Nodes, first: str, read: Callable[[Simulation], str],
        begin: Callable[[Simulation], None],
    ) -> None:  # fmt: skip
        self.simulation, self.state, self.verdict = Simulation(built, STEP), first, ""
        self._nodes, self._read, self._begin = nodes, read, begin
        self._began = 0.0
        self.simulation.set("one", 1.0)

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""
        run = self.simulation
        for node, told in self._nodes.items():
            run.set(node, told(senses))
        if run.time == 0.0:
            self._begin(run)
            self._began = run.time
        run.advance(STEP)
        self.state = self._read(run)
        return run.read("motor?")

    def spikes(self) -> tuple[F64, I64]:
        """Return the spikes that its simulation kept from time 0 of the run on: times, s, and neurons."""
        times, neurons = self.simulation.recorded()
        since = times - self._began
        return since[since > 0.0], neurons[since > 0.0]


def bug0_brain(built: Built) -> NeuralBrain:
    """Bug 0 on the neurons of a network of `system.bug.neural0`."""

    def read(run: Simulation) -> str:
        blocked = run.read("selected?")
        return FOLLOW if blocked[1] < blocked[0] else GO

    return NeuralBrain(built, _NODES, GO, read, lambda _: None)


def bug2_brain(built: Built) -> NeuralBrain:
    """Bug 2 on the neurons of a network of `system.bug.neural2`.

    It is held in its first state for `SETTLING` s before time 0.
    """
    circle = built.network.node("start").size_out == 2
    points = states(len(STATES)) if circle else apart(len(STATES))

    def begin(run: Simulation) -> None:
        run.set("start", points[STATES.index(MEMORISE)])
        run.advance(SETTLING)
        run.set("start", 0.0)

    def read(run: Simulation) -> str:
        return STATES[int(np.argmax(run.read("state?")))]

    nodes = {**_NODES, "north": lambda senses: senses.north, "distance": lambda senses: senses.distance}
    return NeuralBrain(built, nodes, MEMORISE, read, begin)


def network_of(agent: str, design: str = "published", neurons: int | None = None) -> Network:
    """Return the network of an agent; `neurons` is how many in all, about, the design's unless given.

    Raises `UnknownNameError` for a design, `ParameterError` for an agent without one, or too few neurons.
    """
    known: dict[str, dict[str, Any]] = {
        "bug0": {"published": bug_neural0.PUBLISHED},
        "bug2": {**bug_neural2.DESIGNS},
    }
    if agent not in known:
        raise ParameterError(f"agent: {agent}, has no network; use `brain=reference`, or bug0 or bug2")
    if design not in known[agent]:
        raise unknown_name(f"design of {agent}", design, known[agent])
    if neurons is not None and not FEWEST <= neurons <= MOST:
        raise ParameterError(f"neurons: {neurons}, must be from {FEWEST} to {MOST}")
    size = known[agent][design]
    make: Any = {"bug0": bug_neural0.bug0_network, "bug2": bug_neural2.bug2_network}[agent]
    network: Network = make(size)
    return network if neurons is None else make(size.scaled(neurons / network.neurons))


def neural_brain(agent: str, built: Built) -> NeuralBrain:
    """Brain of an agent on its network."""
    return bug0_brain(built) if agent == "bug0" else bug2_brain(built)
