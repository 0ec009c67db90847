"""Success against temperature, with the biases set at 27 degC: what the drift that the paper fears does.

No figure of the paper, which names "parameter drift" with temperature as the main limitation. The robot
drives towards a blue block at speed and turn factor 0.5, and how often it avoids it is compared between
temperatures and between both kinds of bias: fixed gate voltages, and ideal currents, which are
proportional to absolute temperature. Rules (ours): with ideal currents the robot avoids the block in
at least 90 % of the runs from 17 to 37 degC; with gate voltages it does so in fewer at one of the ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from circuits.circuit import BiasKind
from system.experiment import Experiment, Progress, Report
from system.papers.milde2017.avoided import report_avoided
from system.papers.milde2017.null import ROBOTS
from system.plot import COLOURS, draw_estimates, sized_axes
from system.pushbot.campaign import Drive, Runs, drive_repeats
from system.pushbot.scenario import Scenario
from system.rule import Measured, at_least, below
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.share import Share

KINDS: tuple[BiasKind, ...] = ("ideal", "gate")
TEMPERATURES = (7.0, 17.0, 27.0, 37.0, 47.0)  # degC
RUNS, DIES = 10, 5
ENDS = (17.0, 37.0)
ENOUGH = 0.9

Found = Mapping[tuple[BiasKind, float], Share]


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = RUNS, dies: int = DIES,
    temperatures: Sequence[float] = TEMPERATURES,
) -> Report:  # fmt: skip
    """Drive at all temperatures with both kinds of bias."""
    cells = {
        (kind, t): Drive(Scenario(bias_kind=kind, law="ideal", temperature_c=t, silicon_noise="off"))
        for kind in KINDS
        for t in temperatures
    }
    driven = drive_repeats(execution, EXPERIMENT.name, cells, Runs(count, dies), Runs(RUNS, DIES), progress)
    return report_avoided(driven, ROBOTS, rows, _draw, lambda cell: f"{cell[0]}, {cell[1]:g} degC")


def rows(found: Found) -> tuple[Statement, ...]:
    """Make the statements about both kinds of bias at the ends of the range."""
    ideal = [found["ideal", t] for t in ENDS]
    gate = [found["gate", t] for t in ENDS]
    worst = min(ideal, key=lambda s: s.value)
    lost = min(gate, key=lambda s: s.value)
    return (
        Statement("ideal_avoided_17_and_37_degC", None, worst.measured(), at_least(ENOUGH)),
        Statement(
            "gate_avoided_17_or_37_degC",
            None,
            Measured(lost.passed, str(lost)),
            below(worst.passed, "fewer than {limit:g}"),
        ),
    )


def _draw(found: Found, figure: Figure) -> None:
    ax = sized_axes(figure, 5.6, 3.4)
    for k, kind in enumerate(KINDS):
        # beside one another, for they may be the same
        mine = {t + k - 0.5: share for (name, t), share in found.items() if name == kind}
        look = {"color": COLOURS[k], "marker": "o", "capsize": 2, "label": kind}
        draw_estimates(list(mine), list(mine.values()), look, ax)
    ax.set(xlabel="temperature (degC), biases set at 27", ylabel="share avoided", ylim=(-0.02, 1.05))
    ax.legend()


EXPERIMENT = Experiment(
    "milde2017-temperature", "avoidance against temperature, by kind of bias", reproduce,
    {"count": RUNS, "dies": DIES}, tuple(ROBOTS),
)  # fmt: skip
