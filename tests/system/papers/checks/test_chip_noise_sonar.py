"""Jitter of the sonar's parts beside that of transistors: short runs, and the rows' rule."""

import pytest

from system.papers.checks.chip_noise import LEFT_OUT, sonar_rows
from system.papers.checks.chip_noise_sonar import call_beside, hearing_beside, step_beside
from system.papers.checks.jitter_beside import Beside


def test_a_row_allows_what_its_trials_know() -> None:
    near, far = (Beside(n, 1e-3, 1e-6, 200, 1e-6 * by) for n, by in (("near", 1.19), ("far", 1.21)))
    made = sonar_rows([near, far])
    assert made[0].rule.tolerance == pytest.approx(LEFT_OUT + 0.15)
    assert [row.agrees for row in made] == [True, False]


def test_the_comparator_calls_with_the_jitter_of_its_resistors() -> None:
    found = call_beside(24)
    assert found.model == pytest.approx(0.23e-6, rel=0.03)
    assert found.ratio == pytest.approx(1.0, abs=3.0 * found.known + LEFT_OUT)  # 24 trials know 14 %


def test_what_is_put_side_by_side_is_the_same_time() -> None:
    """Means of either side agree, which the record's own errors allow: 16 us of a latency, 1 % of a step."""
    step = step_beside(2)
    assert step.mean == pytest.approx(4.07e-3, rel=0.01)
    assert 0.3e-6 < step.model < 0.6e-6  # sqrt(q phi T / I) at 2.5 nA
    sound = hearing_beside("high_threshold", 1.4, 2)
    assert sound.mean == pytest.approx(216e-6, abs=3e-6)
    assert 3e-9 < sound.model < 6e-9
