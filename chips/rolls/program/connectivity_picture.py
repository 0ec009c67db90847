"""Picture of a network's weight levels, as Figure 5 of Milde et al. 2017.

A column is a sending neuron, a row the neuron it reaches; red excites, blue inhibits, darker is a higher
level (not always more current: that is up to the biases). Synapses within a population are framed in black
on the diagonal, populations are named at the right and at the bottom.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Rectangle

from chips.rolls.program.network import Network
from chips.rolls.program.population import Population
from chips.rolls.program.program import HIGHEST_LEVEL

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHADES = (0.35, 0.55, 0.75, 1.0)  # of levels 1 to 4
_SMALLEST_LABEL = 0.035  # of the axes: below that a name has no room
_RULE = "#999999"


def draw_connectivity(network: Network, ax: Axes) -> None:
    """Fill `ax` with the levels between all neurons from 0 to the network's last, and a bar of levels."""
    size = 1 + max(max(p.neurons) for p in network.populations)
    levels = network.levels()[:size, :size]
    numbers = np.arange(-HIGHEST_LEVEL, HIGHEST_LEVEL + 1)
    norm = BoundaryNorm(np.append(numbers, HIGHEST_LEVEL + 1) - 0.5, len(numbers))
    image = ax.imshow(levels, cmap=_palette(), norm=norm, interpolation="nearest")
    for population in network.populations:
        _frame(population, ax)
    _name_axes(network.populations, size, ax)
    ax.set(xlabel="from", ylabel="to neuron", xlim=(-0.5, size - 0.5), ylim=(size - 0.5, -0.5))
    ax.tick_params(length=0)
    bar = ax.figure.colorbar(image, ax=ax, shrink=0.6, pad=0.14, label="level")
    bar.set_ticks(numbers.tolist(), labels=[f"{n:+d}" if n else "none" for n in numbers.tolist()])
    bar.minorticks_off()


def _palette() -> ListedColormap:
    blues, reds = colormaps["Blues"], colormaps["Reds"]
    shades = [blues(s) for s in reversed(_SHADES)] + [(1.0, 1.0, 1.0, 1.0)] + [reds(s) for s in _SHADES]
    return ListedColormap(shades)


def _spans(population: Population) -> list[tuple[int, int]]:
    """First and last neuron of each run of neighbouring neurons."""
    neurons = np.sort(np.array(population.neurons, dtype=np.int64))
    runs = np.split(neurons, np.flatnonzero(np.diff(neurons) > 1) + 1)
    return [(int(run[0]), int(run[-1])) for run in runs]


def _frame(population: Population, ax: Axes) -> None:
    """Black frames on the diagonal, and thin lines where the population begins and ends."""
    for first, last in _spans(population):
        corner, width = (first - 0.5, first - 0.5), last - first + 1
        ax.add_patch(Rectangle(corner, width, width, fill=False, edgecolor="black", linewidth=1.0, zorder=3))
        for edge in (first - 0.5, last + 0.5):
            ax.axhline(edge, linewidth=0.4, zorder=2, color=_RULE)
            ax.axvline(edge, linewidth=0.4, zorder=2, color=_RULE)


def _name_axes(populations: tuple[Population, ...], size: int, ax: Axes) -> None:
    """Neuron numbers at the left; names at the right and the bottom, at the middle of each population."""
    edges = sorted({first for p in populations for first, _ in _spans(p)} | {size - 1})
    ax.set_yticks(edges, labels=[str(edge) for edge in edges], fontsize=7)
    named = [(p, float(np.mean(p.neurons))) for p in populations if len(p) >= _SMALLEST_LABEL * size]
    ax.set_xticks([at for _, at in named], labels=[p.name for p, _ in named], rotation=90, fontsize=8)
    for population, at in named:
        ax.annotate(
            population.name,
            (1.0, at),
            (4, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            va="center",
            fontsize=8,
            annotation_clip=False,
        )
