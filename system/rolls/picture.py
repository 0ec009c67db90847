"""Picture of a ROLLS die: f-I curves, time constants, weights, refractory periods."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from chips.rolls.portrait import Portrait
from circuits.arrays import F64
from system.plot import COLOURS, INK, PALE, silicon_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BINS = 24
_NAMES = {
    "excitatory": "exc. filter",
    "inhibitory": "inh. filter",
    "virtual_excitatory": "virtual exc.",
    "virtual_inhibitory": "virtual inh.",
}


def draw_portrait(p: Portrait, figure: Figure) -> None:
    """Fill `figure` with four panels."""
    figure.set_size_inches(8.4, 6.2)
    (curves, constants), (table, periods) = figure.subplots(2, 2)
    draw_curves(p.currents, p.rates, p.nominal_rates, curves)
    _draw_constants(p, constants)
    _draw_weights(p, table)
    _draw_periods(p, periods)
    at = silicon_text(p.silicon.die, p.silicon.temperature_c, p.kind, law=p.silicon.process.effects)
    figure.suptitle(f"ROLLS, {at}", fontsize=10)


def draw_curves(currents: F64, rates: F64, nominal: F64, ax: Axes) -> None:
    """Rates (Hz, [k, n]) over the current (A, [k]): every neuron, their mean, and the nominal neuron."""
    ax.plot(1e9 * currents, rates, color=PALE, linewidth=0.4)
    ax.plot([], [], color=PALE, label=f"{rates.shape[1]} neurons")
    ax.plot(1e9 * currents, rates.mean(axis=1), color=COLOURS[0], linewidth=1.8, label="their mean")
    ax.plot(1e9 * currents, nominal, color=INK, linestyle="--", linewidth=1.2, label="nominal neuron")
    ax.set_xscale("log")
    ax.set_xlabel("I_dc of the nominal device (nA)")
    ax.set_ylabel("rate (Hz)")
    ax.legend(loc="upper left", fontsize=8)


def _draw_constants(p: Portrait, ax: Axes) -> None:
    """Spread of each time constant as a box from the first to the last quartile, whiskers to the ends."""
    values = {"membrane": p.tau} | {_NAMES[name]: tau for name, tau in p.filters.items()}
    labels = [f"{name}\n{1e3 * tau.mean():.3g} ms, {_cv(tau):.1%}" for name, tau in values.items()]
    boxes = ax.boxplot(
        [1e3 * tau for tau in values.values()], orientation="horizontal", whis=(0, 100), widths=0.55,
        patch_artist=True,
    )  # fmt: skip
    for box in boxes["boxes"]:
        box.set(facecolor=COLOURS[5], edgecolor=INK)
    for line in boxes["medians"]:
        line.set_color(COLOURS[1])
    ax.set_yticks(range(1, len(labels) + 1), labels, fontsize=7)
    ax.invert_yaxis()
    ax.set_xlabel("time constant (ms); mean and CV beside")


def _draw_weights(p: Portrait, ax: Axes) -> None:
    """Current of each level, nominal and on the die; bars show the CV of an event's charge."""
    levels = [str(w.level) for w in p.weights]
    place = np.arange(len(levels))
    mean = np.array([1e9 * w.current for w in p.weights])
    spread = mean * np.array([w.charge_cv for w in p.weights])
    colours = [COLOURS[0] if w.level > 0 else COLOURS[1] for w in p.weights]
    ax.bar(place, mean, 0.6, color=colours, yerr=spread, ecolor=INK, capsize=2.0)
    nominal = [1e9 * w.nominal for w in p.weights]
    ax.plot(place, nominal, color=INK, marker="_", markersize=14, linestyle="", label="sum of the codes")
    ax.set_yscale("log")
    ax.set_xticks(place, levels)
    ax.set_xlabel("level (bars: CV of an event's charge)")
    ax.set_ylabel("weight current (nA)")
    ax.legend(loc="upper right" if mean[0] > mean[-1] else "upper left", fontsize=8)


def _draw_periods(p: Portrait, ax: Axes) -> None:
    ax.hist(1e6 * p.refractory, bins=_BINS, color=COLOURS[2], label="refractory period")
    ax.set_xlabel(f"refractory period (µs): {1e6 * p.refractory.mean():.4g}, CV {_cv(p.refractory):.1%}")
    ax.set_ylabel("neurons")


def _cv(values: F64) -> float:
    return float(values.std() / values.mean())
