"""A metric of draws as a formula, in the place of a block's metric with its gradient."""

from collections.abc import Callable
from typing import cast

import numpy as np

from circuits.arrays import F64
from circuits.silicon.die import Die
from system.study.search.slope import Slope, Slopes

LABELS = ("cell.m1.v_t0", "cell.m2.v_t0", "cell.m1.beta", "process.n.shared.v_t0")


class Planned:
    """Stands for `Slopes`: a formula, whose gradient is that of differences."""

    def __init__(self, formula: Callable[[F64], F64], labels: tuple[str, ...] = LABELS) -> None:
        self.formula, self.labels, self.metric, self.runs = formula, labels, "delay", 0
        self.sigma, self.die = np.full(len(labels), 0.01), Die(number=0)

    def at(self, z: F64) -> Slope:
        steps = 1e-5 * np.eye(len(z))
        by = (self.formula(z + steps) - self.formula(z - steps)) / 2e-5
        self.runs += 3
        return Slope(float(self.formula(z[None])[0]), by, "" if np.isfinite(by).all() else "it vanishes")

    def values(self, rows: F64) -> F64:
        self.runs += len(rows)
        return self.formula(rows)


def planned(formula: Callable[[F64], F64]) -> Slopes:
    return cast("Slopes", Planned(formula))
