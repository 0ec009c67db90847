"""Basal ganglia select the largest salience; the oscillator keeps its frequency and amplitude."""

from __future__ import annotations

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.network.circuits import basal_ganglia, oscillator, saliences, unless_selected
from chips.nef.network.curves import IdealCurves
from chips.nef.network.network import Ensemble, Network, Node, Probe, join
from chips.nef.simulation import Simulation


@pytest.fixture(scope="module")
def chooser() -> Simulation:
    outer = Network(
        (Ensemble("one", 30), Ensemble("two", 30)),
        (Node("salience", 2),),
        (
            *saliences("salience", "bg", np.eye(2), 0.005),
            *(unless_selected("bg", k, 2, name) for k, name in enumerate(("one", "two"))),
        ),
        (Probe("gpi?", "bg.gpi", synapse=0.03),),
    )
    return Simulation(build(join((basal_ganglia("bg", 2, 60), outer)), IdealCurves(), 1))


@pytest.mark.parametrize("salience", [(0.9, 0.4), (0.4, 0.9), (0.8, 0.6), (0.3, 0.5)])
def test_the_larger_salience_is_selected(chooser: Simulation, salience: tuple[float, float]) -> None:
    chooser.set("salience", salience)
    chooser.advance(0.2)
    before = chooser.state.spikes.copy()
    chooser.advance(0.3)
    fired = chooser.state.spikes - before
    count = [int(fired[chooser.built.neurons(name)].sum()) for name in ("one", "two")]
    chosen = int(np.argmax(salience))
    assert np.argmin(chooser.read("gpi?")) == chosen
    assert count[chosen] > 100  # 30 neurons, 0.3 s, tens of Hz at rest
    assert count[1 - chosen] == 0


def test_the_oscillator_turns() -> None:
    network = join((oscillator("x", 200, 1.0), Network(probes=(Probe("x?", "x", synapse=0.02),))))
    run = Simulation(build(network, IdealCurves(), 1), 0.01)
    run.advance(3.0)
    found = []
    for _ in range(400):
        run.advance(0.01)
        found.append(run.read("x?"))
    values = np.array(found)
    turns = np.unwrap(np.arctan2(values[:, 1], values[:, 0]))
    # the decoded dynamics of 200 neurons: some per cent off
    assert (turns[-1] - turns[0]) / (2.0 * np.pi * 3.99) == pytest.approx(1.0, abs=0.08)
    assert np.median(np.hypot(*values.T)) == pytest.approx(1.0, abs=0.1)
