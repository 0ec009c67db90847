"""How a training went, drawn."""

from __future__ import annotations

from matplotlib.figure import Figure

from system.mapping.train.train import Trained


def draw_training(trained: Trained, figure: Figure) -> None:
    """Fill `figure` with the loss and the share of samples that is wrong, over the steps."""
    upper, lower = figure.subplots(2, 1, sharex=True)
    upper.semilogy(trained.losses.clip(1e-6))
    upper.set_ylabel("loss")
    lower.plot(100.0 * (1.0 - trained.right))
    lower.set(xlabel="step", ylabel="wrong, % of a step's samples")
