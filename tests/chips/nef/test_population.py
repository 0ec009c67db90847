"""Ensembles on tuning curves: gains, biases, decoders of given curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from chips.nef.network.curves import IdealCurves
from chips.nef.network.network import Ensemble
from chips.nef.population import evaluate, populate
from circuits.arrays import F64
from circuits.errors import ParameterError


@dataclass(frozen=True)
class LinearCurves:
    """Rates of neurons that differ: slope_k (J - threshold_k) above it, as measured ones might."""

    slope: F64
    threshold: F64

    def rates(self, first: int, current: F64) -> F64:
        own = slice(first, first + current.shape[1])
        return np.asarray(np.maximum(self.slope[own] * (current - self.threshold[own]), 0.0))

    def currents(self, first: int, rate: F64) -> F64:
        own = slice(first, first + len(rate))
        return np.asarray(self.threshold[own] + rate / self.slope[own])


def test_gain_and_bias_meet_rate_and_intercept() -> None:
    p = populate(
        Ensemble("a", 40, radius=2.0, max_rates=(150.0, 150.0), intercepts=(0.3, 0.3)), IdealCurves(), 0, 1
    )
    at_intercept, at_radius = p.gain * 0.3 + p.bias, p.gain + p.bias
    assert at_intercept == pytest.approx(np.ones(40))
    assert IdealCurves().rates(0, at_radius[None])[0] == pytest.approx(np.full(40, 150.0))


@pytest.mark.parametrize("dimensions", [1, 2])
def test_decoders_give_the_function_back(dimensions: int) -> None:
    p = populate(Ensemble("a", 200, dimensions), IdealCurves(), 0, 1)
    values = (p.points**2).sum(axis=1, keepdims=True)
    off = p.rates @ p.decoders(values, p.factor(0.01)) - values
    # 200 neurons: some per cent of the range of 1
    assert float(np.sqrt((off**2).mean())) < 0.03


def test_more_regularisation_gives_smaller_decoders() -> None:
    p = populate(Ensemble("a", 100), IdealCurves(), 0, 1)
    few, much = (np.abs(p.decoders(p.points, p.factor(r))).sum() for r in (0.01, 0.5))
    assert much < few


def test_curves_of_any_kind_can_be_given() -> None:
    random = np.random.default_rng(3)
    curves = LinearCurves(random.uniform(50.0, 300.0, 130), random.uniform(0.5, 2.0, 130))
    p = populate(Ensemble("a", 100), curves, 30, 1)
    assert p.rates.max(axis=0).min() >= 150.0  # at the ends of the radius: 200 Hz or more on one of them
    off = p.rates @ p.decoders(p.points, p.factor(0.01)) - p.points
    assert float(np.sqrt((off**2).mean())) < 0.02  # rectified lines of 100 neurons


def test_draws_depend_on_seed_and_name_alone() -> None:
    one, same = (populate(Ensemble("a", 20), IdealCurves(), first, 5) for first in (0, 70))
    assert (one.gain == same.gain).all()
    assert (one.gain != populate(Ensemble("b", 20), IdealCurves(), 0, 5).gain).any()
    assert (one.gain != populate(Ensemble("a", 20), IdealCurves(), 0, 6).gain).any()


def test_a_rate_that_no_neuron_reaches() -> None:
    with pytest.raises(ParameterError, match=r"a.max_rates: 600 Hz, neuron 7 cannot fire so fast"):
        populate(Ensemble("a", 5, max_rates=(600.0, 600.0)), IdealCurves(), 7, 0)


def test_functions_that_cannot_be() -> None:
    points = np.linspace(-1.0, 1.0, 11)[:, None]
    with pytest.raises(
        ParameterError, match=r"a->b.function: shape \(11,\) of \(11, 1\), must be \(11, results\)"
    ):
        evaluate(lambda x: x[:, 0], points, "a->b")
    with pytest.raises(ParameterError, match=r"a->b.function: shape \(1, 1\)"):
        evaluate(lambda x: x[:1], points, "a->b")
    with pytest.raises(ParameterError, match=r"a->b.function: not finite at \[-1"):
        evaluate(lambda x: np.where(x < 0.0, np.nan, x), points, "a->b")
