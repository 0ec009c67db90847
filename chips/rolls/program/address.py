"""Addresses of ROLLS: words that stimulate a synapse, words that write a latch, and what a word means.

A spike leaves the chip as its neuron's number, 0 to 255. A word sent to the chip has 22 bits:

    stimulate:  neuron + (column << 8)
    latch:      offset + post + (pre << 8) + (bit << 16) + (latch << 17)

Columns 0 to 255 are a neuron's plastic synapses, 256 to 511 its non-plastic ones (256 + the neuron that
sends), 512 to 515 its excitatory virtual ones and 516 to 519 the inhibitory ones. A region of latches has an
offset and its latches by number:

| region | offset | latches |
|---|---|---|
| non-plastic synapse | 133632 | recurrent, sign (1: excitatory), w0, w1, broadcast |
| plastic synapse | 788992 | recurrent, broadcast |
| plastic weight | 1051136 | weight |

The leak of a neuron takes IF_TAU1 after the words 1249026 + neuron, 1249283, 1249026 + neuron; 1249282 and
1249283 put all neurons to IF_TAU2. The regions touch: each begins where the one before ends (derived; a test
says so), and a word never means two things.

Sources: columns from `mn256r1.nhml` and `aerctl.h`, latch words from `aerctl.cpp` and `AERmn256r1.py`, leak
words from `AERmn256r1.py`, all of the chip's control software (mn256r1_ncs and NCSRobotLib).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import I64, Bools
from circuits.errors import ParameterError

NEURONS = 256
NONPLASTIC = 256
"""First column of the non-plastic synapses of a neuron."""
VIRTUAL_EXCITATORY = 512
"""First column of the excitatory virtual synapses of a neuron."""
VIRTUAL_INHIBITORY = 516
"""First column of the inhibitory virtual synapses of a neuron."""
COLUMNS = 520
VIRTUAL_LINES = 4  # of either sign that the addresses have room for
WORD_BITS = 22

LEAK_TAU1 = 1249026  # + neuron
LEAK_RESET, LEAK_RELEASE = 1249282, 1249283

_BIT, _LATCH = 16, 17  # shifts


@dataclass(frozen=True, slots=True)
class Region:
    """Latches of 256 x 256 cells: words from `offset` on, `latches` by the order of their numbers."""

    name: str
    offset: int
    latches: tuple[str, ...]

    @property
    def end(self) -> int:
        """First word behind the region."""
        return self.offset + (len(self.latches) << _LATCH)


NONPLASTIC_LATCHES = Region("non-plastic synapse", 133632, ("recurrent", "sign", "w0", "w1", "broadcast"))
PLASTIC_LATCHES = Region("plastic synapse", 788992, ("recurrent", "broadcast"))
PLASTIC_WEIGHTS = Region("plastic weight", 1051136, ("weight",))
REGIONS = (NONPLASTIC_LATCHES, PLASTIC_LATCHES, PLASTIC_WEIGHTS)


@dataclass(frozen=True, slots=True)
class VirtualSynapses:
    """How many virtual synapses a neuron has.

    Attributes
    ----------
    excitatory, inhibitory : int
        How many of either sign, 0 to 4.

    Raises
    ------
    ParameterError
        There are other numbers of them.
    """

    excitatory: int = VIRTUAL_LINES
    inhibitory: int = VIRTUAL_LINES

    def __post_init__(self) -> None:
        for name, count in (("excitatory", self.excitatory), ("inhibitory", self.inhibitory)):
            if not 0 <= count <= VIRTUAL_LINES:
                raise ParameterError(
                    f"virtual_synapses.{name}: {count}, must be 0 to {VIRTUAL_LINES};"
                    f" the addresses have {VIRTUAL_LINES} columns of either sign"
                )

    def columns(self, *, inhibitory: bool) -> range:
        """Return the columns of the virtual synapses that are `inhibitory`, or of those that excite."""
        first = VIRTUAL_INHIBITORY if inhibitory else VIRTUAL_EXCITATORY
        return range(first, first + (self.inhibitory if inhibitory else self.excitatory))


LAB_VIRTUAL = VirtualSynapses()  # mn256r1.nhml: four excitatory, four inhibitory
# Milde et al. 2017, section 2.1: four. Which four is not said; the robot's code uses the excitatory ones.
PAPER_VIRTUAL = VirtualSynapses(4, 0)


class LatchWrites(NamedTuple):
    """What latch words write: int64 of the words' shape each; `latch` counts within the region."""

    post: I64
    pre: I64
    latch: I64
    bit: I64


