"""Shares of a planted polynomial of standard normals are found from samples."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.study.statistics.regression import enough, fit_linear, fit_quadratic

P = 20


def normals(samples: int, seed: int = 1) -> tuple[np.random.Generator, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng, rng.standard_normal((samples, P))


def test_a_line_is_found() -> None:
    rng, z = normals(2000)
    slope = np.zeros(P)
    slope[[0, 5]] = 2.0, 1.0
    fit = fit_linear(z, 7.0 + z @ slope + rng.standard_normal(2000))
    assert fit.r2 == pytest.approx(5.0 / 6.0, abs=0.02)  # sampling of 2,000
    assert fit.linear[0] == pytest.approx(4.0 / 6.0, abs=0.03)
    assert fit.linear[5] == pytest.approx(1.0 / 6.0, abs=0.03)
    assert fit.by_parameter().sum() == pytest.approx(fit.r2, abs=1e-14)


def test_noise_explains_nothing() -> None:
    found = []
    for seed in range(20):
        rng, z = normals(60, seed)
        found.append(fit_linear(z, rng.standard_normal(60)).r2)
    assert np.mean(found) < 0.12  # an R^2 that is not adjusted is 20 / 59 = 0.34 here


def test_squares_and_interactions_are_found() -> None:
    rng, z = normals(1500)
    y = (
        z[:, 0]
        + 1.5 * (z[:, 3] ** 2 - 1.0) / np.sqrt(2.0)
        + z[:, 1] * z[:, 2]
        + 0.2 * rng.standard_normal(1500)
    )
    linear, fit = fit_linear(z, y), fit_quadratic(z, y)
    total = 1.0 + 2.25 + 1.0 + 0.04
    assert linear.r2 < 0.3
    assert fit.r2 > 0.98
    assert fit.squares[3] == pytest.approx(2.25 / total, abs=0.03)
    assert fit.pairs[0].tolist() == [1, 2]
    assert fit.interactions[1:].sum() < 1e-3  # of false ones, which 5 % of fits have
    assert fit.interactions[0] == pytest.approx(1.0 / total, abs=0.03)
    assert fit.by_parameter()[1] == pytest.approx(0.5 / total, abs=0.03)
    assert fit.by_parameter().sum() == pytest.approx(fit.r2, abs=1e-14)


def test_a_line_gets_no_products() -> None:
    rng, z = normals(1000)
    fit = fit_quadratic(z, z[:, 0] + rng.standard_normal(1000))
    assert fit.squares.sum() + fit.interactions.sum() < 0.03


def test_a_constant_has_no_shares() -> None:
    _, z = normals(100)
    for fit in (fit_linear(z, np.ones(100)), fit_quadratic(z, np.ones(100))):
        assert fit.r2 == 0.0
        assert not fit.by_parameter().any()


def test_equal_columns_share() -> None:
    rng, z = normals(400)
    z[:, 1] = z[:, 0]
    fit = fit_linear(z, z[:, 0] + 0.1 * rng.standard_normal(400))
    assert fit.linear[0] == pytest.approx(fit.linear[1])
    assert fit.r2 > 0.98


def test_two_samples_a_term_are_needed() -> None:
    assert enough(2 * P + 2, P)
    assert not enough(2 * P + 1, P)
    rng, z = normals(2 * P + 1)
    with pytest.raises(ParameterError, match="regression: 41 samples, must be >= 42 for 20 parameters"):
        fit_linear(z, rng.standard_normal(2 * P + 1))


def test_products_never_exceed_the_samples() -> None:
    rng, z = normals(2 * P + 4)
    y = (z**2).sum(axis=1) + (z @ rng.standard_normal(P)) ** 2
    fit = fit_quadratic(z, y)
    assert np.count_nonzero(fit.squares) + len(fit.pairs) <= 1
