"""Pictures of small-signal transfers and of noise over frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from circuits.solver.noise.analysis import Noise
from circuits.solver.small_signal import Response
from system.plot import COLOURS, INK, PALE, entitle, looks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEAST = 1e-15  # V/V; below it a transfer is rounding and is not drawn
_BARS = 8
_SMALLEST = 0.05  # %, of a share that has a bar


def draw_bode(runs: Sequence[tuple[str, Response]], nodes: Sequence[str], figure: Figure) -> None:
    """Fill `figure` with the magnitude and the phase of the transfer to each of the nodes over frequency.

    runs: label and response of each run, which is a line of its own.
    """
    figure.set_size_inches(7.0, 5.5)
    top, bottom = figure.subplots(2, 1, sharex=True)
    first = runs[0][1]
    present = [n for n in nodes if n in first.nodes]
    shown = [n for n in present if np.abs(first.transfer[:, first.nodes.index(n)]).max() > _LEAST]
    each = looks(len(runs))
    for k, node in enumerate(shown[: len(COLOURS)]):
        for j, (run, answer) in enumerate(runs):
            h = answer.transfer[:, answer.nodes.index(node)]
            seen = np.abs(h) > _LEAST
            look = each[j] if len(shown) == 1 else {"color": COLOURS[k], "linestyle": each[j]["linestyle"]}
            label = run if len(shown) == 1 else f"{node}, {run}" if len(runs) > 1 else node
            if len(runs) > len(COLOURS):
                label = "" if j else f"{node}: {len(runs)} runs"
            x = answer.frequency[seen]
            top.semilogx(x, 20.0 * np.log10(np.abs(h[seen])), label=label, **look)
            bottom.semilogx(x, np.degrees(np.unwrap(np.angle(h[seen]))), **look)
    top.set_ylabel(f"magnitude (dB of 1 {first.unit})")
    bottom.set_ylabel("phase (degrees)")
    bottom.set_xlabel("frequency (Hz)")
    to = f" to {shown[0]}" if len(shown) == 1 else ""
    entitle(f"from {first.source}{to}: {_said(runs)}", top)
    if shown:
        top.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)
    for ax in (top, bottom):
        ax.grid(color=PALE, linewidth=0.4)


def draw_noise(runs: Sequence[tuple[str, Noise]], figure: Figure) -> None:
    """Fill `figure` with noise densities over frequency, and the largest shares of the first run.

    runs: label and noise of each run.
    """
    figure.set_size_inches(8.0, 6.0)
    top, bottom = figure.subplots(2, 1, height_ratios=(3, 2))
    each = looks(len(runs))
    for j, (label, answer) in enumerate(runs):
        parts = (
            ("white", answer.white.sum(axis=1), "--"),
            ("flicker", answer.flicker.sum(axis=1), ":"),
            ("all", answer.output, "-"),
        )
        for name, density, dashes in parts:
            if density.max() > 0.0:
                said = label if name == "all" and len(runs) <= len(COLOURS) else None
                y = 1e9 * np.sqrt(density)
                colour = each[j]["color"]
                top.loglog(answer.frequency, y, color=colour, linestyle=dashes, linewidth=1.2, label=said)
    first = runs[0][1]
    top.set_xlabel("frequency (Hz)")
    top.set_ylabel("density (nV/√Hz)")
    entitle(f"noise at {first.node}: {_said(runs)}", top)
    for name, dashes in (("all", "-"), ("white", "--"), ("flicker", ":")):
        top.plot([], [], color=INK, linestyle=dashes, label=name)
    top.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)
    top.grid(color=PALE, linewidth=0.4)
    _draw_shares(first, bottom)
    if len(runs) > 1:
        entitle(f"largest shares at {runs[0][0]}", bottom)


def _draw_shares(noise: Noise, ax: Axes) -> None:
    """Bars of the largest shares of a noise's variance, of white noise and of flicker."""
    scale = 100.0 / (noise.variance or 1.0)
    largest = [(n, s) for n, s in list(noise.shares().items())[:_BARS] if scale * sum(s) >= _SMALLEST]
    names = [n for n, _ in largest]
    white, flicker = ([scale * s[k] for _, s in largest] for k in (0, 1))
    ax.barh(names, white, color=COLOURS[0], label="white")
    ax.barh(names, flicker, left=white, color=COLOURS[4], hatch="//", label="flicker")
    ax.invert_yaxis()
    ax.set_xlim(left=0.0)
    ax.set_xlabel(f"share of the variance (%), {1e6 * noise.variance**0.5:.3g} µV rms in all")
    if names:
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)


def _said(runs: Sequence[tuple[str, object]]) -> str:
    return runs[0][0] if len(runs) == 1 else f"{len(runs)} runs"
