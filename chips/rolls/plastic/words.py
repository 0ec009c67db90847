"""Words of ROLLS' plastic array, which write its latches and weights, and what words have left there.

A plastic synapse has the latches `recurrent`, which lets pulses in, and `broadcast`, which is not modelled,
and in a region of its own the weight, high or low (`chips.rolls.program.address`). A written weight is at its
rail.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.plastic.program import PlasticArray
from chips.rolls.program.address import (
    NEURONS,
    PLASTIC_LATCHES,
    PLASTIC_WEIGHTS,
    in_region,
    latch_words,
    read_latch_words,
)
from circuits.arrays import I64, Bools
from circuits.errors import ParameterError


def plastic_words(array: PlasticArray | None, since: PlasticArray | None = None) -> I64:
    """Return the words that write a plastic array: two latches a synapse, then the weights.

    The latches are recurrent and broadcast (always 0). Only what differs from `since` is written where that
    is given; nothing where there is no array and was none.
    """
    if array is None:
        if since is None:
            return np.empty(0, np.int64)
        array = PlasticArray(np.zeros((1, 1), np.bool_))
    changed = np.ones((2, NEURONS, NEURONS), np.bool_)
    if since is not None:
        changed = np.stack((array.latches != since.latches, array.start() != since.start()))
    pre, post = np.nonzero(changed[0].T)
    bits = np.stack((array.latches[post, pre], np.zeros(post.size, np.bool_)), axis=1)
    latches = latch_words(
        PLASTIC_LATCHES,
        post[:, None],
        pre[:, None],
        np.arange(len(PLASTIC_LATCHES.latches)),
        bits.astype(np.int64),
    )
    pre, post = np.nonzero(changed[1].T)
    return np.concatenate((latches.ravel(), _weight_words(post, pre, array.start()[post, pre])))


def _weight_words(post: I64, pre: I64, weights: Bools) -> I64:
    return latch_words(PLASTIC_WEIGHTS, post, pre, np.zeros_like(post), weights.astype(np.int64))


def plastic_of_words(words: I64) -> PlasticArray | None:
    """Return the array that words leave whose latches and weights were all off, None if they still are.

    Raises `ParameterError` for a word that sets a broadcast latch.
    """
    latches = np.zeros((len(PLASTIC_LATCHES.latches), NEURONS, NEURONS), np.bool_)
    writes = read_latch_words(PLASTIC_LATCHES, words[in_region(PLASTIC_LATCHES, words)])
    latches[writes.latch, writes.post, writes.pre] = writes.bit  # of several writes the last one holds
    weights = np.zeros((NEURONS, NEURONS), np.bool_)
    written = read_latch_words(PLASTIC_WEIGHTS, words[in_region(PLASTIC_WEIGHTS, words)])
    weights[written.post, written.pre] = written.bit
    recurrent, broadcast = latches
    if broadcast.any():
        post, pre = np.argwhere(broadcast)[0]
        raise ParameterError(
            f"program.words: plastic broadcast of {pre} to {post} is set, must be 0; not modelled"
        )
    return PlasticArray(recurrent, weights) if recurrent.any() or weights.any() else None
