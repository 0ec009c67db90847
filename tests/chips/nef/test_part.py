"""A network in the event loop is its simulation, to the bit."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.network.network import Connection, Ensemble, Network, Node, Probe
from chips.nef.part import NefPart
from chips.nef.simulation import Simulation
from chips.noise import SiliconNoise
from chips.part import Part
from circuits.errors import UnknownNameError
from system.loop import AnalogWire, Loop
from tests.chips.looped import Script
from tests.chips.nef.paper import paper_chip


def network(noise: SiliconNoise | None = None) -> Any:
    """A value and its square, on a die of the NEF chip."""
    net = Network(
        (Ensemble("x", 40), Ensemble("square", 40)),
        (Node("in", 2), Node("clock", 1, output=lambda t, _: [t])),
        (Connection("in", "x", transform=[[1.0, 0.5]]), Connection("x", "square", np.square)),
        (Probe("x?", "x", synapse=0.02), Probe("square?", "square", synapse=0.02)),
    )
    return build(net, paper_chip(noise=noise).at(27.0), 1)


@pytest.mark.parametrize("noise", [None, SiliconNoise(seed=4)])
def test_a_network_in_the_loop_is_the_simulation(noise: SiliconNoise | None) -> None:
    built = network(noise)
    line = np.array([0.0, 0.1]), np.array([-0.8, 0.9])
    part = NefPart(built, ("x?", "square?"), interval=2e-3)
    parts: dict[str, Part[Any]] = {"script": Script((), line), "part": part}
    loop = Loop(parts, [], [AnalogWire("script", "line", "part", "in[1]", tolerance=0.0)], horizon=3.3e-3)
    run, shown = Simulation(built, 2e-3), []
    while loop.time < 0.1:
        shown += list(loop.step(0.1).outputs["part"].voltage[1:])
        loop.states["part"] = pickle.loads(pickle.dumps(loop.states["part"]))
    for k in range(50):
        run.set("in", [0.0, np.interp(2e-3 * k, *line)])
        run.advance(2e-3)
    state = loop.states["part"]
    assert state.intervals == 50
    np.testing.assert_array_equal(state.simulation.base.spikes, run.state.spikes)
    assert run.spikes > 100
    np.testing.assert_array_equal(shown[-1], [*run.read("x?"), *run.read("square?")])
    assert part.analog == ("x?[0]", "square?[0]")


def test_a_network_knows_its_nodes_and_probes() -> None:
    built = network()
    with pytest.raises(UnknownNameError, match="nef_chip probe y"):
        NefPart(built, ("y",))
    part = NefPart(built, ("x?",))
    line = np.zeros(1), np.zeros(1)
    with pytest.raises(UnknownNameError, match="nef_chip node out: unknown; known are clock, in"):
        part.advance(part.begin(), 1e-3, (), {"out[0]": line})
    with pytest.raises(UnknownNameError, match="nef_chip event port spike"):
        part.advance(part.begin(), 1e-3, [("spike", 0.0)])
