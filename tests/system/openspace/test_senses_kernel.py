"""Echoes become places, and currents a selection: scenes of one or two obstacles with closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.selection.model import selection
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace import state
from system.openspace.kernel import choose, fly, ping
from system.openspace.law import ARCS, DIRECTIONS, MIDDLE, Bat, arcs_of
from system.openspace.map import SIDE, Cells, Forest, cells_of, plant
from system.openspace.selecting import projection
from system.openspace.senses import EXACT, Sensing, senses_of
from system.openspace.senses_kernel import Senses
from system.openspace.view import add_immediacies

BAT = Bat()
ARCS_OF = arcs_of(BAT)
SONAR = senses_of(Sensing("sonar"), BAT)
AT = 25.0


def scene(*obstacles: tuple[float, float]) -> tuple[Cells, state.Flight]:
    """Obstacles at places (m, ahead and to the left) of a bat that flies west."""
    place = np.array([(AT - x, AT - y) for x, y in obstacles]) % SIDE
    flight = state.new_flight(AT, AT, -math.pi, DIRECTIONS, len(obstacles), 0)
    return cells_of(Forest("scene", place), BAT.max_range + 1.0), flight


def heard(senses: Senses, *obstacles: tuple[float, float]) -> state.Flight:
    cells, flight = scene(*obstacles)
    ping(ARCS_OF, senses, cells, flight)
    return flight


def risk_of(x: float, y: float) -> np.ndarray:
    risk = np.zeros(ARCS)
    add_immediacies(ARCS_OF, x, y, risk)
    return risk


def test_the_delay_is_shortened_by_the_flight() -> None:
    found = heard(SONAR, (3.0, 0.0))
    shown = 3.0 * SONAR.sound_speed / (SONAR.sound_speed + ARCS_OF.speed[MIDDLE])
    assert np.allclose(found.fresh, risk_of(shown, 0.0), rtol=1e-9)
    assert (found.counts[state.SEEN], found.counts[state.AVOIDED]) == (1, 1)


def test_all_echoes_apart_are_the_exact_places() -> None:
    cells = cells_of(plant(1400, np.random.default_rng(3)), BAT.max_range + 1.0)
    slow = arcs_of(Bat(max_speed=1e-6))
    one, other = (state.new_flight(12.0, 30.0, 0.4, DIRECTIONS, 1400, 0) for _ in range(2))
    ping(slow, EXACT, cells, one)
    ping(slow, SONAR._replace(overlap=0.0), cells, other)
    # the order of the sums differs, and the speed of 1e-6 m/s over that of sound
    assert np.allclose(one.fresh, other.fresh, rtol=1e-6)
    assert np.array_equal(one.met, other.met)
    assert one.counts[state.SEEN] == other.counts[state.SEEN] > 3


@pytest.mark.parametrize(("apart", "masked"), [(0.1, 1), (0.3, 0)])
def test_an_echo_within_a_call_is_masked(apart: float, masked: int) -> None:
    found = heard(SONAR, (2.0, 0.0), (0.0 + math.sqrt((2.0 + apart) ** 2 - 0.81), 0.9))
    assert found.counts[state.MASKED] == masked  # a millisecond is 0.17 m
    assert found.counts[state.SEEN] == found.counts[state.AVOIDED] == 2 - masked


@pytest.mark.parametrize(("aside", "occluded"), [(0.05, 1), (0.2, 0)])
def test_a_shadow_is_as_wide_as_the_obstacle(aside: float, occluded: int) -> None:
    # at 4 m the shadow of 0.05 m at 2 m is 0.1 m to each side
    senses = senses_of(Sensing("sonar", occlusion=True), BAT)
    assert heard(senses, (2.0, 0.0), (4.0, aside)).counts[state.OCCLUDED] == occluded


def test_sound_by_way_of_two_obstacles() -> None:
    places = ((1.0, 0.0), (1.6, 0.5))
    senses = senses_of(Sensing("sonar", multipath=True), BAT)._replace(overlap=0.0)
    found = heard(senses, *places)
    assert found.counts[state.GHOSTS] == 2  # there and back
    assert found.counts[state.SEEN] == found.counts[state.AVOIDED] == 2
    way = 0.5 * (1.0 + math.hypot(0.6, 0.5) + math.hypot(*places[1]))
    ghosts = found.echo[:4][found.echo[:4, state.ECHO_NUMBER] < 0.0]
    assert np.allclose(ghosts[:, state.ECHO_RANGE], way)
    assert heard(senses._replace(strength=0.01), *places).counts[state.GHOSTS] == 0


def test_a_reading_takes_the_place_of_the_range() -> None:
    table = np.full(700, 1.25)
    found = heard(SONAR._replace(reading=table), (3.0, 0.0))
    assert np.allclose(found.fresh, risk_of(1.25, 0.0))
    table[:] = np.nan
    found = heard(SONAR._replace(reading=table), (3.0, 0.0))
    assert (found.counts[state.MISSED], found.counts[state.SEEN], found.counts[state.AVOIDED]) == (1, 0, 0)
    assert found.fresh.max() == 0.0


def test_noise_turns_the_bearing() -> None:
    still = SONAR._replace(sound_speed=1e9)  # the flight shortens nothing
    found = heard(still._replace(noise=np.array([0.2])), (3.0, 0.0))
    assert np.allclose(found.fresh, risk_of(3.0 * math.cos(0.2), 3.0 * math.sin(0.2)), rtol=1e-6)


def test_the_nominal_chip_selects_what_the_desirabilities_do() -> None:
    senses = senses_of(Sensing(selection="chip"), BAT)
    cells = cells_of(plant(900, np.random.default_rng(8)), BAT.max_range + 1.0)
    flight = state.new_flight(12.0, 30.0, -math.pi, DIRECTIONS, 900, 0)
    fly(ARCS_OF, senses, cells, flight, 300)
    pings = flight.counts[state.PINGS]
    assert pings > 50
    # without deviations they differ by the projection's reach alone, e^-4/1.13^2 = 4 % of a risk beyond it
    assert flight.counts[state.OTHER] < 0.2 * pings
    assert flight.counts[state.LATE] + flight.counts[state.TIES] < 0.1 * pings


def test_a_selection_that_comes_too_late_changes_nothing() -> None:
    senses = senses_of(Sensing(selection="chip"), BAT)._replace(deadline=0.0)
    cells, flight = scene((1.5, 0.1))
    flight.counts[state.ARC], flight.counts[state.HEAD] = 12, 3
    for _ in range(3):
        ping(ARCS_OF, senses, cells, flight)
        choose(ARCS_OF, senses, flight)
    assert flight.counts[state.LATE] == 3
    assert (flight.counts[state.ARC], flight.counts[state.HEAD]) == (12, 3)


def test_desirabilities_that_are_alike_take_for_ever() -> None:
    # the goal behind and all arcs alike: no cell is above the others
    bat = Bat(sharp_turn_cost=0.0, goal_gain=1e-12, hysteresis=0.0, ping_bias=0.0)
    chip = selection(Silicon(AMI_1500_IDEAL), projection(bat))
    senses = senses_of(Sensing(selection="chip"), bat)._replace(chip=chip)
    cells, flight = scene((24.0, 0.0))
    ping(arcs_of(bat), senses, cells, flight)
    choose(arcs_of(bat), senses, flight)
    assert (flight.counts[state.LATE], flight.counts[state.TIES]) == (1, 1)


def test_a_chip_without_a_current_is_an_emergency() -> None:
    senses = senses_of(Sensing(selection="chip"), BAT)
    flight = scene((24.0, 0.0))[1]
    flight.risk[:] = 40.0
    choose(ARCS_OF, senses, flight)
    assert flight.counts[state.EMERGENCIES] == 1


def test_the_ideal_winner_is_kept_beside_the_chips() -> None:
    cells, one = scene((2.0, 0.0), (1.5, 1.0))
    other = scene((2.0, 0.0), (1.5, 1.0))[1]
    ping(ARCS_OF, EXACT, cells, one)
    ping(ARCS_OF, EXACT, cells, other)
    choose(ARCS_OF, EXACT, one)
    choose(ARCS_OF, senses_of(Sensing(selection="chip"), BAT), other)
    assert np.allclose(one.wish, other.wish)
    assert one.counts[state.WINNER] == other.counts[state.WINNER]