def stimulate_words(neuron: ArrayLike, column: ArrayLike) -> I64:
    """Return the words that give one event to the synapse at `column` of `neuron`, int64.

    Raises `ParameterError` for a neuron or a column that the chip does not have.
    """
    neurons = _inside("neuron", neuron, NEURONS, "the chip has 256 neurons")
    columns = _inside("column", column, COLUMNS, "virtual synapses begin at 512")
    return neurons + (columns << 8)


def read_stimulate_words(words: ArrayLike) -> tuple[I64, I64]:
    """Return neurons and columns of stimulate words, int64 each; raises `ParameterError` for other words."""
    found = _inside("word", words, COLUMNS << 8, "words from there on write latches")
    return found & 255, found >> 8


def latch_words(region: Region, post: ArrayLike, pre: ArrayLike, latch: ArrayLike, bit: ArrayLike) -> I64:
    """Return the words that write `bit` to a latch of the cell from neuron `pre` to neuron `post`, int64.

    latch: its number in the region. Raises `ParameterError` for a neuron or latch that the region does not
    have, and a bit that is not 0 or 1.
    """
    to = _inside("post", post, NEURONS, "the chip has 256 neurons")
    origin = _inside("pre", pre, NEURONS, "the chip has 256 neurons")
    which = _inside("latch", latch, len(region.latches), f"they are {', '.join(region.latches)}")
    value = _inside("bit", bit, 2, "a latch is off or on")
    words: I64 = region.offset + to + (origin << 8) + (value << _BIT) + (which << _LATCH)
    return words


def read_latch_words(region: Region, words: ArrayLike) -> LatchWrites:
    """Return what words of one region write; raises `ParameterError` for a word outside it."""
    found = np.asarray(words, dtype=np.int64)
    outside = ~in_region(region, found)
    if outside.any():
        k = int(outside.ravel().argmax())
        raise ParameterError(
            f"address.word[{k}]: {found.ravel()[k]}, must be {region.offset} to {region.end - 1}"
            f" for a {region.name}; sort words with in_region"
        )
    inner = found - region.offset
    return LatchWrites(inner & 255, inner >> 8 & 255, inner >> _LATCH, inner >> _BIT & 1)


def in_region(region: Region, words: ArrayLike) -> Bools:
    """Return whether each word writes a latch of the region."""
    found = np.asarray(words, dtype=np.int64)
    inside: Bools = (found >= region.offset) & (found < region.end)
    return inside


def leak_words(neurons: ArrayLike) -> I64:
    """Return the words that put all neurons to IF_TAU2 and then `neurons` to IF_TAU1, int64[2 + 3 n].

    Raises `ParameterError` for a neuron that the chip does not have.
    """
    chosen = np.atleast_1d(_inside("neuron", neurons, NEURONS, "the chip has 256 neurons"))
    select = chosen + LEAK_TAU1
    each = np.stack((select, np.full_like(select, LEAK_RELEASE), select), axis=1)
    return np.concatenate((np.array((LEAK_RESET, LEAK_RELEASE), dtype=np.int64), each.ravel()))


def _inside(name: str, values: ArrayLike, count: int, remedy: str) -> I64:
    """Integers as int64; raises `ParameterError` where one is not 0 to count - 1."""
    given = np.asarray(values)
    if given.dtype.kind not in "iub" and given.size:
        raise ParameterError(f"address.{name}: {given.dtype} values, must be whole numbers; convert them")
    found = given.astype(np.int64)
    wrong = (found < 0) | (found >= count)
    if wrong.any():
        k = int(wrong.ravel().argmax())
        where = f"[{k}]" if found.ndim else ""
        raise ParameterError(f"address.{name}{where}: {found.ravel()[k]}, must be 0 to {count - 1}; {remedy}")
    return found
