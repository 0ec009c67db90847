"""Figure 8 of Stöckel 2017: a large map, where neural Bug 2 gets stuck.

The paper: Bug 0, program and neurons, reaches the goal on a longer way than the program of Bug 2, which is
near the shortest; of eight neural Bug 2, three reach it, the others circle around obstacles, because they
left a wall away from the line. The map is ours (`bug-field`), so the share need not be the paper's: its 95 %
interval (Clopper and Pearson) must overlap that of three of eight. `improved` is ours: a finer memory of
direction and distance, which must reach the goal in at least 90 % of the networks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.bug.body import RADIUS
from system.bug.run import Scenario, Trace, summarise
from system.experiment import Experiment, Progress, Report, Row
from system.papers.stockel2017.drive import Drive, Drives, draw_ways, program
from system.study.campaign import ALONE, Execution, Numbered
from system.study.statistics.share import Share, share_where

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


def rows(found: Found, known: Programs) -> tuple[Row, ...]:
    """Statements of the figure, and of the design that is ours."""
    by_run = {name: [t.reached for t in runs] for name, runs in found.items()}
    by_run |= {f"{agent} reference": [trace.reached] for agent, trace in known.items()}
    reached = {name: sum(each) for name, each in by_run.items()}
    of = len(found["bug2 published"])
    apart = max(t.apart for t in found["bug0 published"] if t.apart is not None)
    ours, theirs = Share(reached["bug2 published"], of).interval, Share(*PAPER).interval
    zero, two = (summarise(known[agent])["path_ratio"] for agent in ("bug0", "bug2"))

    def share(name: str, runs: str) -> Row:
        value = reached[runs] / len(by_run[runs])
        return Row(name, 1.0, value, "the same", None, fitted=False, agrees=value == 1.0)

    return (
        share("bug0_reference_reaches_share", "bug0 reference"),
        share("bug0_ideal_reaches_share", "bug0 published"),
        share("bug2_reference_reaches_share", "bug2 reference"),
        Row(
            "bug0_median_distance_of_paths", "highly similar", apart, f"below {2 * RADIUS:g} map units",
            2.0 * RADIUS, fitted=False, agrees=apart < 2.0 * RADIUS,
        ),
        Row(
            "bug2_reference_length_over_shortest", "relatively close", two, f"below {NEAR_SHORTEST:g}",
            NEAR_SHORTEST, fitted=False, agrees=two is not None and two < NEAR_SHORTEST,
        ),
        Row(
            "bug0_length_over_bug2s", "longer", zero / two if zero and two else None, "above 1", 1.0,
            fitted=False, agrees=bool(zero and two and zero > two),
        ),
        Row(
            "bug2_published_reaches_share", PAPER[0] / PAPER[1], reached["bug2 published"] / of,
            f"95 % intervals overlap: {theirs.low:.2f}-{theirs.high:.2f}, {ours.low:.2f}-{ours.high:.2f}",
            None, fitted=False, agrees=ours.low <= theirs.high and theirs.low <= ours.high,
        ),
        Row(
            "bug2_improved_reaches_share", None, reached["bug2 improved"] / of, f"at least {MOST:g}", MOST,
            fitted=False, agrees=reached["bug2 improved"] >= MOST * of,
        ),
    )  # fmt: skip


def reproduce(
    progress: Progress, execution: Execution = ALONE, networks: int = NETWORKS, duration: float = DURATION
) -> Report:
    """All agents on the large map."""
    scenarios = {
        f"{agent} {design}": Scenario(agent, "ideal", design, map=MAP, duration=duration)
        for agent, design in (("bug0", "published"), ("bug2", "published"), ("bug2", "improved"))
    }
    keys = [Numbered(name, FIRST + k) for k in range(networks) for name in scenarios]
    campaign = Drives(scenarios, FIRST + SHOWN).campaign("stockel2017-fig8")
    found, known = execution.by_condition(campaign, keys, progress), programs(duration)
    improved = share_where(t.reached for t in found["bug2 improved"])
    notes = (f"improved design: {improved}, 95 % interval.",)
    return Report(rows(found, known), lambda figure: _draw(found, known, figure), notes)


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
)
