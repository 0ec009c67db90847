"""Events of virtual synapses as a chip from rest takes them: those of each neuron in each step, in order.

What a step adds to a filter's charge is the sum over the events of its neuron and sign alone, in their order.
So these are put together once, after the bus, as runs over the four columns of a sign: a token is the column
of the first event and how many follow, each in the next column, the first behind the last. A neuron's burst
is one token, and no die changes it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from chips.aer import Events
from chips.rolls.program.address import VIRTUAL_EXCITATORY, VIRTUAL_LINES
from circuits.arrays import F32, F64, I64, in_rows
from circuits.compiled import compiled

LONGEST, MOST = 63, 255  # events of a token, and tokens of a neuron and sign in a step
_FULL = -1
_compiled = compiled()


class Encoded(NamedTuple):
    """Events of the steps from rest on.

    tokens: first column + (events << 2), uint8[m], by step, sign, neuron and time; many: of these,
    uint8[steps, 2, neurons]; dropped: events that the bus lost before them.
    """

    tokens: NDArray[np.uint8]
    many: NDArray[np.uint8]
    dropped: int

    @property
    def size(self) -> int:
        """Bytes that it takes."""
        return self.tokens.nbytes + self.many.nbytes


class Summed(NamedTuple):
    """Encoded events for a chip's kernel.

    tokens, many: as of `Encoded`; firsts: what a token alone adds to a charge, float32[2, columns, longest,
    neurons], of signs, first columns and how many events up to `LONGEST`.
    """

    tokens: NDArray[np.uint8]
    many: NDArray[np.uint8]
    firsts: F32


def firsts_of(virtual: F32) -> F32:
    """Return what tokens alone add to a charge, event after event; virtual: of one event, by column."""
    own = virtual.reshape(2, VIRTUAL_LINES, -1)
    found = np.zeros((2, VIRTUAL_LINES, LONGEST + 1, own.shape[2]), np.float32)
    for column in range(VIRTUAL_LINES):
        for k in range(LONGEST):
            found[:, column, k + 1] = found[:, column, k] + own[:, (column + k) % VIRTUAL_LINES]
    return found


def encode(arrived: Events, step: float, steps: int, neurons: int) -> Encoded | None:
    """Return the events of `steps` steps of `step` s from 0 s on, None where they do not fit.

    arrived: over the bus, of the first `neurons` neurons, addressed as `neuron + (column << 8)`; events of
    other than virtual synapses do not fit.
    """
    many = np.zeros((steps, 2, neurons), np.uint8)
    tokens, rows = np.empty(arrived.times.size, np.uint8), np.empty(arrived.times.size, np.uint8)
    work = np.zeros((2, 2 * neurons + 1), np.int64)
    times, words = in_rows(arrived.times), in_rows(arrived.addresses)
    count = _encode(times, words, step, many, tokens, rows, work)
    return None if count == _FULL else Encoded(tokens[:count].copy(), many, arrived.dropped)


@_compiled
def _encode(
    times: F64, words: I64, step: float, many: NDArray[np.uint8], tokens: NDArray[np.uint8],
    columns: NDArray[np.uint8], work: I64,
) -> int:  # fmt: skip
    """Fill `many` and `tokens`; how many tokens there are, or `_FULL`. columns, work: working space."""
    neurons, event, count = many.shape[2], 0, 0
    begin, place = work[0], work[1]
    for number in range(many.shape[0]):
        first, until = event, number * step + step
        begin[:] = 0
        while event < times.size and times[event] < until:
            column, k = (words[event] >> 8) - VIRTUAL_EXCITATORY, words[event] & 255
            if not 0 <= column < 2 * VIRTUAL_LINES or k >= neurons:
                return _FULL
            begin[(column // VIRTUAL_LINES) * neurons + k + 1] += 1
            event += 1
        for row in range(2 * neurons):
            place[row] = begin[row]
            begin[row + 1] += begin[row]
        for j in range(first, event):
            column = (words[j] >> 8) - VIRTUAL_EXCITATORY
            row = (column // VIRTUAL_LINES) * neurons + (words[j] & 255)
            columns[place[row]] = column % VIRTUAL_LINES
            place[row] += 1
        for row in range(2 * neurons):
            before = count
            count = _runs(columns, begin[row], begin[row + 1], tokens, count)
            if count - before > MOST:
                return _FULL
            many[number, row // neurons, row % neurons] = count - before
    return count


@_compiled
def _runs(
    columns: NDArray[np.uint8], begin: int, end: int, tokens: NDArray[np.uint8], count: int
) -> int:  # fmt: skip
    """Add the tokens of the events from `begin` to `end` to the first `count`; how many there are then."""
    j = begin
    while j < end:
        first, length = columns[j], 1
        while (
            j + length < end and length < LONGEST
            and columns[j + length] == (first + length) % VIRTUAL_LINES
        ):  # fmt: skip
            length += 1
        tokens[count] = first + (length << 2)
        count += 1
        j += length
    return count
