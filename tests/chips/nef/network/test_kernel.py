"""The compiled loop: the neuron beside its own equation, lanes beside a low-pass written out."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.network.curves import TAU_RC, TAU_REF, IdealCurves
from chips.nef.network.kernel import DT, advance, new_state, update
from chips.nef.network.network import Connection, Ensemble, Network, Node, Probe


def test_rates_at_constant_current_are_the_curve() -> None:
    current = np.array([0.5, 1.0, 1.2, 2.0, 8.0, 40.0])
    u, rest, fired = np.zeros(6), np.zeros(6), np.zeros(6, dtype=np.int64)
    count, steps = np.zeros(6), 20_000
    for _ in range(steps):
        found = update(u, rest, current, fired, 0, 6, TAU_RC, TAU_REF)
        count[fired[:found]] += 1
    want = IdealCurves().rates(0, current[None])[0]
    assert count[:2].tolist() == [0.0, 0.0]
    # spikes are placed within a step: one spike more or less in 20 s, and 1e-4 by the step's polynomial
    assert count / (steps * DT) == pytest.approx(want, abs=0.06, rel=1e-4)


def test_inhibition_leaves_nothing_behind() -> None:
    u, rest, fired = np.array([0.9]), np.zeros(1), np.zeros(1, dtype=np.int64)
    for _ in range(50):
        assert update(u, rest, np.array([-500.0]), fired, 0, 1, TAU_RC, TAU_REF) == 0
    assert u[0] == 0.0


def test_lanes_are_low_pass_filters() -> None:
    network = Network(
        (Ensemble("a", 5),), (Node("in", 1), Node("out", 0, 1)), (Connection("in", "out", synapse=0.02),)
    )
    built = build(network, IdealCurves(), 0)
    state = new_state(built.net)
    state.held[:] = built.drive @ np.array([2.0])
    advance(built.net, state, 30)
    assert state.y[built.read["out"]] == pytest.approx(2.0 * (1.0 - math.exp(-30.0 * DT / 0.02)))


def test_a_spike_acts_a_step_later() -> None:
    network = Network((Ensemble("a", 50),), (), (), (Probe("a?", "a", lambda x: x + 3.0, synapse=0.0),))
    built = build(network, IdealCurves(), 0)
    state = new_state(built.net)
    for _ in range(40):
        before = state.spikes.copy()
        advance(built.net, state, 1)
        raw = state.raw[built.read["a?"]][0]
        advance(built.net, state, 1)
        assert state.y[built.read["a?"]][0] == pytest.approx(raw)
        assert (state.spikes >= before).all()
    assert state.spikes.sum() > 0


def test_a_silent_network_stays_at_rest() -> None:
    built = build(Network((Ensemble("a", 20, intercepts=(0.2, 0.5), encoders=((1.0,),)),)), IdealCurves(), 0)
    state = new_state(built.net)
    advance(built.net, state, 200)
    assert state.spikes.sum() == 0
