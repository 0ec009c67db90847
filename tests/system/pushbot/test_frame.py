"""The ring that keeps its orientation: where columns go, which side drives, and a bump on the second chip."""

import math

import numpy as np
import pytest

from chips.rolls.chip import Spikes
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.pushbot.brain import RELAYS, Architecture, brain_of
from system.pushbot.drive import Readings
from system.pushbot.frame import RING, Frame, Relay, ring_chip, ring_neurons, sides
from system.worlds.camera.event import joined


def test_columns_and_heading_are_directions() -> None:
    # column 0 is 30 degrees to the left less half a column, column 127 as much to the right
    columns = np.array([0, 63, 64, 127])
    assert ring_neurons(columns, 0.0, 128).tolist() == [15, 0, 0, RING - 15]
    assert ring_neurons(columns, math.radians(90.0), 128).tolist() == [60, 45, 45, 30]


def test_sides_go_round_the_ring() -> None:
    left, right = sides(np.array([1, 3, 90, RING - 3]), 0.0)
    assert left.tolist() == [False, True, False, False]
    assert right.tolist() == [False, False, True, True]  # straight behind counts as right
    left, right = sides(np.array([3]), math.radians(20.0))
    assert (left[0], right[0]) == (False, True)


def test_what_the_field_sees_drives_its_side_even_after_a_turn() -> None:
    relay = Relay((10, 11), (20, 21), *RELAYS, tuple(range(96, 224)))
    chip = ring_chip(Silicon(ROLLS_180_IDEAL), "ideal")
    frame = Frame(chip, relay, chip.at_rest())
    times = np.arange(0.001, 0.05, 0.0005)
    neurons = 96 + np.tile(np.arange(18, 23), 20)[: times.size]  # 20 degrees to the left
    found = frame.look(Spikes(times, neurons), 0.05)
    assert frame.spikes > 0
    assert set(found.neurons.tolist()) == {10, 11}
    # the robot turns left by 40 degrees: the same place is then on its right
    frame.follow(Readings(joined([]), np.array([[0.05, math.radians(800.0)]])), 0.05, 0.1)
    assert frame.heading == pytest.approx(math.radians(40.0))
    frame.rate = 0.0
    again = frame.look(Spikes(times + 0.05, neurons + 88), 0.05)
    assert set(again.neurons.tolist()) == {20, 21}


def test_with_a_frame_the_field_drives_nothing_itself() -> None:
    network = brain_of(Architecture(target=True, frame=True)).network
    names = {(p.source.name.partition("[")[0], p.target.name) for p in network.projections}
    assert ("relay_left", "DL") in names
    assert not {("target", "DL"), ("target", "DR")} & names


@pytest.mark.parametrize("option", ["frame", "raised"])
def test_options_need_a_target_and_the_plain_network(option: str) -> None:
    with pytest.raises(ParameterError, match="without a target"):
        Architecture(**{option: True})
    with pytest.raises(ParameterError, match="with `modified`"):
        Architecture(modified=True, target=True, **{option: True})
