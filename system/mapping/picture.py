"""Pictures of a mapped network: where it stands with its weights, and a run of it."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from chips.rolls.program.address import NEURONS
from chips.rolls.program.connectivity_picture import draw_connectivity
from chips.rolls.program.network import Network as Wiring
from chips.rolls.program.population import Population, Projection
from circuits.arrays import F64
from system.mapping.dynamics import Trains
from system.mapping.network import spans
from system.mapping.rolls.mapped import Mapped
from system.mapping.run import MappedRun
from system.plot import COLOURS, INK, PALE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BIN = 20e-3  # s, of the rates in a picture; ours
_ROOM = 1.4  # of the axes of rates, for a legend
_NAMES = {"asked": "asked for", "expected": "as mapped", "chip": "on the die"}
_LOOKS = {"asked": (PALE, "-"), "expected": (INK, "--"), "chip": (COLOURS[0], "-")}


def draw_program(mapped: Mapped, figure: Figure) -> None:
    """Fill `figure` with levels between neurons, the weight of each, and the chip's neurons in a row."""
    figure.set_size_inches(10.0, 6.4)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.set(rect=(0.04, 0.0, 0.96, 1.0))  # type: ignore[call-arg]
    axes = figure.subplot_mosaic(
        [["levels", "weights"], ["row", "row"]], width_ratios=(3, 1), height_ratios=(12, 1)
    )
    draw_connectivity(wiring_of(mapped), axes["levels"])
    _draw_weights(mapped, axes["weights"])
    _draw_row(mapped, axes["row"])


def _draw_row(mapped: Mapped, ax: Axes) -> None:
    """The chip's 256 neurons: populations one after the other, and what is free."""
    at = spans(mapped.network.populations)
    for k, p in enumerate(mapped.placed):
        ax.barh(0, len(at[p.name]), 1.0, p.first, color=COLOURS[k % len(COLOURS)], edgecolor="white")
        ax.text(
            p.first + 0.5 * len(at[p.name]), 0, p.name, ha="center", va="center", fontsize=8, color="white"
        )
    used = mapped.network.neurons
    ax.barh(0, NEURONS - used, 1.0, used, color="white", edgecolor=PALE)
    ax.text(
        0.5 * (NEURONS + used),
        0,
        f"{NEURONS - used} free",
        ha="center",
        va="center",
        fontsize=8,
        clip_on=True,
    )
    ax.set(xlim=(0, NEURONS), ylim=(-0.5, 0.5), yticks=[], xlabel="neuron of the chip")


def wiring_of(mapped: Mapped) -> Wiring:
    """Return populations and levels on the chip."""
    at, levels = spans(mapped.network.populations), mapped.program.levels
    groups = [Population(p.name, tuple(range(p.first, p.first + len(at[p.name])))) for p in mapped.placed]
    projections = [Projection(a, b, levels[np.ix_(b.neurons, a.neurons)]) for a, b in product(groups, groups)]
    return Wiring(tuple(groups), tuple(p for p in projections if p.levels.any()))


def _draw_weights(mapped: Mapped, ax: Axes) -> None:
    """Weights of the levels that synapses have, and of an event of a virtual one, in nA a synapse's jump."""
    labels, values, colours = [], [], []
    for one in mapped.filters:
        sign = -1 if "inhibitory" in one.name else 1
        virtual = one.name.startswith("virtual")
        levels = {k: int((mapped.program.levels == sign * k).sum()) for k in (1, 2, 3, 4)}
        counts = {0: 1} if virtual else levels
        for level, count in counts.items():
            if count:
                labels.append(
                    ("inputs" if sign > 0 else "inputs that\ninhibit")
                    if virtual
                    else f"level {sign * level:+d}\n{count} synapses"
                )
                values.append(sign * one.weights[max(level - 1, 0)])
                colours.append(COLOURS[0 if sign < 0 else 1])
    unit = 1e12 * np.array(values)
    ax.barh(np.arange(len(values)), unit, 0.6, color=colours)
    ax.axvline(0.0, color=INK, linewidth=0.8)
    ax.set_yticks(np.arange(len(values)), labels, fontsize=8)
    ax.invert_yaxis()
    ax.set_xlabel("jump of the current\nat an event (pA)")


def draw_mapped_run(mapped: Mapped, run: MappedRun, title: str, figure: Figure) -> None:
    """Fill `figure` with the die's spikes, and the mean rate of each population in all three runs."""
    at = spans(mapped.network.populations)
    figure.set_size_inches(8.0, 2.6 + 1.5 * len(at))
    axes = figure.subplots(1 + len(at), 1, sharex=True, height_ratios=(2, *(1 for _ in at)))
    _draw_raster(run.chip, at, axes[0])
    for ax, (name, members) in zip(axes[1:], at.items(), strict=True):
        for key, (colour, dashes) in _LOOKS.items():
            trains = getattr(run, key)
            edges, rate = _rate(trains, members, run.duration)
            ax.stairs(rate, edges, color=colour, linestyle=dashes, label=_NAMES[key])
        ax.set_ylabel(f"{name}\n(Hz)")
    axes[1].set_ylim(0.0, _ROOM * axes[1].get_ylim()[1])
    axes[1].legend(loc="upper right", ncols=3, fontsize=8)
    axes[-1].set_xlabel("time (s)")
    figure.suptitle(title, fontsize=10)


def _draw_raster(trains: Trains, at: dict[str, range], ax: Axes) -> None:
    ax.plot(trains.times, trains.neurons, color=INK, marker=".", markersize=1.5, linestyle="")
    middles = [0.5 * (members.start + members.stop - 1) for members in at.values()]
    ax.set_yticks(middles, list(at))
    for members in at.values():
        ax.axhline(members.start - 0.5, color=PALE, linewidth=0.6)
    ax.set_ylim(max(m.stop for m in at.values()) - 0.5, -0.5)


def _rate(trains: Trains, members: range, duration: float) -> tuple[F64, F64]:
    edges = np.arange(0.0, duration + 0.5 * BIN, BIN)
    mine = (trains.neurons >= members.start) & (trains.neurons < members.stop)
    return edges, np.histogram(trains.times[mine], edges)[0] / (BIN * len(members))
