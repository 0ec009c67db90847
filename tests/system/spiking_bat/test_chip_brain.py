"""Maps, chip and motors: the scene of Figure 12, a free way, a wall."""

import math

import numpy as np
import pytest

from chips.latency.chip import LatencyChip
from chips.latency.model import usual_biases
from chips.latency.unit_level import TransistorUnit
from circuits.silicon.course import Course
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace.law import MIDDLE, Bat, arcs_of
from system.spiking_bat.bat import seen_from
from system.spiking_bat.chip_brain import ChipBrain, brain_with, chip_brain, design_of
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.scene import HEADING, OBSTACLES
from system.spiking_bat.topology import layer_delays

S, ARCS = Numbers(), arcs_of(Bat(ping_rate=10.0))
PLACE = np.array([(-ahead, -left) for ahead, left in OBSTACLES])
NONE = np.empty((0, 2))


@pytest.fixture
def brain() -> ChipBrain:
    return chip_brain(ARCS, S, Silicon(AMI_1500_IDEAL))


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
    assert not np.isfinite(three.response.memory).any()


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


def test_a_course_that_stays_changes_nothing_and_one_that_warms_does() -> None:
    seen = seen_from(ARCS, PLACE, HEADING, 2)
    chip = LatencyChip(design_of(ARCS, S), silicon=Silicon(AMI_1500_IDEAL))
    still, flat, warming = (
        brain_with(chip, ARCS, S, course)
        for course in (
            None,
            Course(((0.0, 27.0), (9.0, 27.0))),
            # the settling period comes before 0 s
            Course(((0.0, 27.0), (0.1, 40.0))),
        )
    )
    for brain in (still, flat, warming):
        brain.answer(2, MIDDLE, seen)
        brain.end(spoken=False)
    first = still.answer(2, MIDDLE, NONE).response
    assert np.array_equal(first.memory, flat.answer(2, MIDDLE, NONE).response.memory)
    warm = warming.answer(2, MIDDLE, NONE).response
    assert warming.chip.silicon.temperature_c == 40.0
    # what both recall comes with the taps of 40 degC, and the 15 us of the detector's node
    known = np.argwhere(np.isfinite(first.detected) & np.isfinite(warm.detected))
    assert len(known)
    taps = np.cumsum(chip.at(40.0).lumped.tap)[1:]
    for memory, unit in known:
        assert warm.detected[memory, unit] == pytest.approx(taps[unit], abs=30e-6)
        assert warm.detected[memory, unit] < 0.95 * first.detected[memory, unit]


def test_a_unit_of_transistors_follows_the_course() -> None:
    biases = usual_biases(design_of(ARCS, S))
    unit = TransistorUnit(biases, Silicon(AMI_1500_IDEAL), 16, 5)
    chip = LatencyChip(design_of(ARCS, S), biases, units={(16, 5): unit})
    brain = brain_with(chip, ARCS, S, Course(((0.0, 30.0), (1.0, 40.0))))
    brain.ping(2, MIDDLE, NONE)
    assert (brain.chip.silicon.temperature_c, unit.silicon.temperature_c) == (30.0, 30.0)
