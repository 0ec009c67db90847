"""Weights on ROLLS' few: one to three are met, more are as near as the sums of three currents allow."""

import numpy as np
import pytest

from system.mapping.rolls.levels import MOST, levels_of, repeats_of


@pytest.mark.parametrize("weights", [[2.0], [1.0, 5.0], [1.0, 3.0, 4.5], [1.0, 2.0, 5.0, 6.0]])
def test_few_weights_and_the_sums_of_three_are_met(weights: list[float]) -> None:
    asked = np.array([[*weights, 0.0], [0.0, *weights]])
    found = levels_of(asked)
    assert np.concatenate(([0.0], found.charges))[found.chosen] == pytest.approx(asked, rel=1e-6)
    c, second, third, fourth = found.charges
    assert fourth - second == pytest.approx(third - c)


def test_many_weights_are_nearer_than_to_even_steps() -> None:
    asked = np.abs(np.random.default_rng(1).normal(size=(50, 50)))
    found = levels_of(asked)
    off = np.concatenate(([0.0], found.charges))[found.chosen] - asked
    even = asked.max() * np.arange(5) / 4.0
    plain = asked - even[np.abs(asked[..., None] - even).argmin(axis=-1)]
    assert (off**2).mean() < 0.75 * (plain**2).mean()


def test_events_of_one_synapse_stand_for_multiples_and_for_what_is_near() -> None:
    exact = repeats_of(np.array([0.5, 1.5, 0.0, 2.0]))
    assert exact.charge == 0.5
    assert exact.chosen.tolist() == [1, 3, 0, 4]
    asked = np.random.default_rng(2).uniform(0.2, 1.0, 100)
    near = repeats_of(asked)
    assert near.chosen.max() <= MOST
    assert near.charge * near.chosen == pytest.approx(asked, abs=0.5 * near.charge)
