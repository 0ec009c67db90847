"""Events of virtual synapses put together: each neuron's in each step come back in their order."""

import numpy as np
import pytest

from chips.aer import Events
from chips.rolls.brief.encoded import LONGEST, Encoded, encode

STEP, NEURONS = 0.4e-3, 5


def drawn(count: int, seed: int) -> Events:
    """Events at random times, in bursts over columns and one by one."""
    rng = np.random.default_rng(seed)
    times = np.sort(
        np.round(rng.uniform(0.0, 5.2 * STEP, count), 5)
    )  # many at one time, some at a step's end
    columns = np.where(rng.random(count) < 0.8, np.arange(count) % 4, rng.integers(8, size=count))
    return Events(times, rng.integers(NEURONS, size=count) + ((512 + columns) << 8), 7)


def decoded(found: Encoded) -> list[list[int]]:
    """Columns of a step, sign and neuron, in their order."""
    tokens, rows = iter(found.tokens.tolist()), found.many.shape[0] * 2 * NEURONS
    every = []
    for k in range(rows):
        some: list[int] = []
        for _ in range(int(found.many.ravel()[k])):
            token = next(tokens)
            some += [(token + j) % 4 for j in range(token >> 2)]
        every.append(some)
    assert next(tokens, None) is None
    return every


@pytest.mark.parametrize("count", [0, 1, 3000])
def test_the_columns_of_a_step_a_sign_and_a_neuron_come_back_in_order(count: int) -> None:
    events = drawn(count, 3)
    found = encode(events, STEP, 5, NEURONS)
    assert found is not None
    assert found.dropped == 7
    column = (events.addresses >> 8) - 512
    number = np.array([sum(t >= k * STEP + STEP for k in range(6)) for t in events.times], dtype=int)
    wanted = [
        (column[(number == k) & (column // 4 == sign) & (events.addresses & 255 == neuron)] % 4).tolist()
        for k in range(5)
        for sign in range(2)
        for neuron in range(NEURONS)
    ]
    assert decoded(found) == wanted
    assert found.size < 16 * count + 2 * found.many.size


def test_runs_that_are_too_long_are_cut() -> None:
    count = 2 * LONGEST + 3
    found = encode(Events(np.zeros(count), (512 + np.arange(count) % 4) << 8), STEP, 1, NEURONS)
    assert found is not None
    assert (found.tokens >> 2).tolist() == [LONGEST, LONGEST, 3]


@pytest.mark.parametrize(
    "words", [300 << 8, (512 << 8) + NEURONS, np.full(256, 512 << 8)], ids=["column", "neuron", "many"]
)
def test_what_does_not_fit_is_none(words: int | np.ndarray) -> None:
    addresses = np.atleast_1d(words)
    assert encode(Events(np.zeros(addresses.size), addresses), STEP, 1, NEURONS) is None
