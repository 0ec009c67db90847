"""A map from the addresses of a sensor to those of a chip, as the mapper between real ones: a CSV file.

    from,to
    1024,131077
    1024,131078

An address may go to several; those without a row are no addresses of the chip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import I64, Bools
from circuits.errors import DataError
from system.option import option
from system.rows import read_rows, refusal
from system.stream.inlet import Takes


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of the file."""

    origin: int = option(0, "address of the sensor", name="from", least=0)
    to: int = option(0, "address of the chip", least=0)


@dataclass(frozen=True, slots=True, eq=False)
class AddressMap:
    """Where events go.

    sources : int64[n], rising, those that go anywhere; begins, counts : int64[n], of each in `targets`.
    """

    sources: I64
    begins: I64
    counts: I64
    targets: I64

    def takes(self, addresses: I64) -> Bools:
        """Return whether each address goes anywhere."""
        at = np.searchsorted(self.sources, addresses).clip(max=len(self.sources) - 1)
        known: Bools = self.sources[at] == addresses
        return known

    def sent_on(self, rows: I64) -> I64:
        """Return records (int64[m, 2]) at their new addresses, all of which go somewhere."""
        at = np.searchsorted(self.sources, rows[:, 1])
        counts = self.counts[at]
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        where = self.targets[np.repeat(self.begins[at], counts) + within]
        return np.column_stack((np.repeat(rows[:, 0], counts), where))


def read_map(path: str, takes: Takes) -> AddressMap:
    """Read a file; takes: whether the chip takes some addresses.

    Raises `DataError` for a file that is none, and for an address that the chip does not have.
    """
    found = read_rows(path, _Row)
    pairs = np.array([(row.origin, row.to) for _, row in found], dtype=np.int64)
    wrong = np.flatnonzero(~takes(pairs[:, 1]))
    if wrong.size:
        k = int(wrong[0])
        raise refusal(path, found[k][0], "to", str(pairs[k, 1]), "must be on the chip", "see its addresses")
    return address_map(pairs)


def address_map(pairs: I64) -> AddressMap:
    """Return the map of pairs of addresses, int64[m, 2]; raises `DataError` where there is none."""
    if not len(pairs):
        raise DataError("map: no pair, must have one at least; give one")
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    sources, begins, counts = np.unique(pairs[:, 0], return_index=True, return_counts=True)
    return AddressMap(sources, begins.astype(np.int64), counts.astype(np.int64), pairs[:, 1])
