"""Memory learns, says so, and holds; directions on a circle hardly drift."""

from __future__ import annotations

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.network.circuits import SUPPRESSION
from chips.nef.network.curves import IdealCurves
from chips.nef.network.memory import (
    MemorySize,
    StateSize,
    apart,
    choice,
    is_above,
    memory,
    near,
    state_machine,
    states,
)
from chips.nef.network.network import Connection, Network, Neurons, Node, Probe, join
from chips.nef.simulation import Simulation


def remembering(dimensions: int, size: MemorySize) -> Simulation:
    outer = Network(
        (),
        (Node("in", dimensions), Node("stop", 1)),
        (
            Connection("in", "m.difference"),
            *(
                Connection("stop", Neurons(f"m.{part}"), transform=[[-SUPPRESSION]])
                for part in ("difference", "done")
            ),
        ),
        (Probe("m?", "m.stored", synapse=0.1), Probe("done?", "m.done", is_above(0.5), synapse=0.02)),
    )
    return Simulation(build(join((memory("m", dimensions, size), outer)), IdealCurves(), 1), 0.01)


def test_it_learns_says_so_and_holds() -> None:
    run = remembering(1, MemorySize(200, 100, 30, reach=0.15, near=0.02))
    run.set("in", 0.5)
    run.advance(0.5)
    assert run.read("done?")[0] < 0.5
    run.advance(3.0)
    assert run.read("done?")[0] > 0.5
    assert run.read("m?")[0] == pytest.approx(0.5, abs=0.03)  # what counts as done, and noise
    run.set("stop", 1.0)
    run.set("in", -0.9)
    run.advance(2.0)
    assert run.read("done?")[0] == pytest.approx(0.0, abs=1e-6)  # silent neurons; what the filter has left
    assert run.read("m?")[0] == pytest.approx(0.5, abs=0.08)  # drift of 200 neurons


def test_a_direction_on_the_circle_is_held() -> None:
    run = remembering(2, MemorySize(300, 150, 30, reach=0.3, near=0.05, synapse=0.3, circle=0.5))
    angle = 0.7
    run.set("in", 0.9 * np.array([np.cos(angle), np.sin(angle)]))
    run.advance(3.0)
    run.set("stop", 1.0)
    run.advance(5.0)
    x, y = run.read("m?")
    # 2 degrees of drift and of learning
    assert np.arctan2(y, x) == pytest.approx(angle, abs=np.deg2rad(2.0))
    assert np.hypot(x, y) == pytest.approx(1.0, abs=0.06)


def test_functions() -> None:
    x = np.array([[0.0, 0.0], [0.1, 0.0], [0.3, 0.4]])
    assert near(0.1)(x)[:, 0] == pytest.approx([1.0, 0.5, 1.0 - 12.5])
    assert is_above(0.5)(np.array([[0.4], [0.6]]))[:, 0].tolist() == [0.0, 1.0]


def test_the_nearest_state_has_the_largest_share() -> None:
    points = states(4)
    found = choice(0.9 * points + 0.1, points)
    assert found.argmax(axis=1).tolist() == [0, 1, 2, 3]
    assert found.sum(axis=1) == pytest.approx(np.ones(4))


def test_points_of_a_simplex_are_equally_far_apart() -> None:
    points = apart(4)
    assert points.shape == (4, 3)
    inner = points @ points.T
    assert inner == pytest.approx(np.eye(4) * 4.0 / 3.0 - 1.0 / 3.0)


@pytest.mark.parametrize("points", [states(3), apart(3), apart(4)])
def test_one_transition_a_rising_edge(points: np.ndarray) -> None:
    following = [*range(1, len(points)), 0]
    outer = Network(
        (),
        (Node("one", 1), Node("input", 1), Node("start", points.shape[1])),
        (
            Connection("input", "state.trigger"),
            Connection("start", "state.old"),
            Connection("start", "state.current"),
        ),
        (Probe("active?", "state.active", synapse=0.02),),
    )
    machine = state_machine("state", following, StateSize(250, 150, 45, 50, 50), points)
    run = Simulation(build(join((machine, outer)), IdealCurves(), 2), 0.01)
    run.set("one", 1.0)
    run.set("start", 2.0 * points[0])
    run.advance(0.3)
    run.set("start", 0.0)
    run.advance(0.4)
    for turn in range(len(points) + 1):
        assert int(np.argmax(run.read("active?"))) == turn % len(points)
        for value in (1.0, 0.0):
            run.set("input", value)
            run.advance(0.5)
