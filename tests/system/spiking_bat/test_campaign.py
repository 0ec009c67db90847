"""Survival over crossings, pairs, builds: on flights that are made up, and on one that is flown."""

import math

import numpy as np
import pytest

from chips.latency.errors import usual_design
from chips.latency.model import BLOCKS
from circuits.errors import ParameterError
from system.spiking_bat.campaign import (
    PINGS,
    Build,
    Crossed,
    block_builds,
    crossed_by_analog,
    mean_crossings,
    sign_test,
    survival,
)


def ended(seed: int, laps: int, *, collided: bool = True, pings: int = 100) -> Crossed:
    return Crossed(seed, laps, collided, pings)


def test_survival_is_the_product_limit() -> None:
    flights = [ended(0, 0), ended(1, 2, collided=False), ended(2, 3), ended(3, 8, collided=False)]
    steps, share, low, high = survival(flights)
    # one of four did not cross once; of the two still followed at the fourth crossing one did not
    assert share[[0, 1, 2, 3, 4, 8]] == pytest.approx([1.0, 0.75, 0.75, 0.75, 0.375, 0.375])
    assert steps.tolist() == list(range(9))
    assert low[4] < share[4] < high[4]
    assert mean_crossings(flights) == pytest.approx(3 * 0.75 + 5 * 0.375)


def test_without_a_collision_all_survive() -> None:
    _, share, low, _ = survival([ended(0, 8, collided=False)])
    assert share.tolist() == [1.0] * 9
    assert math.isnan(low[4])
    with pytest.raises(ParameterError, match="no flight"):
        survival([])


def test_pairs_are_compared_by_crossings_then_by_pings() -> None:
    a = [ended(0, 2), ended(1, 1, pings=50), ended(2, 8, collided=False)]
    b = [ended(0, 1), ended(1, 1, pings=60), ended(2, 8, collided=False, pings=PINGS)]
    assert sign_test(a, b) == (1, 1, 1.0)
    with pytest.raises(ParameterError, match="other forests"):
        sign_test(a, b[:2])


def test_blocks_alone_leave_the_rest_nominal() -> None:
    design = usual_design()
    builds = block_builds(Build("ideal", process=False))
    assert list(builds) == list(BLOCKS)
    chip, ideal = builds["delay line"].chip(design, 1003), Build(own=False).chip(design, 1003)
    assert chip.lumped.tap.std() > 0.0
    assert (chip.lumped.hold == chip.lumped.hold[0, 0]).all()
    assert ideal.lumped.hold[0, 0] == pytest.approx(float(chip.lumped.hold[0, 0]))


def test_the_analog_model_ends_as_it_is_told() -> None:
    found = crossed_by_analog(1008)
    assert found.collided or found.laps == 8 or found.pings >= PINGS


def test_a_flight_in_a_loop_has_failed_as_one_that_collided() -> None:
    looped = Crossed(0, 2, False, 900, caught=True)
    stopped = Crossed(0, 2, False, PINGS)
    collided = Crossed(0, 2, True, 900)
    others = [ended(1, 1), ended(2, 8, collided=False)]
    assert np.array_equal(survival([looped, *others])[1], survival([collided, *others])[1])
    assert survival([looped, *others])[1][3] < survival([stopped, *others])[1][3]
    assert looped.worth == collided.worth < stopped.worth
