"""Places, equations (7) and (8), and what blocks what."""

import math

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.openspace.law import MIDDLE, Bat, arcs_of
from system.spiking_bat.maps import blocking, echo_delay, latency, nearest_place, places
from system.spiking_bat.network.network import STEP
from system.spiking_bat.numbers import SOUND, Numbers

ARCS = arcs_of(Bat())


def test_a_map_has_as_many_neurons_as_the_paper_says() -> None:
    at = places()
    assert len(at) == 471
    bearing = np.degrees(np.arctan2(at[:, 1], at[:, 0]))
    assert np.unique(np.round(bearing)).size == 31
    assert np.count_nonzero(np.abs(bearing) < 1e-9) == 25
    assert np.hypot(*at.T).max() == pytest.approx(5.0)


def test_the_nearest_place_is_the_place_itself() -> None:
    at = places()
    assert np.array_equal(nearest_place(at + 0.001, at), np.arange(471))


def test_an_arriving_spike_has_the_latency_of_equation_8() -> None:
    at, constant = places(), Numbers().constant_delay
    found = blocking(ARCS, at, constant)
    straight = (found.direction == 2) & (found.arc == MIDDLE)
    ahead = straight & (np.abs(at[found.place, 1]) < 1e-9)
    distance = at[found.place[ahead], 0]
    arrives = found.delay[ahead] + echo_delay(distance)
    longest = 2.0 * 5.0 / SOUND
    expected = longest * np.maximum(distance - ARCS.zone, 0.0) / 5.0 + constant
    assert arrives == pytest.approx(expected, rel=1e-12)
    assert found.delay.min() >= STEP


def test_nearer_obstacles_come_earlier_on_every_arc() -> None:
    for p in range(33):
        way = np.linspace(0.3, float(ARCS.length[p]), 20)
        late = [latency(ARCS, p, float(s), 3e-3) for s in way]
        assert late == sorted(late)
        assert late[-1] <= 2.0 * 5.0 / SOUND + 3e-3


def test_left_and_right_are_mirrors() -> None:
    found = blocking(ARCS, places(), 3e-3)
    counts = np.zeros((5, 33), dtype=int)
    np.add.at(counts, (found.direction, found.arc), 1)
    assert np.array_equal(counts, counts[::-1, ::-1])


def test_a_delay_below_a_step_is_refused() -> None:
    with pytest.raises(
        ParameterError, match=r"numbers\.constant_delay: 0\.001 s, .* must be at\s+least 0\.00"
    ):
        blocking(ARCS, places(), 1e-3)


def test_the_echo_delay_is_there_and_back() -> None:
    assert math.isclose(float(echo_delay(3.43)), 0.02)
