"""Twenty dies of the rebound neuron in ngspice: the same class and the same edges as in the solver.

No paper has it. Compared are dies A/1000 to A/1019 with local mismatch alone and the neuron's usual biases,
those that do not work included. Both engines answer the same search (`circuits.blocks.sonar.tuning`): silent
at rest, after a call and after an echo alone; then the facilitating interval, scanned and its edges bisected
to 10 us. Both have the same equations. ngspice's edges are converged where a run at a tenth of its reltol and
a quarter of its largest step still fires 10 us within them and not 10 us outside. No value is fitted, and the
paper has none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.tuning import RESOLUTION, NeuronClass, Tuning, search, tune, tuning_machine
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from netlists.ngspice.tuning import LARGEST_STEP, RELTOL, NgspiceTrials, edges_hold
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, PALE, sized_axes
from system.rule import Rule, all_of, within
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

DIE = "die"
FIRST_DIE, DIES = 1000, 20
EDGE = 20e-6  # s, allowed between the engines: twice the resolution of the bisection


@dataclass(frozen=True, slots=True)
class Answer:
    """What an engine says of a die: its class, and the edges of the facilitating interval, float64[2], s.

    Edges are NaN where the neuron does not work.
    """

    outcome: NeuronClass
    edges: F64


@dataclass(frozen=True, slots=True)
class Beside:
    """One die in both engines; `converged`: whether ngspice's edges hold when tightened (True without)."""

    die: int
    solver: Answer
    ngspice: Answer
    runs: int
    converged: bool

    @property
    def same_class(self) -> bool:
        """Whether both engines give the neuron one class."""
        return self.solver.outcome is self.ngspice.outcome

    @property
    def apart(self) -> float | None:
        """Larger distance of the two edges, s; None unless the neuron works in both."""
        if not (self.same_class and self.solver.outcome is NeuronClass.WORKS):
            return None
        return float(np.abs(self.solver.edges - self.ngspice.edges).max())


def run(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
    """Tune every die in both engines."""
    keys = [Numbered(DIE, FIRST_DIE + k) for k in range(dies)]
    numbers = (version("noctule"), RELTOL, LARGEST_STEP, RESOLUTION)
    campaign = Campaign(EXPERIMENT.name, beside, Numbered, Beside, numbers)
    found = execution.by_condition(campaign, keys, progress)[DIE]
    rows = tuple(row for one in found for row in _rows(one))
    return Report((*rows, *_summary(found)), lambda figure: draw(found, figure), (_note(found),))


def beside(key: Numbered) -> Beside:
    """Tune the die of a number in both engines."""
    neuron, silicon = rebound_neuron.build(), silicon_of(key.number)
    solver = tune(tuning_machine(neuron, silicon))
    trials = NgspiceTrials(neuron, silicon)
    peer = search(trials)
    tight = NgspiceTrials(neuron, silicon, 0.1 * RELTOL, 0.25 * LARGEST_STEP)
    converged = peer.outcome is not NeuronClass.WORKS or edges_hold(tight, peer, RESOLUTION)
    return Beside(key.number, answer_of(solver), answer_of(peer), trials.runs + tight.runs, converged)


def answer_of(tuning: Tuning) -> Answer:
    """Keep the class and the edges."""
    return Answer(tuning.outcome, np.array([tuning.first, tuning.last]))


def silicon_of(number: int) -> Silicon:
    """Give die `number` of lot A at 27 degC, with local mismatch alone."""
    return Silicon(AMI_1500_IDEAL, die=Die(number=number, process=False))


def _rows(one: Beside) -> list[Statement]:
    """Class of a die; and where it works the worse of its edges."""
    name, peer = f"die_{one.die}", one.ngspice.outcome.value
    same = Rule(f"the class in ngspice, {peer}", None, lambda ours, _: ours == peer)
    same = same.unless(one.solver.outcome is NeuronClass.FAILED, "a run that failed has none")
    rows = [Statement(f"{name}_class", None, one.solver.outcome.value, same)]
    if one.apart is not None:
        known = f"of ngspice, which is converged to {1e6 * RESOLUTION:g}"
        near = within(EDGE, f"worse edge within {{micro:g}} us {known}", of=0.0)
        near = near.unless(not one.converged, "it is not converged")
        rows.append(Statement(f"{name}_edge_s", None, one.apart, near))
    return rows


def _summary(found: Sequence[Beside]) -> list[Statement]:
    """How many dies have one class, and the worst edge of all."""
    same = sum(one.same_class for one in found)
    worst = max((one.apart for one in found if one.apart is not None), default=None)
    return [
        Statement("dies_of_the_same_class", None, float(same), all_of(len(found), "all {limit:g}")),
        Statement("worst_edge_s", None, worst, within(EDGE, "within {micro:g} us", of=0.0)),
    ]


def _note(found: Sequence[Beside]) -> str:
    classes = Counter(one.solver.outcome.value for one in found)
    told = ", ".join(f"{count} {name}" for name, count in classes.most_common())
    return (
        f"Solver: {told}. ngspice: trapezoidal, reltol {RELTOL:g}, steps to {1e6 * LARGEST_STEP:g} us,"
        f" {sum(one.runs for one in found)} runs."
    )


def draw(found: Sequence[Beside], figure: Figure) -> None:
    """Fill `figure` with the facilitating interval of every die in both engines."""
    axes = sized_axes(figure, 7.0, 4.0)
    for tunings, colour, width, label in (
        ([one.ngspice for one in found], PALE, 7.0, "ngspice"),
        ([one.solver for one in found], COLOURS[0], 2.0, "solver"),
    ):
        edges = [1e3 * t.edges for t in tunings]
        dies = [one.die for one in found]
        axes.vlines(dies, *zip(*edges, strict=True), color=colour, linewidth=width, label=label)
    for one in found:
        if one.solver.outcome is not NeuronClass.WORKS:
            axes.annotate(one.solver.outcome.value, (one.die, 0.02), xycoords=("data", "axes fraction"),
                          rotation=90, ha="center", fontsize=7)  # fmt: skip
    axes.set(xlabel="die", xticks=[one.die for one in found][::2], ylabel="facilitating delays (ms)")
    axes.legend(loc="upper right")


EXPERIMENT = Experiment(
    "ngspice-dies", "20 dies of the rebound neuron, class and edges in the solver and in ngspice",
    run, {"dies": DIES},
)  # fmt: skip
