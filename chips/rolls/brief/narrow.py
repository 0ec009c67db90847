"""Tables of a ROLLS chip's first neurons alone, in which each does what it does among all of them.

Nothing in a step passes between neurons but the charges of their synapses and the bus. So neurons behind the
last one of interest are left out to the bit where they excite and inhibit none before them, and where the bus
loses no spike whatever they send: their draws of noise stay their places'.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from chips.aer import Bus
from chips.noise_draw import first_draws, first_slow
from chips.rolls.layout import DELAY, REFRACTORY, Banks, FilterBank, Membranes
from chips.rolls.noise.layout import NoiseTables
from chips.rolls.program.address import NEURONS
from chips.rolls.tables import Built

PACKED = NEURONS // 4  # neurons whose draws are of one word of the generator's


def fewest(neurons: int) -> int:
    """Return how many of the first neurons there can be, `neurons` at least."""
    return PACKED * -(-neurons // PACKED)


def stands_alone(built: Built, size: int, bus: Bus) -> bool:
    """Whether the first `size` neurons of a chip do the same without all others."""
    t = built.tables
    spiking = t.membranes.spiking
    pause = float((spiking[:, REFRACTORY] + spiking[:, DELAY]).min())
    # each neuron sends once at most while the bus sends all that may wait
    lossless = bus.depth >= NEURONS and pause > bus.depth * bus.service
    apart = built.plastic is None and built.depression is None and not t.charges[size:, :size].any()
    return bool(size % PACKED == 0 and lossless and apart)


def narrowed(built: Built, size: int) -> Built:
    """Return the tables of a chip whose steps are of its first `size` neurons alone."""
    t, noise = built.tables, built.noise
    banks, parts = _banks(t.banks, size), _banks(t.part_banks, size)
    tables = t._replace(
        banks=banks, part_banks=parts, membranes=Membranes(*_rows(t.membranes, size)),
        charges=t.charges[:size, :size].copy(),
        virtual=t.virtual[:, :size].copy(), fast=t.fast[:, :size].copy(),
    )  # fmt: skip
    return replace(built, tables=tables, noise=None if noise is None else _noise(noise, size))


def _noise(t: NoiseTables, size: int) -> NoiseTables:
    return t._replace(
        rows=t.rows[:size].copy(),
        grain=t.grain[:, :size].copy(),
        excess=t.excess[:, :size].copy(),
        draws=first_draws(t.draws, size),
        slow=first_slow(t.slow, size),
    )


def _banks(banks: Banks, size: int) -> Banks:
    a, b, c, d = (FilterBank(*_rows(bank, size)) for bank in banks)
    return a, b, c, d


def _rows(whole: Iterable[Any], size: int) -> Iterator[Any]:
    """The first rows of all arrays, and what is none."""
    return (each[:size].copy() if isinstance(each, np.ndarray) else each for each in whole)
