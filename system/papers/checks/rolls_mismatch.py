"""Mismatch of ROLLS' neurons, filters and synapses, predicted from the areas of their transistors.

No figure of a paper. The spread of a quantity that follows from one deviation at a time is compared with that
of the circuits of four dies. Every row is the predicted CV of a quantity over the parts of one die, which is
the standard deviation of its logarithm. Its rule is ours: the CV of the same quantity over all neurons,
filters, columns or a thousand synapses of each of the dies A/1000 to A/1003, without what a die shares. Four
dies of 256 tell a CV to 2 % (standard error), the rate at 50 Hz bends by a tenth: within 15 %; correlations
within 0.1.

The published figure, 9.4 % for the neurons on the average, comes from a secondary source (attributed to Qiao
et al. 2015) that does not say of what. It stands beside the mean of the rates' CVs, which nothing was fitted
to, and that row has no rule: the CV falls from 19 to 4 % along the f-I curve, so that it depends on where one
looks. Default biases of the control software, the nominal chip's gate voltages, 27 degC.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chips.rolls.program.bias_file import default_biases
from chips.rolls.spread import RATES, Spread, correlation, parts_of, predicted, sampled
from circuits.arrays import F64
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import COLOURS, INK, PALE
from system.rule import unjudged, within, within_share
from system.statement import Statement

PUBLISHED = 0.094  # open-neuromorphic.org, attributed to Qiao et al. 2015
DIES = (1000, 1001, 1002, 1003)
TOLERANCE, CORRELATION_TOLERANCE = 0.15, 0.1
SHOWN = 5  # devices of a bar
LEAST = 0.03  # share of the variance that is told in the notes


@dataclass(frozen=True, slots=True)
class Found:
    """A quantity's prediction, and its logarithms on all dies, float64[n]."""

    part: str
    spread: Spread
    logs: F64

    @property
    def cv(self) -> float:
        """On the dies, over the parts of each: the mean of the dies is no mismatch."""
        return float(self.logs.std())


def run(progress: Progress) -> Report:
    """Predict and measure the spread of all parts on all dies."""
    return run_on(progress, DIES)


def run_on(progress: Progress, dies: tuple[int, ...]) -> Report:
    """Predict and measure the spread of all parts on some dies."""
    silicon = Silicon(ROLLS_180_IDEAL)
    found: list[Found] = []
    parts = parts_of(default_biases(), silicon)
    for part in with_progress(parts, progress):
        expected = predicted(part, ROLLS_180_IDEAL, silicon)
        logs: dict[str, list[F64]] = {name: [] for name in expected}
        for number in dies:
            for name, values in sampled(part, replace(silicon, die=Die(number=number))).items():
                own = np.log(values[values > 0.0])
                logs[name].append(own - own.mean())
        found += [Found(part.name, s, np.concatenate(logs[name])) for name, s in expected.items()]
    rows = [_row(f) for f in found] + _correlations(found) + [_beside(found)]
    return Report(tuple(rows), lambda figure: _draw(found, figure), _notes(found))


def _row(f: Found) -> Statement:
    rule = within_share(TOLERANCE, "{of:.4g} on the dies, within {percent:g} %", of=f.cv)
    return Statement(f"{f.spread.name.replace(' ', '_')}_cv", None, f.spread.cv, rule)


def _correlations(found: list[Found]) -> list[Statement]:
    rows = []
    by_name = {f.spread.name: f for f in found}
    pairs = [(f"{sign} time constant", f"{sign} gain") for sign in ("excitatory", "inhibitory")]
    for first, second in [("membrane time constant", "threshold current"), *pairs]:
        a, b = by_name[first], by_name[second]
        measured = float(np.corrcoef(a.logs, b.logs)[0, 1])
        rule = within(CORRELATION_TOLERANCE, "{of:.3g} on the dies, within {limit:g}", of=measured)
        name = f"correlation_{first}_and_{second}".replace(" ", "_")
        rows.append(Statement(name, None, correlation(a.spread, b.spread), rule))
    return rows


def _beside(found: list[Found]) -> Statement:
    """The published figure beside the mean CV of the rates; nothing is judged."""
    mean = float(np.mean([f.spread.cv for f in found if f.spread.name.startswith("rate")]))
    text = f"beside a secondary source; mean over {RATES[0]:g} to {RATES[-1]:g} Hz, no rule"
    return Statement("neuron_mismatch", PUBLISHED, mean, unjudged(text))


def _notes(found: list[Found]) -> tuple[str, ...]:
    lines = []
    for f in found:
        shares = [(d, s) for d, s in f.spread.by_device().items() if s >= LEAST]
        text = ", ".join(f"{device} {100 * share:.0f} %" for device, share in shares)
        lines.append(f"{f.spread.name}, variance by device: {text}.")
    return tuple(lines)


def _draw(found: list[Found], figure: Figure) -> None:
    """Bars of each quantity's CV, cut by device in shares of the variance; marks are the dies."""
    figure.set_size_inches(8.4, 6.0)
    shares, curve = figure.subplots(1, 2, width_ratios=(1.7, 1))
    for k, f in enumerate(found):
        _draw_bar(f, k, shares)
    shares.plot(
        [100 * f.cv for f in found], range(len(found)), color=INK, marker="|", markersize=11,
        markeredgewidth=2, linestyle="", label=f"dies A/{DIES[0]} to A/{DIES[-1]}",
    )  # fmt: skip
    shares.set_yticks(range(len(found)), [f.spread.name for f in found], fontsize=8)
    shares.invert_yaxis()
    shares.set_xlabel("CV (%), cut by each device's share of the variance")
    shares.legend(loc="lower right", fontsize=8)
    rates = [f for f in found if f.spread.name.startswith("rate")]
    curve.plot(RATES, [100 * f.spread.cv for f in rates], color=COLOURS[0], marker="o", label="predicted")
    curve.plot(
        RATES, [100 * f.cv for f in rates], color=INK, marker="|", markersize=11, linestyle="", label="dies"
    )
    curve.axhline(100 * PUBLISHED, color=COLOURS[1], linestyle="--", label="9.4 %, secondary source")
    curve.set_xscale("log")
    curve.set_xticks(RATES, [f"{r:g}" for r in RATES])
    curve.minorticks_off()
    curve.set(
        ylim=(0.0, None), xlabel="rate of the nominal neuron (Hz)", ylabel="CV of the rate at one current (%)"
    )
    curve.legend(fontsize=8)


def _draw_bar(f: Found, k: int, ax: Axes) -> None:
    left, cv = 0.0, 100.0 * f.spread.cv
    devices = list(f.spread.by_device().items())[:SHOWN]
    for j, (device, share) in enumerate(devices):
        ax.barh(k, cv * share, 0.7, left=left, color=COLOURS[j], edgecolor="white", linewidth=0.5)
        if cv * share > 1.3:
            ax.text(
                left + 0.5 * cv * share, k, device.rpartition(".")[2], ha="center", va="center", fontsize=6
            )
        left += cv * share
    ax.barh(k, max(cv - left, 0.0), 0.7, left=left, color=PALE, edgecolor="white", linewidth=0.5)


EXPERIMENT = Experiment("rolls-mismatch", "spread of ROLLS' neurons and synapses, and what makes it", run)
