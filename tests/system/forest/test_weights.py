"""Weights by the speed setting."""

from __future__ import annotations

import pytest

from circuits.errors import ParameterError
from system.forest.weights import PING_BIAS, SPEEDS, weighted
from system.openspace.law import Bat


def test_fixed_weights_are_the_bats() -> None:
    assert weighted(Bat(max_speed=1.0), "fixed") == Bat(max_speed=1.0)


def test_slow_bats_have_less_bias() -> None:
    found = [weighted(Bat(max_speed=v), "speed").ping_bias for v in (0.5, *SPEEDS, 9.0)]
    assert found == [PING_BIAS[0], *PING_BIAS, PING_BIAS[-1]]
    assert found == sorted(found)
    between = weighted(Bat(max_speed=1.25), "speed").ping_bias
    assert between == pytest.approx(0.5 * (PING_BIAS[0] + PING_BIAS[1]))


def test_fast_bats_have_their_own() -> None:
    assert weighted(Bat(max_speed=SPEEDS[-1]), "speed") == Bat(max_speed=SPEEDS[-1])


def test_weights_that_are_none() -> None:
    with pytest.raises(ParameterError, match="weights: best"):
        weighted(Bat(), "best")
