"""What is a loop: places that stay, over the border too; and that the network's loop is the chip's."""

import numpy as np
import pytest

from system.openspace.law import Bat, arcs_of
from system.openspace.map import SIDE, Forest
from system.spiking_bat.brain import Brain, network_brain
from system.spiking_bat.campaign import Build, chip_maker
from system.spiking_bat.circling import stays
from system.spiking_bat.flight import Flown, fly
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.run import place
from system.spiking_bat.scenario import Scenario

ARCS = arcs_of(Bat(ping_rate=10.0))


def test_only_what_stays_long_enough_is_a_loop() -> None:
    time = np.linspace(0.0, 100.0, 1001)
    shuttle = np.column_stack([np.abs(np.mod(2.0 * time, 2.0) - 1.0), np.full(time.size, 3.0)])
    assert stays(time, shuttle)
    assert not stays(time[:500], shuttle[:500])  # 50 s
    left = shuttle.copy()
    left[500, 0] += 2.1  # 50 s before the end
    assert not stays(time, left)
    assert stays(time, left, window=40.0)
    # one border's place is the other's
    assert stays(time, np.mod(shuttle, SIDE - 1e-9))
    assert not stays(time, np.column_stack([2.0 * time, time]))


@pytest.fixture(scope="module")
def loop() -> tuple[Forest, tuple[float, float], Flown]:
    """Forest 253, a tuning one, and a flight of the nominal chip through it, which is caught in the end."""
    forest, start = place(Scenario(seed=253), ARCS)
    return forest, start, fly(nominal(), ARCS, forest, start, 800)


def nominal() -> Brain:
    return chip_maker(Build(own=False))(253)


Loop = tuple[Forest, tuple[float, float], Flown]


def test_from_the_last_emergency_on_the_chip_repeats_itself_and_so_does_the_network(loop: Loop) -> None:
    forest, _, flown = loop
    assert flown.caught
    assert flown.turned is not None
    again = fly(nominal(), ARCS, forest, flown.turned, 20)
    # two pings an emergency, two emergencies the loop: after ten of them it stands where it stood
    assert again.emergencies == 10
    assert np.abs(np.array(again.end) - flown.turned.place).max() < 1e-6
    theirs = fly(network_brain(ARCS, Numbers()), ARCS, forest, flown.turned, 20)
    assert theirs.emergencies == 10
    # both turn round where the emergency neuron spikes, which differs by less than 0.1 ms, or 0.2 mm, a turn
    assert np.abs(theirs.path - again.path).max() < 10 * 0.2e-3


def test_patience_ends_a_flight_in_a_loop(loop: Loop) -> None:
    forest, start, flown = loop
    stopped = fly(nominal(), ARCS, forest, start, 2000, patience=20.0)
    assert not stopped.caught  # not long enough
    assert 200 <= stopped.pings < flown.pings
    assert stopped.pings % 100 == 0  # it looks every 10 s
    assert np.array_equal(stopped.path[:-1], flown.path[: len(stopped.path) - 1])
