"""Programs of Bug 0, 1 and 2 on the maps: theory says who arrives, and who can know that nobody does."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.errors import UnknownNameError
from system.bug.body import ARRIVED, RADIUS
from system.bug.path import path_length
from system.bug.reference import reference_brain
from system.bug.run import Trace, run
from system.bug.scenario import Scenario


def driven(agent: str, name: str, start: str = "0", duration: float = 200.0) -> Trace:
    return run(Scenario(agent=agent, map=name, start=start, duration=duration))


@pytest.mark.parametrize("agent", ["bug0", "bug1", "bug2"])
@pytest.mark.parametrize(("name", "start"), [("bug-open", "0"), ("bug-field", "0"), ("bug-rooms", "1")])
def test_all_reach_what_theory_says(agent: str, name: str, start: str) -> None:
    trace = driven(agent, name, start)
    assert trace.ended == "reached"
    assert np.hypot(*(trace.path[-1] - trace.world.map.goals[0])) < ARRIVED
    assert trace.shortest is not None
    # a point's shortest way is a lower bound up to where the goal counts as reached
    assert path_length(trace.path) > path_length(trace.shortest) - ARRIVED - 1e-9


@pytest.mark.parametrize("agent", ["bug1", "bug2"])
@pytest.mark.parametrize("name", ["bug-cup", "bug-spiral"])
def test_with_a_memory_the_traps_are_solved(agent: str, name: str) -> None:
    assert driven(agent, name).ended == "reached"


def test_bug_0_repeats_its_way_around_the_spiral() -> None:
    trace = driven("bug0", "bug-spiral")
    assert trace.ended == "out of time"
    late, early = trace.path[-5000::50], trace.path[5000:15000]
    apart = np.hypot(*(late[:, None] - early[None]).transpose(2, 0, 1)).min(axis=1)
    assert apart.max() < 2.0 * RADIUS  # where it is in the last 50 s it has been before
    assert np.ptp(late, axis=0).min() > 5.0  # all around, not in a corner


def test_bug_0_stays_in_the_cup() -> None:
    trace = driven("bug0", "bug-cup", duration=100.0)
    assert trace.ended == "out of time"
    assert trace.path[:, 0].max() < 12.0


@pytest.mark.parametrize(
    ("agent", "ended"), [("bug0", "out of time"), ("bug1", "unreachable"), ("bug2", "unreachable")]
)
def test_a_goal_that_is_walled_in(agent: str, ended: str) -> None:
    trace = driven(agent, "bug-sealed", duration=100.0)
    assert trace.ended == ended
    assert trace.shortest is None


def test_no_robot_enters_a_wall() -> None:
    trace = driven("bug2", "bug-cup")
    room = min(trace.world.clearance((x, y)) for x, y in trace.path[::20].tolist())
    assert room >= RADIUS - 1e-9  # rounding


def test_no_such_agent() -> None:
    with pytest.raises(UnknownNameError, match=r"agent bug3: unknown; .*known are bug0, bug1, bug2"):
        reference_brain("bug3", 1.0)
