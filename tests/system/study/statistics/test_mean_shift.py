"""A planted failure of 1e-4 in 68 dimensions is found within a factor of 1.5 with 5,000 samples."""

import numpy as np
import pytest

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError, SolverError
from system.study.statistics.mean_shift import LEAST_EFFECTIVE, mean_shift
from tests.system.study.planted import DIMENSIONS, planted

SAMPLES = 5000
TRUTH = 1e-4


def test_the_planted_distribution_is_right() -> None:
    metric, limit = planted(), planted().limit(0.05)
    z = np.random.default_rng(0).standard_normal((100_000, DIMENSIONS))
    assert np.mean(metric.value(z) > limit) == pytest.approx(0.05, abs=0.0021)  # three standard errors


@pytest.mark.parametrize("seed", range(5))
def test_a_planted_failure_is_within_a_factor_of_one_and_a_half(seed: int) -> None:
    metric, called = planted(), 0
    limit = metric.limit(TRUTH)

    def fails(z: F64) -> Bools:
        nonlocal called
        called += len(z)
        return metric.value(z) > limit

    found = mean_shift(fails, DIMENSIONS, SAMPLES, np.random.default_rng(seed))
    assert TRUTH / 1.5 < found.probability < TRUTH * 1.5
    assert found.samples == called == SAMPLES
    assert found.effective_samples >= LEAST_EFFECTIVE
    assert found.interval.low < found.probability < found.interval.high


def test_both_sides_are_found() -> None:
    direction = planted().linear

    def fails(z: F64) -> Bools:
        return np.abs(z @ direction) > 3.8906  # 1e-4 in all

    found = mean_shift(fails, DIMENSIONS, SAMPLES, np.random.default_rng(0))
    assert TRUTH / 1.5 < found.probability < TRUTH * 1.5
    assert found.detail.startswith("2 regions")


def test_a_flat_boundary_of_one_dimension_has_its_probability() -> None:
    found = mean_shift(lambda z: z[:, 0] > 4.7534, 1, SAMPLES, np.random.default_rng(0))
    assert found.probability == pytest.approx(1e-6, rel=0.15)  # effective samples of 600: 4 % each way


def test_the_interval_covers() -> None:
    covered = []
    for seed in range(40):
        found = mean_shift(lambda z: z.sum(axis=1) > 7.438, 4, 1500, np.random.default_rng(seed))
        covered.append(1.0e-4 in found.interval)  # 7.438 / 2 is the quantile of 1e-4
    assert np.mean(covered) >= 0.85  # 95 % less three standard errors of 40


def test_the_same_generator_gives_the_same_answer() -> None:
    def run() -> object:
        return mean_shift(lambda z: z[:, 0] > 3.0, 5, 1000, np.random.default_rng(3))

    assert run() == run()


def test_a_small_effective_size_is_refused() -> None:
    """A shell all around is no region that a shift can reach."""

    def fails(z: F64) -> Bools:
        outside: Bools = (z * z).sum(axis=1) > 60.0
        return outside

    with pytest.raises(SolverError, match=r"effective sample size \d+ .* must be >= 50"):
        mean_shift(fails, 20, 1000, np.random.default_rng(0))


def test_a_search_that_leaves_too_few_samples_is_refused() -> None:
    normal = np.array([0.81, 0.57, 0.1, 0.0, 0.0, 0.0])
    with pytest.raises(
        SolverError, match=r"the search for failing dies took 6\d\d of 600 samples, must leave"
    ):
        mean_shift(lambda rows: rows @ normal > 2.94, 6, 600, np.random.default_rng(0))


def test_no_failure_is_refused() -> None:
    with pytest.raises(SolverError, match=r"mean-shift: 0 failures of .* at 4 sigma"):
        mean_shift(lambda z: z[:, 0] > 99.0, 3, 1000, np.random.default_rng(0))


def test_a_failing_nominal_die_is_refused() -> None:
    with pytest.raises(ParameterError, match="the nominal die fails"):
        mean_shift(lambda z: z[:, 0] < 1.0, 3, 1000, np.random.default_rng(0))
