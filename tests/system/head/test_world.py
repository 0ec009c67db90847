"""Ways of targets: where their formulas say, within their bounds, of their seed."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.head.numbers import Motion
from system.head.world import way_of

MOTION = Motion()


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_a_sine_and_a_step_are_where_their_formulas_say() -> None:
    sine, step = (way_of(kind, MOTION, 10.0, rng()) for kind in ("sine", "step"))
    azimuth, distance = sine.at(2.5)
    assert float(azimuth) == pytest.approx(MOTION.azimuth)
    assert float(distance) == pytest.approx(1.0 + 0.4 * np.sin(2.0 * np.pi * 2.5 / 7.0), abs=1e-5)  # linear
    assert step.at([0.5, 1.5])[0].tolist() == [0.0, MOTION.azimuth]


def test_a_walk_is_its_seeds_and_keeps_within_its_bounds() -> None:
    one, again, other = (way_of("walk", MOTION, 60.0, rng(s)) for s in (1, 1, 2))
    assert np.array_equal(one.azimuth, again.azimuth)
    assert not np.array_equal(one.azimuth, other.azimuth)
    assert np.abs(one.azimuth).max() <= MOTION.azimuth
    assert np.abs(one.distance - 1.0).max() <= MOTION.swing + 1e-12
    speed = np.diff(one.azimuth) / 5e-3
    # 60 s hold some 30 independent speeds: the rms is known to about 15 %
    assert float(np.sqrt(np.mean(speed**2))) == pytest.approx(MOTION.walk_rate, rel=0.5)


def test_a_walk_without_room_stands() -> None:
    found = way_of("walk", Motion(swing=0.0, azimuth=0.0), 5.0, rng())
    assert not found.azimuth.any()
    assert np.all(found.distance == 1.0)


def test_another_motion_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"motion: hop, must be sine, step or walk"):
        way_of("hop", MOTION, 1.0, rng())
