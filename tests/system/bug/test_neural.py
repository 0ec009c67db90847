"""Neural brains: their size, what they do against an open map and a wall, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.network.curves import IdealCurves
from chips.nef.network.network import neurons_of
from circuits.errors import ParameterError, UnknownNameError
from system.bug.body import RADIUS, RANGE, Senses
from system.bug.brain import FOLLOW, GO, MEMORISE, STORE, along_wall, nearness
from system.bug.neural import bug0_brain, bug2_brain, network_of
from system.bug.neural0 import testing as is_testing
from system.bug.neural2 import DESIGNS
from system.bug.path import median_distance
from system.bug.run import run
from system.bug.scenario import Scenario

FREE = np.full(8, RANGE)
WALL = np.array([0.9, 0.25, RADIUS, 0.2, 0.9, RANGE, RANGE, RANGE])  # to the left
EAST = np.array([1.0, 0.0])


def test_sizes_are_the_papers() -> None:
    assert network_of("bug0").neurons == 2050
    assert network_of("bug2").neurons == 4010


@pytest.mark.parametrize(
    ("agent", "design"), [("bug0", "published"), ("bug2", "published"), ("bug2", "improved")]
)
def test_neurons_are_a_parameter(agent: str, design: str) -> None:
    full = network_of(agent, design)
    half = network_of(agent, design, full.neurons // 2)
    assert half.neurons == pytest.approx(full.neurons / 2, rel=0.02)  # rounding of every part
    assert [e.name for e in half.ensembles] == [e.name for e in full.ensembles]
    assert all(neurons_of(a) < neurons_of(b) for a, b in zip(half.ensembles, full.ensembles, strict=True))


def test_what_has_no_network() -> None:
    with pytest.raises(ParameterError, match="agent: bug1, has no network; use `brain=reference`"):
        network_of("bug1")
    with pytest.raises(UnknownNameError, match="design of bug0 improved: unknown; known are published"):
        network_of("bug0", "improved")
    with pytest.raises(ParameterError, match="neurons: 10, must be from 300 to 40000"):
        network_of("bug0", neurons=10)
    with pytest.raises(ParameterError, match="neurons: a reference has no neurons"):
        Scenario(neurons=2000)
    with pytest.raises(ParameterError, match="design: a reference has no neurons"):
        Scenario(design="improved")


def test_bug_0_drives_ahead_until_contact_and_tries_once_a_second() -> None:
    brain = bug0_brain(build(network_of("bug0"), IdealCurves(), 3))
    free = [brain.step(Senses(FREE, 0.0, EAST, EAST, 0.5)) for _ in range(150)]
    assert np.mean(free[50:], axis=0) == pytest.approx(
        EAST, abs=0.1
    )  # decoded by 150 neurons, of a radius 1.2
    states, vectors = [], []
    for _ in range(600):
        vectors.append(brain.step(Senses(WALL, 1.0, EAST, EAST, 0.5)))
        states.append(brain.state)
    follows = np.array([s == FOLLOW for s in states[200:]])
    assert 0.5 < follows.mean() < 0.9
    assert int((np.diff(follows.astype(int)) > 0).sum()) in {3, 4, 5}  # 4 s at 1 Hz
    settled = np.array(vectors[200:])[follows & np.roll(follows, 10) & np.roll(follows, -10)]
    # smooth decoding of eight squares at 50 neurons each, and its noise
    assert settled.mean(axis=0) == pytest.approx(along_wall(WALL), abs=0.15)


def test_bug_2_goes_through_its_states() -> None:
    brain = bug2_brain(build(network_of("bug2", "improved"), IdealCurves(), 3))
    order: list[str] = []

    def feel(ranges: np.ndarray, contact: float, north: np.ndarray, distance: float, steps: int) -> None:
        for _ in range(steps):
            brain.step(Senses(ranges, contact, EAST, north, distance))
            if not order or brain.state != order[-1]:
                order.append(brain.state)

    feel(FREE, 0.0, EAST, 0.5, 350)
    assert order == [MEMORISE, GO]
    feel(WALL, 1.0, EAST, 0.5, 50)
    assert order[-1] == STORE
    feel(WALL, 1.0, EAST, 0.5, 300)
    assert order[-1] == FOLLOW
    assert brain.simulation.read("distance?")[0] == pytest.approx(
        0.5, abs=0.03
    )  # what counts as stored, and drift
    feel(WALL, 1.0, np.array([0.6, 0.8]), 0.3, 200)  # nearer, but elsewhere
    assert order[-1] == FOLLOW
    feel(WALL, 1.0, EAST, 0.7, 200)  # there, but farther
    assert order[-1] == FOLLOW
    feel(WALL, 1.0, EAST, 0.3, 60)
    assert order == [MEMORISE, GO, STORE, FOLLOW, GO]


def test_the_test_phase_has_its_share() -> None:
    angle = np.linspace(-np.pi, np.pi, 1001)
    points = 0.7 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert is_testing(points).mean() == pytest.approx(0.2, abs=0.005)  # 1001 points


def test_nearness_is_one_at_the_wall() -> None:
    assert nearness(np.array([RADIUS, RANGE])).tolist() == [1.0, 0.0]


def test_neural_bug_0_drives_as_the_program_does() -> None:
    paths = [
        run(Scenario("bug0", brain, map="bug-field", seed=1, duration=80.0))
        for brain in ("reference", "ideal")
    ]
    assert [t.reached for t in paths] == [True, True]
    assert median_distance(paths[1].path, paths[0].path) < 2.0 * RADIUS


@pytest.mark.parametrize("design", DESIGNS)
def test_neural_bug_2_leaves_the_spiral(design: str) -> None:
    trace = run(Scenario("bug2", "ideal", design, map="bug-spiral", seed=1, duration=80.0))
    assert trace.ended == "reached"


def test_a_run_is_the_same_again() -> None:
    scenario = Scenario("bug2", "ideal", map="bug-open", seed=4, duration=3.0)
    assert (run(scenario).path == run(scenario).path).all()
    assert (
        run(scenario).path[-1]
        != run(Scenario("bug2", "ideal", map="bug-open", seed=5, duration=3.0)).path[-1]
    ).any()
