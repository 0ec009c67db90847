"""Equations (9) and (10) of Wen & Horiuchi 2022 by transistors, by the chip's model, and in closed form.

The transistors of the chip's cells and the chip's model answer drawn inputs, and their latencies are compared
with the closed forms of the paper. The die is nominal, at 27 degC. Inputs are drawn (seed 1000) where the
equations hold: for (9) every input comes before the spike, and the spike less than 20 ms after the first; for
(10) charge, inhibitions of a few memories and the net current leave a spike. The rule is that each is within
2 % of the closed form. The circuits are the chip's own in their places: an integrating neuron of 8 synapses,
a first-layer cell of 2 excitations and 7 inhibitions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.latency.chip import LatencyChip
from chips.latency.errors import cell_latencies, input_latencies
from chips.latency.law import evaluation_latency, race_latency
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report, with_progress
from system.openspace.law import ARCS, Bat, arcs_of
from system.plot import COLOURS, INK
from system.rule import at_most
from system.spiking_bat.chip_brain import design_of
from system.spiking_bat.numbers import Numbers
from system.statement import Statement

CASES = 24  # of each equation; ours
TOLERANCE = 0.02
SEED = 1000


@dataclass(frozen=True, slots=True)
class Case:
    """Latencies of one set of inputs, s: closed form, chip's model, transistors."""

    law: float
    model: float
    circuit: float


def reproduce(progress: Progress, cases: int = CASES) -> Report:
    """Compare both equations with the model and the transistors."""
    chip = LatencyChip(design_of(arcs_of(Bat(ping_rate=10.0)), Numbers()), silicon=Silicon(AMI_1500_IDEAL))
    random = np.random.default_rng(SEED)
    found: dict[str, list[Case]] = {"9": [], "10": []}
    makers: tuple[tuple[str, Callable[[LatencyChip, np.random.Generator], Case]], ...] = (
        ("9", evaluation_case), ("10", race_case),
    )  # fmt: skip
    for name, make in with_progress([maker for maker in makers for _ in range(cases)], progress):
        found[name].append(make(chip, random))
    return Report(rows(found), lambda figure: _draw(found, figure))


def evaluation_case(chip: LatencyChip, random: np.random.Generator) -> Case:
    """Draw one to four inputs of a neuron, all before its spike, less than 20 ms after the first."""
    d = chip.design
    while True:
        times = np.sort(random.uniform(1e-3, 15e-3, random.integers(1, 5)))
        law = evaluation_latency(list(times), 1.0 / d.integration)
        if times[-1] < law - 0.2e-3 and law - times[0] < d.step:
            break
    return Case(law, *input_latencies(chip, int(random.integers(ARCS)), times))


def race_case(chip: LatencyChip, random: np.random.Generator) -> Case:
    """Draw a cell with the goal's charge near it, or none, and inhibitions of up to three memories."""
    d = chip.design
    while True:
        p, away = int(random.integers(ARCS)), int(random.integers(-1, 4))
        goal = None if away < 0 or p + away >= ARCS else p + away
        memories = {
            int(q): float(random.uniform(8e-3, 40e-3))
            for q in random.choice(
                np.arange(max(p - 3, 0), min(p + 4, ARCS)), random.integers(0, 4), replace=False
            )
        }
        weight = {q: d.suppression / d.race * np.exp(-0.5 * (q - p) ** 2) for q in memories}
        charge = 0.0 if goal is None else d.goal * np.exp(-((goal - p) ** 2) / d.goal_sigma**2)
        passive = d.share[p] / d.race
        law = race_latency(passive, float(charge), [(t, float(weight[q])) for q, t in memories.items()])
        if max([0.0, *memories.values()]) < law < d.inhibition:
            break
    return Case(law, *cell_latencies(chip, p, goal, memories))


def rows(found: dict[str, list[Case]]) -> tuple[Statement, ...]:
    """Make a statement about the largest deviation of the model and of the transistors from each equation."""
    made = []
    rule = at_most(TOLERANCE, "at most {percent:g} % of the closed form")
    for name, cases in found.items():
        for what in ("model", "circuit"):
            worst = max(abs(getattr(c, what) / c.law - 1.0) for c in cases)
            made.append(Statement(f"equation_{name}_{what}_error", TOLERANCE, worst, rule))
    return tuple(made)


def _draw(found: dict[str, list[Case]], figure: Figure) -> None:
    figure.set_size_inches(9.0, 4.2)
    for (name, cases), ax in zip(found.items(), figure.subplots(1, 2), strict=True):
        law = 1e3 * np.array([c.law for c in cases])
        for what, colour, mark in (("circuit", COLOURS[1], "o"), ("model", COLOURS[0], "+")):
            off = [100.0 * (getattr(c, what) / c.law - 1.0) for c in cases]
            ax.plot(law, off, marker=mark, color=colour, linestyle="", label=what)
        ax.axhline(0.0, color=INK, linewidth=0.6)
        ax.set(xlabel=f"latency of equation ({name}) (ms)", ylabel="deviation (%)")
        ax.legend(fontsize=8)


EXPERIMENT = Experiment(
    "latency-equations", "(9) and (10): transistors, chip's model, closed form", reproduce
)
