"""What is written to the cells of a chip whose axons have been timed.

Of each cell the bench knows the delay as a line, `D = offset + own code` (`chips.wavefront.calibration`).
A cost c wants c units of delay, the mean over the cells, and its cell gets the code that comes nearest:

    code = (c unit - offset) / own        rounded, from 1 to 31

A cell that is left out gets 0, as if it were blocked: waves go round it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circuits.arrays import F64, I64, Bools
from circuits.blocks.wavefront.axon_delay import HIGHEST


@dataclass(frozen=True, slots=True, eq=False)
class CellCodes:
    """A chip's axons as they were timed.

    Attributes
    ----------
    current : float
        Nominal current of the axons' sinks at 27 degC, A.
    own : array
        Delay a unit of code of each cell, s, float64[cells].
    offset : array
        Its delay at a code of 0, s, float64[cells].
    off : array
        Which cells are left out, bool[cells].
    """

    current: float
    own: F64
    offset: F64
    off: Bools

    @property
    def unit(self) -> float:
        """Delay of a unit of cost, s: the mean over the cells, since a path is a matter of their ratios."""
        kept = self.own[~self.off]
        return float(kept.mean()) if kept.size else float(self.own.mean())

    def written(self, costs: NDArray[np.integer] | F64) -> I64:
        """Return the code of each cell for its cost, 0 for one that is blocked or left out.

        costs: from 0 to 31, [rows, columns] or [cells], all cells of the chip; the codes have their shape.
        """
        wanted = np.asarray(costs, dtype=np.float64).ravel()
        nearest = np.rint((wanted * self.unit - self.offset) / self.own)
        open_ = (wanted > 0.0) & ~self.off
        codes = np.where(open_, np.clip(nearest, 1, HIGHEST), 0).astype(np.int64)
        return codes.reshape(np.shape(costs))

    def delays(self, costs: NDArray[np.integer]) -> F64:
        """Return what the cells' delays for costs come to, s, float64 of their shape."""
        codes = self.written(costs).ravel()
        return np.asarray((self.offset + self.own * codes).reshape(np.shape(costs)))
