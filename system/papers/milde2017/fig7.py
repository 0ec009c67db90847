"""Figure 7 of Milde et al. 2017: success by light and colour.

The robot drives towards blocks of three colours in three lights, and the shares of runs that succeed are
compared. The figure shows runs that succeed and runs that fail; it gives no shares. A run succeeds that
passes the block's line and touches nothing: a robot that the sensor's noise holds back has avoided nothing.
Rules (ours): in normal light blue is avoided in at least 90 % of the runs and yellow in at most half; no
colour succeeds more often in very dark light than in normal light.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.avoided import report_avoided
from system.papers.milde2017.null import ROBOTS, always
from system.papers.milde2017.picture import SHADES
from system.plot import INK, draw_estimates, sized_axes
from system.pushbot.campaign import Drive, Runs, drive_repeats
from system.pushbot.scenario import Scenario
from system.rule import Measured, at_least, at_most
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.share import Share

LIGHTS = ("normal", "dark", "very-dark")
BLOCKS = ("blue", "red", "yellow")
RUNS, DIES = 10, 10
SEEN, UNSEEN = 0.9, 0.5

NULLS = {**ROBOTS, "always gets past": always(collided=0.0, crossed=1.0)}

Free = Mapping[tuple[str, str], Share]


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = RUNS, dies: int = DIES,
    lights: Sequence[str] = LIGHTS, blocks: Sequence[str] = BLOCKS,
) -> Report:  # fmt: skip
    """Drive towards blocks of all colours in all lights."""
    cells = {
        (a, b): Drive(Scenario(light=a, colour=b, silicon_noise="off", **IDEAL_CURRENTS))
        for a in lights
        for b in blocks
    }
    driven = drive_repeats(execution, EXPERIMENT.name, cells, Runs(count, dies), Runs(RUNS, DIES), progress)
    return report_avoided(driven, NULLS, rows, _draw, ", ".join)


def rows(free: Free) -> tuple[Statement, ...]:
    """Make the statements about colours in normal light, then about what the dark does."""
    blue, yellow = free["normal", "blue"], free["normal", "yellow"]
    seen = Statement("normal_blue_avoided", "yes", blue.measured(), at_least(SEEN))
    unseen = Statement("normal_yellow_avoided", "no", yellow.measured(), at_most(UNSEEN), fitted=True)
    colours = [colour for _, colour in list(free)[: len(free) // len({light for light, _ in free})]]
    return (seen, unseen, *(_dark(c, free["very-dark", c], free["normal", c]) for c in colours))


def _dark(colour: str, dark: Share, normal: Share) -> Statement:
    rule = at_most(normal.passed, "at most {limit:g} as in normal light")
    ours = Measured(dark.passed, str(dark))
    return Statement(f"{colour}_avoided_in_the_dark", "fewer or as many", ours, rule)


def _draw(free: Free, figure: Figure) -> None:
    ax = sized_axes(figure, 6.0, 3.4)
    lights = list(dict.fromkeys(light for light, _ in free))
    colours = list(dict.fromkeys(colour for _, colour in free))
    for k, colour in enumerate(colours):
        x = [i + 0.25 * (k - 1) for i in range(len(lights))]
        shares = [free[light, colour] for light in lights]
        ax.bar(x, [s.value for s in shares], 0.22, color=SHADES[colour], label=colour)
        draw_estimates(x, shares, {"linestyle": "", "color": INK, "capsize": 2}, ax)
    ax.set_xticks(range(len(lights)), lights)
    ax.set_ylabel("share avoided")
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3)


EXPERIMENT = Experiment(
    "milde2017-fig7", "success by light and colour", reproduce, {"count": RUNS, "dies": DIES},
    tuple(NULLS),
)  # fmt: skip
