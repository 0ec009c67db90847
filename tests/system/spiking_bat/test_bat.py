"""One ping: who sees what, and what the motors say when nothing or everything is in the way."""

import math

import numpy as np
import pytest

from system.openspace.law import MIDDLE, Bat, arcs_of
from system.spiking_bat.bat import goal_neuron, ping, seen_from, settled
from system.spiking_bat.network.network import Network
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.topology import published

S, ARCS = Numbers(), arcs_of(Bat(ping_rate=10.0))
WEST = -math.pi


@pytest.fixture(scope="module")
def network() -> Network:
    return published(ARCS, S)


def test_obstacles_are_seen_along_the_ping() -> None:
    offset = np.array([(-3.0, -0.5), (3.0, 0.0), (-1.0, 4.9)])
    seen = seen_from(ARCS, offset, WEST, 2)
    assert seen == pytest.approx(np.array([(3.0, 0.5)]))


def test_the_goal_is_straight_ahead_for_a_bat_that_flies_west() -> None:
    assert goal_neuron(ARCS, WEST) == MIDDLE
    assert goal_neuron(ARCS, WEST + 0.3) > MIDDLE  # it has turned left, so that the goal lies to its right


def test_a_free_way_is_flown_straight(network: Network) -> None:
    answer = ping(network, settled(network, S), S, 2, MIDDLE, np.empty((0, 2)))
    assert answer.head == 2
    assert float(answer.arcs.mean()) == pytest.approx(MIDDLE, abs=0.6)
    assert answer.turned is not None
    assert answer.turned < S.race
    assert answer.emergency is None
    assert not answer.spikes.of("out")[0].size


def test_a_wall_before_its_face_makes_an_emergency(network: Network) -> None:
    bearing = np.radians(np.arange(-60.0, 61.0, 4.0))
    near = 0.6 * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    walls = [seen_from(ARCS, near @ np.array([[-1.0, 0.0], [0.0, -1.0]]), WEST, d) for d in range(5)]
    state = settled(network, S)
    answers = []
    for head in (0, 1, 3, 4, 2):
        answers.append(ping(network, state, S, head, MIDDLE, walls[2]))
        if answers[-1].emergency is not None:
            break
    assert answers[-1].emergency == pytest.approx(S.emergency, abs=1e-4)
    assert not answers[-1].arcs.size
