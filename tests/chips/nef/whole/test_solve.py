"""A balance is where bisection has it, to the bit, of fewer evaluations."""

from collections.abc import Callable

import numpy as np
import pytest

from chips.nef.whole.solve import balance
from circuits.arrays import F64

_RANDOM = np.random.default_rng(9)
SHIFT = _RANDOM.uniform(0.0, 1.8, (40, 3))
LOW, HIGH = np.zeros((40, 3)), np.full((40, 3), 1.8)


def _bisected(excess: Callable[[F64], F64], low: F64, high: F64) -> F64:
    """40 halvings, all evaluated."""
    low, high = (x.copy() for x in np.broadcast_arrays(low, high))
    for _ in range(40):
        middle = 0.5 * (low + high)
        above = excess(middle) > 0.0
        high, low = np.where(above, middle, high), np.where(above, low, middle)
    return np.asarray(0.5 * (low + high))


EXCESSES: dict[str, Callable[[F64], F64]] = {
    "exponential": lambda v: np.expm1((v - SHIFT) / 0.026),
    "saturating": lambda v: np.tanh(500.0 * (v - SHIFT)) + 1e-3 * (v - SHIFT),
    "straight": lambda v: v - SHIFT,
    "step": lambda v: np.where(v > SHIFT, 1.0, -1.0),
    "always above": lambda v: 1.0 + v,
    "always below": lambda v: v - 2.0,
    "zero at the lower bound": lambda v: np.expm1(v / 0.03),
    "no number": lambda v: np.full_like(v, np.nan),
    "at different bounds": lambda v: v - 4.0 * SHIFT + 2.0,
}


@pytest.mark.parametrize("name", EXCESSES)
def test_it_has_the_bits_of_a_bisection(name: str) -> None:
    excess = EXCESSES[name]
    assert np.array_equal(balance(excess, LOW, HIGH), _bisected(excess, LOW, HIGH))
    assert np.array_equal(balance(excess, LOW[:1] + 0.01, HIGH), _bisected(excess, LOW[:1] + 0.01, HIGH))


def test_a_smooth_balance_takes_a_third_of_the_evaluations() -> None:
    asked = []

    def excess(v: F64) -> F64:
        asked.append(v.shape)
        return EXCESSES["exponential"](v)

    balance(excess, LOW, HIGH)
    assert 0 < len(asked) <= 16
