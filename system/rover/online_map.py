"""A map that is learnt on the way: axon delays that follow sensed costs (Hwu et al. 2018, equation (5)).

    D(t + 1) = D(t) + delta (map - D(t))

Delays stay real-valued; a planner gets them rounded, as codes are written, and at least 1. Blocked cells are
known from the start: nothing can be sensed under a rover where none can be.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from chips.wavefront.spiking_wavefront import learn, round_delays
from circuits.arrays import F64, I64
from circuits.errors import ParameterError


@dataclass(slots=True)
class OnlineMap:
    """A map that is learnt: delays of the cells, how often each was updated, and the rate.

    delays : float64[rows, columns], in units of cost; updates : int64[rows, columns]; rate : of equation (5).
    """

    delays: F64
    rate: float
    updates: I64 = field(init=False)

    def __post_init__(self) -> None:
        if not 0.0 < self.rate <= 1.0:
            raise ParameterError(f"learn: {self.rate:g}, must be above 0 and at most 1; 1 learns at once")
        self.updates = np.zeros(self.delays.shape, dtype=np.int64)

    def learn(self, cell: tuple[int, int], cost: float) -> None:
        """Move the delay of `cell` towards a sensed cost; a blocked cell stays blocked."""
        if self.delays[cell] > 0.0:
            self.delays[cell] = learn(self.delays[cell], np.array(cost), self.rate)
            self.updates[cell] += 1

    def codes(self) -> I64:
        """Delays as they are written, int64[rows, columns]: rounded, at least 1, 0 where blocked."""
        return round_delays(self.delays)

    def error(self, costs: I64) -> float:
        """Mean absolute difference from `costs` over the cells that were ever updated; NaN where none was."""
        seen = self.updates > 0
        return float(np.abs(self.delays - costs)[seen].mean()) if seen.any() else float("nan")


def unknown_map(costs: I64, prior: float, rate: float) -> OnlineMap:
    """A map of which only the blocked cells are known; every other delay is `prior`.

    Raises `ParameterError` unless the rate is above 0 and at most 1, and the prior at least 1.
    """
    if not prior >= 1.0:
        raise ParameterError(f"prior: {prior:g}, must be >= 1; the paper's is 5")
    return OnlineMap(np.where(costs > 0, prior, 0.0), rate)
