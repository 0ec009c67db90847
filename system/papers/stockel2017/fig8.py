"""Figure 8 of Stöckel 2017: a large map, where neural Bug 2 gets stuck.

Programs and networks drive on a large map, and how many reach the goal is compared with the paper's: Bug 0,
program and neurons, reaches the goal on a longer way than the program of Bug 2, which is
near the shortest; of eight neural Bug 2, three reach it, the others circle around obstacles, because they
left a wall away from the line. The map is ours (`bug-field`; it was widened after the published Bug 2 hardly
reached its goal), so the share need not be the paper's: its 95 %
interval (Clopper and Pearson) must overlap that of three of eight. `improved` is ours: a finer memory of
direction and distance, which must reach the goal in at least 90 % of the networks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.bug.body import RADIUS
from system.bug.run import Trace, summarise
from system.bug.scenario import Scenario
from system.experiment import Experiment, Progress, Report
from system.papers.stockel2017.drive import NULLS, Drive, Drives, draw_ways, null_drives, program
from system.rule import above, at_least, below, equal, overlapping
from system.statement import Statement
from system.study.campaign import ALONE, Execution, Numbered
from system.study.statistics.share import Share, share_where
from system.verdict.null import nulls_of

MAP = "bug-field"
FIRST, NETWORKS, DURATION = 1000, 40, 150.0  # first seed, how many, s
PAPER = (3, 8)  # reached, of
MOST = 0.9
SHOWN = 8  # paths of neural Bug 2 in the picture, as in the paper
NEAR_SHORTEST = 1.25  # length over the shortest one's that counts as close; ours

Found = Mapping[str, Sequence[Drive]]  # networks, by agent and design
Programs = Mapping[str, Trace]  # by agent


def programs(duration: float = DURATION) -> Programs:
    """Runs of the programs."""
    return {agent: program(MAP, duration, agent) for agent in ("bug0", "bug2")}


def rows(found: Found, known: Programs) -> tuple[Statement, ...]:
    """Make the statements of the figure, and one about the design that is ours."""
    by_run = {name: [t.reached for t in runs] for name, runs in found.items()}
    by_run |= {f"{agent} reference": [trace.reached] for agent, trace in known.items()}
    reached = {name: sum(each) for name, each in by_run.items()}
    of = len(found["bug2 published"])
    apart = max(t.apart for t in found["bug0 published"] if t.apart is not None)
    zero, two = (summarise(known[agent])["path_ratio"] for agent in ("bug0", "bug2"))

    def share(name: str, runs: str) -> Statement:
        value = reached[runs] / len(by_run[runs])
        return Statement(name, 1.0, value, equal())

    return (
        share("bug0_reference_reaches_share", "bug0 reference"),
        share("bug0_ideal_reaches_share", "bug0 published"),
        share("bug2_reference_reaches_share", "bug2 reference"),
        apart_row(apart),
        Statement("bug2_reference_length_over_shortest", "relatively close", two, below(NEAR_SHORTEST)),
        Statement("bug0_length_over_bug2s", "longer", zero / two if zero and two else None, above(1.0)),
        published_share("bug2_published_reaches_share", Share(reached["bug2 published"], of)),
        Statement("bug2_improved_reaches_share", None, reached["bug2 improved"] / of, at_least(MOST)),
    )


def apart_row(apart: float) -> Statement:
    """Compare how far Bug 0's paths are from the program's, a median in map units, with the robot's width."""
    rule = below(2.0 * RADIUS, "below {limit:g} map units")
    return Statement("bug0_median_distance_of_paths", "highly similar", apart, rule)


def published_share(name: str, ours: Share) -> Statement:
    """Compare how often the published Bug 2 reaches the goal with the paper's three of eight."""
    mine, theirs = ours.interval, Share(*PAPER).interval
    text = f"95 % intervals overlap: {{low:.2f}}-{{high:.2f}}, {mine.low:.2f}-{mine.high:.2f}"
    return Statement(name, PAPER[0] / PAPER[1], ours.measured(ours.value), overlapping(theirs, text))


def reproduce(
    progress: Progress, execution: Execution = ALONE, networks: int = NETWORKS, duration: float = DURATION
) -> Report:
    """Drive all agents on the large map."""
    scenarios = {
        f"{agent} {design}": Scenario(agent, "ideal", design, map=MAP, duration=duration)
        for agent, design in (("bug0", "published"), ("bug2", "published"), ("bug2", "improved"))
    }
    keys = [Numbered(name, FIRST + k) for k in range(networks) for name in scenarios]
    campaign = Drives(scenarios, FIRST + SHOWN).campaign("stockel2017-fig8")
    found, known = execution.by_condition(campaign, keys, progress), programs(duration)
    improved = share_where(t.reached for t in found["bug2 improved"])
    notes = (f"improved design: {improved}, 95 % interval.",)
    nulls = nulls_of(lambda runs: rows(runs, known), null_drives(found))
    return Report(rows(found, known), lambda figure: _draw(found, known, figure), notes, nulls)


def _draw(found: Found, known: Programs, figure: Figure) -> None:
    """Programs and Bug 0, published and improved Bug 2."""
    figure.set_size_inches(9.6, 7.0)
    axes = figure.subplots(2, 2).ravel()
    shown = {
        "programs": {f"{agent}, program": trace.path for agent, trace in known.items()},
        "Bug 0, neurons": _paths(found["bug0 published"]),
        "Bug 2, neurons, published": _paths(found["bug2 published"]),
        "Bug 2, neurons, improved": _paths(found["bug2 improved"]),
    }
    for ax, (title, paths) in zip(axes, shown.items(), strict=True):
        draw_ways(known["bug0"], paths, ax)
        ax.set_title(title, fontsize=9)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)


def _paths(runs: Sequence[Drive]) -> dict[str, F64]:
    return {f"seed {FIRST + k}": np.array(t.path) for k, t in enumerate(runs[:SHOWN])}


EXPERIMENT = Experiment(
    "stockel2017-fig8",
    "a large map: Bug 0 reaches, neural Bug 2 gets stuck, a finer one less often",
    reproduce,
    {"networks": NETWORKS},
    NULLS,
)
