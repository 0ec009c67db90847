"""Maps, chip and motors: the scene of Figure 12, a free way, a wall."""

import math

import numpy as np
import pytest

from system.curved_openspace import MIDDLE, Bat, arcs_of
from system.latency_bat import seen_from
from system.latency_chip_brain import ChipBrain, chip_brain, design_of
from system.latency_numbers import Numbers
from system.latency_scene import HEADING, OBSTACLES
from system.latency_topology import layer_delays

S, ARCS = Numbers(), arcs_of(Bat(ping_rate=10.0))
PLACE = np.array([(-ahead, -left) for ahead, left in OBSTACLES])
NONE = np.empty((0, 2))


@pytest.fixture
def brain() -> ChipBrain:
    return chip_brain(ARCS, S)


def test_the_design_has_the_networks_numbers() -> None:
    design = design_of(ARCS, S)
    assert (design.paths, design.taps, design.hop) == (33, 15, S.tap_delay)
    assert design.second == pytest.approx(layer_delays(S))


def test_the_scene_of_figure_12_goes_as_on_the_network(brain: ChipBrain) -> None:
    one = brain.ping(2, MIDDLE, seen_from(ARCS, PLACE, HEADING, 2))
    assert (one.head, one.turned) == (1, None)
    flown = np.array([-float(ARCS.speed[MIDDLE]) * S.ping_period, 0.0])
    two = brain.ping(1, MIDDLE, seen_from(ARCS, PLACE - flown, HEADING, 1))
    assert two.arcs.size
    assert two.turned is not None
    three = brain.ping(1, MIDDLE, NONE)
    assert not np.isfinite(three.said.memory).any()


def test_a_free_way_is_flown_straight(brain: ChipBrain) -> None:
    reply = brain.ping(2, MIDDLE, NONE)
    assert reply.head == 2
    # the middle arc and its neighbours; the direction's charge is the middle group's
    assert float(reply.arcs.mean()) == pytest.approx(MIDDLE, abs=0.6)
    assert reply.turned is not None
    assert reply.turned < S.race
    assert brain.counts() == {"lost": 0, "overflowed": 0, "undecided": 0}


def test_a_wall_before_its_face_makes_an_emergency(brain: ChipBrain) -> None:
    bearing = np.radians(np.arange(-60.0, 61.0, 4.0))
    near = 0.6 * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    wall = seen_from(ARCS, -near, -math.pi, 2)
    replies = [brain.answer(head, MIDDLE, wall) for head in (0, 1, 3, 4, 2) if not brain.end(spoken=False)]
    last = [r for r in replies if r.emergency is not None]
    assert last
    # the bus takes 0.1 us an event
    assert last[0].emergency == pytest.approx(S.emergency, abs=50e-6)
