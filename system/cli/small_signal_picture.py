"""Pictures of small-signal transfers and of noise over frequency."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from circuits.solver.noise.analysis import Noise
from circuits.solver.small_signal import Response
from system.plot import COLOURS, INK, PALE

_LEAST = 1e-15  # V/V; below it a transfer is rounding and is not drawn
_BARS = 8


def draw_bode(runs: Sequence[tuple[str, Response]], nodes: Sequence[str], figure: Figure) -> None:
    """Fill `figure` with the magnitude and the phase of the transfer to each of the nodes over frequency.

    runs: label and response of each run, which is a line of its own.
    """
    figure.set_size_inches(7.0, 5.5)
    top, bottom = figure.subplots(2, 1, sharex=True)
    first = runs[0][1]
    present = [n for n in nodes if n in first.nodes]
    shown = [n for n in present if np.abs(first.transfer[:, first.nodes.index(n)]).max() > _LEAST]
    for k, node in enumerate(shown[: len(COLOURS)]):
        for j, (_, answer) in enumerate(runs):
            h = answer.transfer[:, answer.nodes.index(node)]
            seen = np.abs(h) > _LEAST
            look = {"color": COLOURS[k], "linewidth": 1.4 if len(runs) == 1 else 0.8}
            label = node if j == 0 else None
            x = answer.frequency[seen]
            top.semilogx(x, 20.0 * np.log10(np.abs(h[seen])), label=label, **look)
            bottom.semilogx(x, np.degrees(np.unwrap(np.angle(h[seen]))), **look)
    top.set_ylabel(f"magnitude (dB of 1 {first.unit})")
    bottom.set_ylabel("phase (degrees)")
    bottom.set_xlabel("frequency (Hz)")
    top.set_title(f"from {first.source}: {_said(runs)}")
    if shown:
        top.legend(loc="best")
    for ax in (top, bottom):
        ax.grid(color=PALE, linewidth=0.4)


def draw_noise(runs: Sequence[tuple[str, Noise]], figure: Figure) -> None:
    """Fill `figure` with noise densities over frequency, and the largest shares of the first run.

    runs: label and noise of each run.
    """
    figure.set_size_inches(7.0, 6.0)
    top, bottom = figure.subplots(2, 1, height_ratios=(3, 2))
    for j, (_, answer) in enumerate(runs):
        parts = (
            ("all", answer.output, INK),
            ("white", answer.white.sum(axis=1), COLOURS[0]),
            ("flicker", answer.flicker.sum(axis=1), COLOURS[1]),
        )
        for name, density, colour in parts:
            if density.max() > 0.0:
                label = name if j == 0 else None
                top.loglog(answer.frequency, 1e9 * np.sqrt(density), color=colour, linewidth=1.2, label=label)
    first = runs[0][1]
    top.set_xlabel("frequency (Hz)")
    top.set_ylabel("density (nV/√Hz)")
    top.set_title(f"noise at {first.node}: {_said(runs)}")
    if top.lines:
        top.legend(loc="best")
    top.grid(color=PALE, linewidth=0.4)
    largest = list(first.shares().items())[:_BARS]
    names = [n for n, _ in largest]
    scale = 100.0 / (first.variance or 1.0)
    white, flicker = ([scale * s[k] for _, s in largest] for k in (0, 1))
    bottom.barh(names, white, color=COLOURS[0])
    bottom.barh(names, flicker, left=white, color=COLOURS[1])
    bottom.invert_yaxis()
    bottom.set_xlabel(f"share of the variance (%), {1e6 * first.variance**0.5:.3g} µV rms in all")


def _said(runs: Sequence[tuple[str, object]]) -> str:
    return runs[0][0] if len(runs) == 1 else f"{len(runs)} runs, the first at {runs[0][0]}"
