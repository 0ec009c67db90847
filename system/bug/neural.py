"""Brains of neurons: a network between the senses and the motor, 10 ms at a time (Stöckel 2017, III.A)."""

from __future__ import annotations

from typing import Any

import numpy as np

from chips.nef.build import Built
from chips.nef.network.memory import apart, states
from chips.nef.network.network import Network
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.errors import ParameterError, unknown_name
from system.bug import neural0 as bug_neural0
from system.bug import neural2 as bug_neural2
from system.bug.body import STEP, Senses
from system.bug.brain import FOLLOW, GO, MEMORISE, STATES, nearness

SETTLING = 0.3  # s; ours
FEWEST, MOST = 300, 40_000  # neurons of a network; ours


class NeuralBug0:
    """Bug 0 on neurons; see `bug_neural0`."""

    __slots__ = ("simulation", "state")

    def __init__(self, built: Built) -> None:
        self.simulation, self.state = Simulation(built, STEP), GO
        self.simulation.set("one", 1.0)

    @property
    def verdict(self) -> str:
        """Nothing: it has no memory."""
        return ""

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""
        run = self.simulation
        run.set("ranges", nearness(senses.ranges))
        run.set("ahead", senses.ahead)
        run.set("touch", senses.contact)
        run.advance(STEP)
        blocked = run.read("selected?")
        self.state = FOLLOW if blocked[1] < blocked[0] else GO
        return run.read("motor?")


class NeuralBug2:
    """Bug 2 on neurons; see `bug_neural2`. It is held in its first state for `SETTLING` s before time 0."""

    __slots__ = ("_points", "simulation", "state")

    def __init__(self, built: Built) -> None:
        self.simulation, self.state = Simulation(built, STEP), MEMORISE
        circle = built.network.node("start").size_out == 2
        self._points = states(len(STATES)) if circle else apart(len(STATES))
        self.simulation.set("one", 1.0)

    @property
    def verdict(self) -> str:
        """Nothing: it does not remember where it hit a wall."""
        return ""

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""
        run = self.simulation
        run.set("ranges", nearness(senses.ranges))
        run.set("ahead", senses.ahead)
        run.set("north", senses.north)
        run.set("distance", senses.distance)
        run.set("touch", senses.contact)
        if run.time == 0.0:
            run.set("start", self._points[STATES.index(MEMORISE)])
            run.advance(SETTLING)
            run.set("start", 0.0)
        run.advance(STEP)
        self.state = STATES[int(np.argmax(run.read("state?")))]
        return run.read("motor?")


def network_of(agent: str, design: str = "published", neurons: int | None = None) -> Network:
    """Network of an agent; neurons: how many in all, about, those of the design unless given.

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


def neural_brain(agent: str, built: Built) -> NeuralBug0 | NeuralBug2:
    """Brain of an agent on its network."""
    return NeuralBug0(built) if agent == "bug0" else NeuralBug2(built)
