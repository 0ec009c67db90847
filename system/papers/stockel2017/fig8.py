"""Figure 8 of Stöckel 2017: a large map, where neural Bug 2 gets stuck.

The paper: Bug 0, program and neurons, reaches the goal on a longer way than the program of Bug 2, which is
near the shortest; of eight neural Bug 2, three reach it, the others circle around obstacles, because they
left a wall away from the line. The map is ours (`bug-field`), so the share need not be the paper's: its 95 %
interval (Clopper and Pearson) must overlap that of three of eight. `improved` is ours: a finer memory of
direction and distance, which must reach the goal in at least 90 % of the networks.
"""

from __future__ import annotations

from matplotlib.figure import Figure

from circuits.arrays import F64
from system.bug.body import RADIUS
from system.bug.path import median_distance
from system.bug.picture import draw_paths, draw_shortest, draw_world
from system.bug.run import Scenario, Trace, run, summarise
from system.experiment import Experiment, Progress, Report, Row
from system.study.statistics.share import Share, share_where

MAP = "bug-field"
FIRST, NETWORKS, DURATION = 1000, 40, 150.0  # first seed, how many, s
PAPER = (3, 8)  # reached, of
MOST = 0.9
SHOWN = 8  # paths of neural Bug 2 in the picture, as in the paper
NEAR_SHORTEST = 1.25  # length over the shortest one's that counts as close; ours

Found = dict[str, list[Trace]]


def traces(progress: Progress, networks: int = NETWORKS) -> Found:
    """Runs by name."""
    asked: list[tuple[str, Scenario]] = [
        (f"{agent} reference", Scenario(agent, map=MAP, duration=DURATION)) for agent in ("bug0", "bug2")
    ]
    for seed in range(FIRST, FIRST + networks):
        for agent, design in (("bug0", "published"), ("bug2", "published"), ("bug2", "improved")):
            scenario = Scenario(agent, "ideal", design, map=MAP, duration=DURATION, seed=seed)
            asked.append((f"{agent} {design}", scenario))
    found: Found = {}
    for k, (name, scenario) in enumerate(asked, 1):
        found.setdefault(name, []).append(run(scenario))
        progress(k / len(asked))
    return found


def rows(found: Found) -> tuple[Row, ...]:
    """Statements of the figure, and of the design that is ours."""
    reached = {name: sum(t.reached for t in runs) for name, runs in found.items()}
    ratio = {name: summarise(found[name][0])["path_ratio"] for name in ("bug0 reference", "bug2 reference")}
    of = len(found["bug2 published"])
    program = found["bug0 reference"][0].path
    apart = max(median_distance(t.path, program) for t in found["bug0 published"])
    ours, theirs = Share(reached["bug2 published"], of).interval, Share(*PAPER).interval
    zero, two = ratio["bug0 reference"], ratio["bug2 reference"]

    def share(name: str, runs: str) -> Row:
        value = reached[runs] / len(found[runs])
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


def reproduce(progress: Progress) -> Report:
    """All agents on the large map."""
    found = traces(progress)
    improved = share_where(t.reached for t in found["bug2 improved"])
    notes = (f"improved design: {improved}, 95 % interval.",)
    return Report(rows(found), lambda figure: _draw(found, figure), notes)


def _draw(found: Found, figure: Figure) -> None:
    """Programs and Bug 0, published and improved Bug 2."""
    figure.set_size_inches(9.6, 7.0)
    axes = figure.subplots(2, 2).ravel()
    first = found["bug0 reference"][0]
    shown = {
        "programs": {f"{name}, program": found[f"{name} reference"][0].path for name in ("bug0", "bug2")},
        "Bug 0, neurons": _paths(found["bug0 published"]),
        "Bug 2, neurons, published": _paths(found["bug2 published"]),
        "Bug 2, neurons, improved": _paths(found["bug2 improved"]),
    }
    for ax, (title, paths) in zip(axes, shown.items(), strict=True):
        draw_world(first.world, ax)
        draw_shortest(first.shortest, ax)
        draw_paths(paths, ax)
        ax.set_title(title, fontsize=9)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)


def _paths(runs: list[Trace]) -> dict[str, F64]:
    return {f"seed {t.scenario.seed}": t.path for t in runs[:SHOWN]}


EXPERIMENT = Experiment(
    "stockel2017-fig8",
    "a large map: Bug 0 reaches, neural Bug 2 gets stuck, a finer one less often",
    reproduce,
)
