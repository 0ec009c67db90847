"""A chip between any environment and its actions: it acts, it is overruled, and each reset begins it anew."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from chips.live.table import open_chip
from circuits.silicon.die import Die
from system.gym.on_chip import OnChip
from system.play.decoder import RateDecoder, VoteDecoder
from system.play.encoder import LatencyCode, Ranges
from system.play.policy import ChipPolicy

HALVES = [range(6), range(6, 13)]


def policy(decoder: Any) -> ChipPolicy:
    """A ranging chip that hears a call, and the pole's angle as an echo's delay."""
    encoder = LatencyCode(Ranges((0.0, -0.2), (1.0, 0.2), ((0,), (1,))))
    return ChipPolicy(
        open_chip("ranging-chip", Die("A", 1001)), encoder, decoder, 20e-3, lambda x: (1.0, x[2])
    )


def steps(environment: Any, action: Any) -> list[Any]:
    """What five steps from seed 3 on say."""
    environment.reset(seed=3)
    return [environment.step(action) for _ in range(5)]


def test_the_chip_acts_and_each_reset_begins_it_anew() -> None:
    environment = OnChip(gymnasium.make("CartPole-v1"), policy(VoteDecoder(HALVES)))
    first, second = steps(environment, None), steps(environment, None)
    assert all(np.array_equal(a[0], b[0]) for a, b in zip(first, second, strict=True))
    chosen = [told["chip_action"] for *_, told in first]
    plain = gymnasium.make("CartPole-v1")
    plain.reset(seed=3)
    assert all(np.array_equal(plain.step(a)[0], b[0]) for a, b in zip(chosen, first, strict=True))


def test_an_action_that_is_given_goes_over_the_chips() -> None:
    environment = OnChip(gymnasium.make("CartPole-v1"), policy(VoteDecoder(HALVES)))
    pushed = [told[0][1] for told in steps(environment, 1)]
    assert np.all(np.diff(pushed) > 0.0)  # the cart's speed rises


def test_real_actions_have_the_shape_of_their_space() -> None:
    decoder = RateDecoder(HALVES, np.array([[1e-3, -1e-3]]))
    environment = OnChip(gymnasium.make("MountainCarContinuous-v0"), policy(decoder))
    environment.policy._features = lambda x: (1.0, x[0])
    seen, *_ = steps(environment, None)[-1]
    assert seen.shape == (2,)
