"""Experiments with the latency chip: their statements about flights that are made up."""

from collections.abc import Callable

import pytest

from chips.latency.model import BLOCKS
from system.papers.checks import (
    latency_dies,
    latency_forests,
)
from system.spiking_bat.campaign import Crossed
from tests.system.papers.conftest import Draw


@pytest.fixture
def flights() -> Callable[[int], list[Crossed]]:
    """Flights that are made up: collided after so many crossings, and one stopped at 8."""
    return lambda laps: (
        [Crossed(1006 + k, laps, True, 500) for k in range(9)] + [Crossed(1015, 8, False, 6000)]
    )


def test_forests_state_the_papers_flight_and_the_pairs(
    flights: Callable[[int], list[Crossed]], drawn: Callable[[Draw], int]
) -> None:
    chips = {name: flights(4) for name in latency_forests.CHIPS}
    found = {"analog": flights(5), **chips, "network": flights(4)}
    rows = latency_forests.rows(found)
    # five pairs that are alike do not show that chip and network are
    assert [row.agrees for row in rows[:3]] == [True, True, False]
    assert [row.agrees for row in rows[3:]] == [None] * 6
    assert "four crossings 1.00" in latency_forests.notes(found)[1]
    assert drawn(lambda figure: latency_forests.draw_survival(found, figure)) > 10_000


def test_nulls_of_the_forests_are_not_near_the_papers_flight(
    flights: Callable[[int], list[Crossed]],
) -> None:
    found = {name: flights(4) for name in ("analog", *latency_forests.CHIPS, "network")}
    for flown in latency_forests._nulls(found).values():
        assert [row.agrees for row in latency_forests.rows(flown)[:2]] == [False, False]


def test_builds_that_are_alike_gain_nothing(flights: Callable[[int], list[Crossed]]) -> None:
    found = {name: flights(k) for k, name in enumerate(reversed(latency_dies.BUILDS))}
    nulls = latency_dies._nulls(found)
    assert tuple(null.name for null in nulls) == latency_dies.EXPERIMENT.nulls
    assert [[row.agrees for row in null.rows] for null in nulls[:2]] == [[False] * 3] * 2


def test_dies_state_their_rules(flights: Callable[[int], list[Crossed]]) -> None:
    found = {name: flights(k) for k, name in enumerate(reversed(latency_dies.BUILDS))}
    agrees = [row.agrees for row in latency_dies.rows(found)]
    # in reversed order: calibrated 4, gate 5, area 6, generator 7 crossings
    assert agrees == [False, False, True]
    better = {name: flights(k) for k, name in enumerate(("gate", "ideal", "ideal, area 16"))}
    better["ideal, calibrated"] = flights(3)
    assert [row.agrees for row in latency_dies.rows({**found, **better})] == [True, True, True]
    assert len(latency_dies.notes(found)) == len(latency_dies.BUILDS)
    assert len(BLOCKS) == 7
