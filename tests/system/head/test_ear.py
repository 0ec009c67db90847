"""What ears hear of an echo: levels by angle and range, and which level units spike when."""

import numpy as np
import pytest

from chips.lso.model import head_on
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.head.ear import SPEED, amplitudes, hearing, listen
from system.head.numbers import SonarHead

NUMBERS, CHIP = SonarHead(), head_on(Silicon(AMI_1500_IDEAL))


def level_db(angle_deg: float, distance: float = 1.0) -> float:
    left, right = amplitudes(NUMBERS, 0.0, np.radians(angle_deg), distance)
    return 20.0 * float(np.log10(left / right))


def test_the_level_difference_grows_by_0_6_db_a_degree_at_any_range() -> None:
    # half power at 30 deg, axes at +-45: 10 log10(2) 4 45 / 30^2 a degree
    slope = 10.0 * np.log10(2.0) * 4.0 * 45.0 / 30.0**2
    for angle in (-30.0, 0.0, 10.0):
        assert level_db(angle) == pytest.approx(slope * angle, abs=1e-9)
        assert level_db(angle, 0.5) == pytest.approx(level_db(angle, 2.0))


def test_an_echo_falls_with_the_square_of_the_range_and_is_none_behind() -> None:
    near, far = (amplitudes(NUMBERS, 0.0, 0.0, r)[0] for r in (0.7, 1.4))
    assert near == pytest.approx(4.0 * far)
    assert not amplitudes(NUMBERS, 0.0, np.pi, 1.0).any()


def test_level_units_count_decibels() -> None:
    envelope = np.array([NUMBERS.thresholds[4], NUMBERS.thresholds[7]]) * 1.1
    found = listen(NUMBERS, CHIP, envelope, 0.0)
    assert np.isfinite(found.level).sum(axis=1).tolist() == [5, 8]
    for spikes, count in zip(found.level, (5, 8), strict=True):
        assert np.all(np.diff(spikes[:count]) > 0.0)  # the higher, the later
        assert 0.0 < spikes[0] < NUMBERS.rise + 60e-6
    assert found.clipped == 0
    assert listen(NUMBERS, CHIP, np.array([9.0, 0.1]), 0.0).clipped == 1
    assert not np.isfinite(listen(NUMBERS, CHIP, np.zeros(2), 0.0).level).any()


def test_the_nearer_ear_hears_it_sooner() -> None:
    envelope = np.ones(2)
    ahead, left = (listen(NUMBERS, CHIP, envelope, a).level for a in (0.0, np.radians(30.0)))
    on = np.isfinite(ahead)
    sooner = 0.5 * NUMBERS.spacing / SPEED * 0.5
    assert ahead[0][on[0]] - left[0][on[0]] == pytest.approx(sooner)
    assert ahead[1][on[1]] - left[1][on[1]] == pytest.approx(-sooner)


def test_a_level_unit_that_is_not_at_rest_is_deaf() -> None:
    deaf = CHIP._replace(rest=np.where(np.arange(10) == 3, 1.0, CHIP.rest))
    assert not hearing(NUMBERS, deaf)[:, 3].any()
    assert hearing(NUMBERS, CHIP).all()
    assert np.isinf(listen(NUMBERS, deaf, np.ones(2), 0.0).level[:, 3]).all()
