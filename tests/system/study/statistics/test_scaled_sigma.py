"""The extrapolation finds what the model says, and says how uncertain it is."""

import numpy as np
import pytest
from scipy.special import ndtr

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError, SolverError
from system.study.statistics.scaled_sigma import SCALES, extrapolate, scaled_sigma


def test_exact_counts_of_the_model_give_its_probability() -> None:
    scales = np.array([1.4, 1.8, 2.5, 4.0])
    tried = np.full(4, 10**12)
    failed = np.round(tried * np.exp(-2.0 + 0.5 * np.log(scales) - 7.0 / scales**2)).astype(np.int64)
    found = extrapolate(scales, tried, failed, np.random.default_rng(0))
    assert found.probability == pytest.approx(np.exp(-9.0), rel=1e-4)  # counts are whole numbers
    assert found.interval.half_width < 1e-3 * found.probability


def test_a_flat_boundary_with_many_samples() -> None:
    """P(z > 3.09) = 1e-3: at a million samples what is left is the model's own error, some 20 %."""

    def fails(z: F64) -> Bools:
        beyond: Bools = z @ np.array([0.6, 0.8]) > 3.0902
        return beyond

    found = scaled_sigma(fails, 2, 1_000_000, np.random.default_rng(1))
    assert found.probability == pytest.approx(ndtr(-3.0902), rel=0.3)
    assert found.samples == 1_000_000
    assert np.isnan(found.effective_samples)


def test_the_interval_covers_with_few_samples() -> None:
    """A probability of 1e-3 from 3,000 samples, where chance outweighs the model's error."""
    scales, truth = np.array(sorted(SCALES)), 1e-3
    tried = np.array([1200, 900, 600, 300])
    c = np.log(truth)  # a = 0, b = 0
    rng = np.random.default_rng(2)
    covered = [
        truth in extrapolate(scales, tried, rng.binomial(tried, np.exp(c / scales**2)), rng).interval
        for _ in range(60)
    ]
    assert 0.85 <= np.mean(covered) <= 1.0  # 95 % within three standard errors of 60 experiments


def test_zero_failures_at_the_smallest_scale_count() -> None:
    scales, tried = np.array([1.4, 1.8, 2.5, 4.0]), np.array([2000, 1500, 1000, 500])
    found = extrapolate(scales, tried, np.array([0, 12, 60, 110]), np.random.default_rng(0))
    assert 0.0 < found.probability < 1e-3
    assert "failures 0/2000 at 1.4" in found.detail


def test_resamples_in_which_too_few_scales_fail_are_of_no_failure() -> None:
    """Five failures are none in one resample of 150, beside none at the smallest scale two scales of four."""
    scales, tried = np.array([1.4, 1.8, 2.5, 4.0]), np.array([2000, 1500, 1000, 500])
    found = extrapolate(scales, tried, np.array([0, 5, 41, 81]), np.random.default_rng(0))
    assert 0.0 <= found.interval.low < found.probability < found.interval.high < 5.0 / 1500.0


def test_too_few_failures_are_refused() -> None:
    with pytest.raises(SolverError, match=r"scaled-sigma: failures 0/500 at 1\.4 .* at three scales"):
        scaled_sigma(lambda z: z[:, 0] > 99.0, 3, 1250, np.random.default_rng(0))


def test_scales_must_extrapolate() -> None:
    with pytest.raises(ParameterError, match=r"scales: .* three or more above 1"):
        scaled_sigma(
            lambda z: z[:, 0] > 1.0, 3, 5000, np.random.default_rng(0), {1.0: 0.5, 2.0: 0.3, 3.0: 0.2}
        )


def test_where_all_dies_fail_nothing_is_extrapolated() -> None:
    with pytest.raises(SolverError, match="must not be all dies; sample plainly"):
        scaled_sigma(lambda z: np.ones(len(z), dtype=np.bool_), 2, 1000, np.random.default_rng(0))
