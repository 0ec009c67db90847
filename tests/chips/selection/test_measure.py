"""Both levels beside each other, and what is said of their difference."""

import math

import numpy as np
import pytest

from chips.selection.measure import UNDECIDED, Pair, measure_pairs, pair_errors, random_profile
from circuits.blocks.selection.winner_take_all import CELLS, STANDING


def test_a_few_pairs_agree_on_the_whole_selection() -> None:
    """Eight pairs; of the 1,500 of the model's docstring 8 are undecided on one side."""
    pairs = measure_pairs((1000, 1001), 4)
    found = pair_errors(pairs)
    assert found["pairs"] == 8.0
    assert found["winners_differ"] == 0.0
    assert found["agree"] >= 7.0
    assert found["time_rms_relative"] < 0.2  # 6.5 % over 300 pairs


def test_profiles_are_the_generator_s_and_within_the_box() -> None:
    one, again = (random_profile(np.random.default_rng(5)) for _ in range(2))
    assert np.array_equal(one.excite, again.excite)
    assert np.array_equal(one.risk, again.risk)
    assert one.excite.shape == one.risk.shape == (CELLS,)
    assert one.excite.min() >= 50e-9
    assert one.excite.max() <= 80e-9
    assert one.risk.min() >= STANDING
    assert one.risk.max() <= 20e-9


def test_errors_count_every_kind_of_pair() -> None:
    pairs = [
        Pair(0, 3, 1e-5, 3, 1.1e-5, 0.1),
        Pair(0, 3, 1e-5, 4, 1e-5, 0.002),
        Pair(0, UNDECIDED, math.inf, 4, 1e-5, 0.001),
        Pair(0, UNDECIDED, math.inf, UNDECIDED, math.inf, 0.0),
    ]
    found = pair_errors(pairs)
    assert (found["pairs"], found["agree"], found["winners_differ"]) == (4.0, 2.0, 1.0)
    assert (found["one_undecided"], found["both_undecided"]) == (1.0, 1.0)
    assert found["time_rms_relative"] == pytest.approx(0.1)
    assert found["margin_wrong"] == 0.002
