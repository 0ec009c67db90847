"""The link drops and delays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.pushbot.body import Pushbot, Tracks
from system.pushbot.link import carry, open_link, receive, send
from system.worlds.camera.event import Events

COUNT = 20_000
EVENTS = Events(
    np.linspace(0.0, 1.0, COUNT),
    np.arange(COUNT) % 128,
    np.arange(COUNT) % 64,
    np.arange(COUNT) % 2 == 0,
    lost=3,
)


def test_four_of_five_events_are_dropped_and_the_rest_is_late() -> None:
    arrived = carry(Pushbot(), open_link(1), EVENTS)
    assert len(arrived) == pytest.approx(
        0.2 * COUNT, abs=4.0 * math.sqrt(0.16 * COUNT)
    )  # binomial, four sigma
    rows = np.round((arrived.time - 8e-3) * (COUNT - 1)).astype(int)
    assert EVENTS.time[rows] == pytest.approx(arrived.time - 8e-3)
    assert np.array_equal(EVENTS.x[rows], arrived.x)
    assert arrived.lost == 3


def test_events_on_their_way_arrive_later() -> None:
    robot, link = Pushbot(dropped=0.0), open_link(1)
    first = carry(robot, link, EVENTS, until=0.5)
    assert first.time.max() <= 0.5
    assert len(first) == np.sum(EVENTS.time + 8e-3 <= 0.5)
    rest = carry(robot, link, EVENTS.where(np.zeros(COUNT, dtype=np.bool_)), until=2.0)
    assert np.array_equal(np.concatenate([first.time, rest.time]), EVENTS.time + 8e-3)


def test_none_is_dropped_where_none_shall_be() -> None:
    assert len(carry(Pushbot(dropped=0.0), open_link(1), EVENTS)) == COUNT


def test_what_is_dropped_is_the_seeds_however_events_come() -> None:
    robot = Pushbot()
    whole = carry(robot, open_link(1), EVENTS)
    link = open_link(1)
    halves = [
        carry(robot, link, EVENTS.where(EVENTS.time < 0.5)),
        carry(robot, link, EVENTS.where(EVENTS.time >= 0.5)),
    ]
    assert np.array_equal(np.concatenate([h.time for h in halves]), whole.time)
    assert not np.array_equal(carry(robot, open_link(2), EVENTS).time[:100], whole.time[:100])


def test_commands_take_effect_after_the_latency() -> None:
    robot, link = Pushbot(), open_link(1)
    send(robot, link, 0.1, (10, 20))
    send(robot, link, 0.2, (30, 40))
    tracks = Tracks(left=0.1)
    assert receive(link, tracks, 0.107) == tracks
    assert receive(link, tracks, 0.108) == Tracks(0.1, 0.0, 10, 20)
    assert receive(link, tracks, 0.5) == Tracks(0.1, 0.0, 30, 40)
