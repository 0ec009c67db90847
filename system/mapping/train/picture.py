"""How a training went, drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.mapping.train.train import Trained

MEANS = 30  # parts of the steps, whose means are drawn


def draw_training(trained: Trained[Any], figure: Figure) -> None:
    """Fill `figure` with the loss and the share that is wrong, beside their means over parts of the steps."""
    upper, lower = figure.subplots(2, 1, sharex=True)
    for axes, values in ((upper, trained.losses), (lower, 100.0 * (1.0 - trained.right))):
        axes.plot(values, color="0.8", linewidth=0.8)
        axes.plot(*_means(values))
    upper.set_ylabel("loss")
    lower.set(xlabel="step", ylabel="wrong, % of a step's samples")


def _means(values: F64) -> tuple[F64, F64]:
    parts = np.array_split(np.arange(values.size), min(MEANS, values.size))
    return np.array([p.mean() for p in parts]), np.array([values[p].mean() for p in parts])
