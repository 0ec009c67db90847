"""The Wi-Fi between robot and controller: what it carries comes later, and most events are dropped.

Milde et al. 2017, sections 2.3 and 3.4: 80 % of the events are dropped at random, to have less noise and less
to send; latency is below 10 ms. Times of events are those of their arrival.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace

import numpy as np

from system.pushbot.body import Pushbot, Tracks
from system.worlds.camera.event import Events, joined


@dataclass(slots=True, eq=False)
class Link:
    """State: what draws the dropped events; events and commands (s of arrival, left, right) on their way.

    random : what draws the dropped events.
    """

    random: np.random.Generator
    events: Events = field(default_factory=lambda: joined([]))
    commands: deque[tuple[float, int, int]] = field(default_factory=deque)


def open_link(seed: int) -> Link:
    """Return a link with nothing on its way."""
    return Link(np.random.default_rng((seed, 4)))


def carry(robot: Pushbot, link: Link, events: Events, until: float = math.inf) -> Events:
    """Take the sensor's events; of those not dropped, what has arrived by `until` s, timed by its arrival."""
    kept = events.where(link.random.random(len(events)) >= robot.dropped)
    late = Events(kept.time + robot.latency, kept.x, kept.y, kept.on, kept.lost)
    on_way = joined([link.events, late])
    here = on_way.time <= until
    link.events = replace(on_way.where(~here), lost=0)
    return on_way.where(here)


def send(robot: Pushbot, link: Link, time: float, commands: tuple[int, int]) -> None:
    """Send commands (left, right) at `time` s."""
    link.commands.append((time + robot.latency, *commands))


def receive(link: Link, tracks: Tracks, time: float) -> Tracks:
    """Tracks with the last command that has arrived by `time` s."""
    while link.commands and link.commands[0][0] <= time + 1e-12:
        _, left, right = link.commands.popleft()
        tracks = replace(tracks, left_command=left, right_command=right)
    return tracks
