"""Draws of normals, many at once, against their parts one by one."""

import numpy as np
from scipy import special

from circuits.silicon.die import philox
from circuits.silicon.normal import fill_normals

KEYS = np.array([[1, 2**32 - 1, 77, 5], [3, 9, 2**31, 6]], dtype=np.uint32)
SHAPES = np.array([[300, 2, -1, -1], [-1, -1, -1, -1], [0, 3, -1, -1], [2, 700, -1, -1]])


def one_by_one(fixed: list[int]) -> np.ndarray:
    """Each draw by the generator's words and `scipy.special.ndtri`."""
    drawn = []
    for key, shape in zip(KEYS.T, SHAPES, strict=True):
        for index in np.ndindex(*(n for n in shape if n >= 0)):
            counter, words = np.zeros((4, 1), np.uint32), np.zeros((2, 1), np.uint32)
            counter[: len(fixed) + len(index), 0] = [*fixed, *index]
            philox(key[:, None].copy(), counter, words)
            bits = (int(words[0, 0]) << 21) ^ (int(words[1, 0]) >> 11)
            drawn.append((bits + 0.5) * 2.0**-53)
    return np.asarray(special.ndtri(drawn))


def test_draws_are_those_of_single_counters_to_the_last_bit() -> None:
    for fixed in ([], [12, 2**32 - 1]):
        out = np.empty(2001)
        fill_normals(KEYS, np.array(fixed, dtype=np.uint32), SHAPES, out)
        np.testing.assert_array_equal(out, one_by_one(fixed))
    assert (np.abs(out) > 1.2).any()  # tails are among them


def test_many_draws_have_the_mean_and_spread_of_a_normal() -> None:
    out = np.empty(400_000)
    fill_normals(KEYS[:, :1], np.empty(0, np.uint32), np.array([[400_000, -1, -1, -1]]), out)
    assert 4.0 < np.abs(out).max() < 6.0
    assert abs(out.mean()) < 5.0 / 400_000**0.5
    assert abs(out.std() - 1.0) < 5.0 / 800_000**0.5
