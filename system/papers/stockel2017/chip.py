"""Figures 6 and 8 of Stöckel 2017 with the networks on the NEF chip, a fresh die and network a run.

The paper has no chip. The robots of both figures drive with their networks on 100 dies, and the shares that
do as the paper says are compared with it. Figure 6 (`bug-spiral`): Bug 0 must repeat its way, and Bug 2 reach
the goal on 90 of 100 dies. Figure 8 (`bug-field`): Bug 0 must reach the goal on 95 of 100 dies, the improved
Bug 2 on 90; the published Bug 2 stands beside the paper's three of eight, whose 95 % interval (Clopper and
Pearson) its own must overlap. Die k carries the network of seed k; both are from 4000 on, and none was used
before: dies 3000 to 3134 were looked at while the improved Bug 2 was enlarged. Decoders are solved at 27 degC
from what is counted on the die.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from system.bug.scenario import Scenario
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import FIXED_GATES
from system.papers.stockel2017.drive import NULLS, Drive, Drives, draw_ways, null_drives, program
from system.papers.stockel2017.fig6 import MAP as SPIRAL
from system.papers.stockel2017.fig8 import MAP as FIELD
from system.papers.stockel2017.fig8 import apart_row, published_share
from system.rule import at_least, unjudged
from system.statement import Statement
from system.study.campaign import ALONE, Execution, Numbered
from system.study.statistics.share import share_where
from system.verdict.null import nulls_of

FIRST, DIES, DURATION = 4000, 100, 150.0  # first die, how many, s
AGENTS = (
    (SPIRAL, "bug0", "published"),
    (SPIRAL, "bug2", "published"),
    (SPIRAL, "bug2", "improved"),
    (FIELD, "bug0", "published"),
    (FIELD, "bug2", "published"),
    (FIELD, "bug2", "improved"),
)
LEAST = {"bug0": 0.95, "bug2": 0.9}
SHOWN = 7  # as many as there are colours

Found = Mapping[tuple[str, str, str], Sequence[Drive]]


def rows(found: Found) -> tuple[Statement, ...]:
    """Make the statements of Figures 6 and 8 on the chip; `programs` has Bug 0's run by map."""
    again = [bool(t.repeats) for t in found[SPIRAL, "bug0", "published"]]
    published = share_where(t.reached for t in found[FIELD, "bug2", "published"])
    apart = max(
        t.apart for world in (SPIRAL, FIELD) for t in found[world, "bug0", "published"] if t.apart is not None
    )
    return (
        _share("fig6_bug0_repeats_its_way_share", again, LEAST["bug0"]),
        _reaches("fig6_bug2_published_reaches_share", found[SPIRAL, "bug2", "published"], None),
        _reaches("fig6_bug2_improved_reaches_share", found[SPIRAL, "bug2", "improved"], LEAST["bug2"]),
        _reaches("fig8_bug0_reaches_share", found[FIELD, "bug0", "published"], LEAST["bug0"]),
        published_share("fig8_bug2_published_reaches_share", published),
        _reaches("fig8_bug2_improved_reaches_share", found[FIELD, "bug2", "improved"], LEAST["bug2"]),
        apart_row(apart),
    )


def reproduce(
    progress: Progress, execution: Execution = ALONE, dies: int = DIES, duration: float = DURATION
) -> Report:
    """Drive all agents on all dies."""
    scenarios = {
        _named(world, agent, design): Scenario(
            agent, "chip", design, map=world, duration=duration, silicon_noise="off", **FIXED_GATES
        )
        for world, agent, design in AGENTS
    }
    keys = [Numbered(name, FIRST + k) for k in range(dies) for name in scenarios]
    campaign = Drives(scenarios, FIRST + SHOWN).campaign("stockel2017-chip")
    by_name = execution.by_condition(campaign, keys, progress)
    found = {agent: by_name[_named(*agent)] for agent in AGENTS}
    notes = tuple(
        f"{name}: {share_where(t.reached for t in runs)} reach the goal; spikes dropped:"
        f" {sum(t.dropped for t in runs)}."
        for name, runs in by_name.items()
    )
    nulls = nulls_of(rows, null_drives(found))
    return Report(rows(found), lambda figure: _draw(found, duration, figure), notes, nulls)


def _named(world: str, agent: str, design: str) -> str:
    return f"{world}, {agent} {design}"


def _reaches(name: str, runs: Sequence[Drive], least: float | None) -> Statement:
    return _share(name, [t.reached for t in runs], least)


def _share(name: str, said: list[bool], least: float | None) -> Statement:
    share = share_where(said).value
    return Statement(name, None, share, unjudged("given, no rule") if least is None else at_least(least))


def _draw(found: Found, duration: float, figure: Figure) -> None:
    figure.set_size_inches(12.0, 7.0)
    for ax, ((world, agent, design), runs) in zip(figure.subplots(2, 3).ravel(), found.items(), strict=True):
        paths = {f"die {FIRST + k}": np.array(t.path) for k, t in enumerate(runs[:SHOWN])}
        draw_ways(program(world, duration), paths, ax)
        share = f"{sum(t.reached for t in runs)} of {len(runs)}"
        ax.set_title(f"{world}, {agent} {design}: {share}", fontsize=9)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)


EXPERIMENT = Experiment(
    "stockel2017-chip", "Bug 0 and Bug 2 on the NEF chip, on a hundred dies", reproduce, {"dies": DIES},
    NULLS,
)  # fmt: skip
