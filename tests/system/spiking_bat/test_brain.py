"""Numbers that do not fit the bat are refused, by the name of the option that gives them."""

from dataclasses import replace

import pytest

from circuits.errors import ParameterError
from system.openspace.law import Bat, arcs_of
from system.spiking_bat.brain import check_timing
from system.spiking_bat.maps import longest_latency
from system.spiking_bat.numbers import Numbers, numbers_at
from tests.refusals import refusals

ARCS = arcs_of(Bat(ping_rate=10.0))


def test_the_longest_latency_is_of_one_obstacle_at_the_end() -> None:
    echo, latency = longest_latency(ARCS, Numbers())
    assert echo == pytest.approx(2.0 * 5.0 / 343.0)
    assert latency == pytest.approx(echo + 3e-3 + 8e-3)
    check_timing(ARCS, Numbers())
    check_timing(ARCS, replace(Numbers(), taps=14))


test_what_does_not_fit_is_refused = refusals(
    ParameterError,
    lambda numbers: check_timing(ARCS, numbers),
    [
        (replace(Numbers(), taps=13), "taps: 13, a delay line of 39 ms, must reach"),
        (replace(Numbers(), taps=30), "the delay line takes 90 ms, must be less than the 90 ms"),
        (replace(Numbers(), paths=15), "paths: 15 memories, must be 33"),
        (numbers_at(50.0), "a period of 20 ms is shorter than the longest echo"),
        (numbers_at(13.5), "the emergency neuron takes 68 ms"),
        (numbers_at(6.0), "is longer than a memory lasts, 150 ms"),
    ],
)
