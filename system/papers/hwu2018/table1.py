"""Table I of Hwu et al. 2018: lengths and costs of planned paths, spike wave against A*, on four maps.

Every planner plans 100 routes on each of four maps, and lengths and costs of the paths are compared, with the
paper's medians too. On each map 100 pairs of places are drawn (seed 1000): in bounds and more than 5 cells
apart. "Locations could not be out of bounds" is read as: a place where the robot can stand, that is grass,
gravel or road, of cost 3 at most; not the outer region, not a tree. Lengths and costs are counted as
`system.rover.planner` says.

Planned with the paper's discrete wave with its second pass ("paper"), with ideal cells ("wave"), with the
paper's A* and with Dijkstra's algorithm, against which the wave and an admissible A* are held.

Rules. The paper's statement, that the spike wave finds cheaper paths where there are roads and obstacles,
is tested on the three maps with a road as the paper does it: rank sum test, p < 0.001, of its discrete wave
against its A*. A test of ours, named so, stands beside it: one-sided signed rank of the pairs, of ideal cells
against A*. All of them are one family. The paper's "nearly identical" lengths: medians at most 2 cells apart,
the largest difference in its table. Its medians themselves: the 95 % interval of ours covers them. The maps
are ours, so that a "no" there is about them too.

Nulls: planners that all are the paper's A*, and planners whose names are drawn anew for each pair.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy import stats

from circuits.arrays import F64, I64
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import COLOURS
from system.rover.cost_map import MAPS, CostMap, load_map, random_pairs
from system.rover.planner import plan_path, planner_named
from system.rule import Measured, at_most, covering, none, significant
from system.statement import Statement
from system.study.statistics.interval import quantile_interval
from system.verdict.family import family
from system.verdict.null import Null, nulls_of, shuffled

PAIRS = 100
SEED = 1000
SIGNIFICANT = 0.001  # the paper's
NEARLY = 2.0  # cells
SAME, DRAWN = "every planner is A*", "names drawn anew"
NULLS = (SAME, DRAWN)
PLANNERS = ("paper", "wave", "a-star", "admissible-a-star", "dijkstra")
WITH_ROAD = tuple(name for name in MAPS if name != "map1-without-road")
PAPER: dict[str, dict[str, tuple[float, float]]] = {  # medians of length: wave, A*; of cost: wave, A*
    "map1-without-road": {"length": (8.5, 8.5), "cost": (25.5, 25.5)},
    "map1-road": {"length": (10.0, 9.0), "cost": (21.0, 24.0)},
    "map1-road-obstacles": {"length": (9.0, 9.0), "cost": (24.0, 24.5)},
    "map2": {"length": (13.0, 11.0), "cost": (34.5, 42.5)},
}


@dataclass(frozen=True, slots=True)
class Paths:
    """Lengths and costs of a map's pairs, int64[pairs], by planner."""

    length: Mapping[str, I64]
    cost: Mapping[str, I64]


def reproduce(progress: Progress, pairs: int = PAIRS) -> Report:
    """Plan every pair with every planner."""
    found: dict[str, Paths] = {}
    for name in with_progress(MAPS, progress):
        found[name] = plan_all(load_map(name), pairs)
    return Report(rows(found), lambda figure: _draw(found, figure), _notes(found), _nulls(found, pairs))


def _nulls(found: Mapping[str, Paths], pairs: int) -> tuple[Null, ...]:
    """Planners that differ by name alone."""
    one = {
        name: Paths(*(dict.fromkeys(PLANNERS, values["a-star"]) for values in (paths.length, paths.cost)))
        for name, paths in found.items()
    }

    def named_anew(order: I64) -> dict[str, Paths]:
        by_pair = order.reshape(pairs, len(PLANNERS)).argsort(axis=1)
        return {
            name: Paths(_renamed(paths.length, by_pair), _renamed(paths.cost, by_pair))
            for name, paths in found.items()
        }

    return (
        *nulls_of(rows, {SAME: one}),
        shuffled(DRAWN, rows, named_anew, pairs * len(PLANNERS)),
    )


def _renamed(values: Mapping[str, I64], by_pair: I64) -> dict[str, I64]:
    """Values by planner, each pair's in the order that is given for it, int64[pairs, planners]."""
    table = np.take_along_axis(np.array([values[name] for name in PLANNERS]).T, by_pair, axis=1)
    return dict(zip(PLANNERS, table.T, strict=True))


def plan_all(cost_map: CostMap, pairs: int) -> Paths:
    """Give the length and the cost of every pair's path by every planner."""
    lengths: dict[str, list[int]] = {name: [] for name in PLANNERS}
    costs: dict[str, list[int]] = {name: [] for name in PLANNERS}
    for start, goal in random_pairs(cost_map, pairs, np.random.default_rng(SEED)).tolist():
        for name in PLANNERS:
            plan = plan_path(cost_map, tuple(start), tuple(goal), planner_named(name))
            lengths[name].append(plan.length)
            costs[name].append(plan.cost)
    return Paths(
        {name: np.array(v, dtype=np.int64) for name, v in lengths.items()},
        {name: np.array(v, dtype=np.int64) for name, v in costs.items()},
    )


def signed_rank(first: I64, second: I64) -> float:
    """Give the one-sided p of the paired signed rank test that `first` is lower; 1 if no pair differs."""
    if np.array_equal(first, second):
        return 1.0
    return float(stats.wilcoxon(first, second, alternative="less").pvalue)


def rank_sum(first: I64, second: I64) -> float:
    """Give the two-sided p of Wilcoxon's rank sum test, as the paper does."""
    return float(stats.ranksums(first, second).pvalue)


def rows(found: Mapping[str, Paths]) -> tuple[Statement, ...]:
    """Make the statements about tests, optimal paths, lengths, and the paper's medians."""
    tests = [test(name, found[name]) for test in (_paper_test_row, _pairs_row) for name in WITH_ROAD]
    return (
        *family(tests),
        *(_optimal_row(name, paths, planner) for name, paths in found.items() for planner in _EXACT),
        *(_length_row(name, paths) for name, paths in found.items()),
        *(row for name, paths in found.items() for row in _median_rows(name, paths)),
    )


_EXACT = ("wave", "admissible-a-star")


def _paper_test_row(name: str, paths: Paths) -> Statement:
    """The paper's wave against its A*, by the paper's test."""
    wave, other = paths.cost["paper"], paths.cost["a-star"]
    p = rank_sum(wave, other)
    rule = significant(-1, SIGNIFICANT, "rank sum as in the paper, cost of its wave below A*")
    return Statement(f"{name}_rank_sum_p", "p < 0.001", _cheaper(wave, other, p), rule)


def _pairs_row(name: str, paths: Paths) -> Statement:
    """Ideal cells against A*, by a test of ours."""
    wave, other = paths.cost["wave"], paths.cost["a-star"]
    p = signed_rank(wave, other)
    rule = significant(-1, SIGNIFICANT, "signed rank of pairs (ours), cost of ideal wave below A*")
    return Statement(f"{name}_signed_rank_p", None, _cheaper(wave, other, p), rule)


def _cheaper(wave: I64, other: I64, p: float) -> Measured:
    """By how much the wave's mean cost is above the other's, shown as the p of a test."""
    return Measured(float(wave.mean() - other.mean()), f"{p:.2g}", p=p)


def _optimal_row(name: str, paths: Paths, planner: str) -> Statement:
    worse = int((paths.cost[planner] != paths.cost["dijkstra"]).sum())
    rule = none("no path dearer than Dijkstra's")
    return Statement(f"{name}_{planner}_not_optimal", None, float(worse), rule)


def _length_row(name: str, paths: Paths) -> Statement:
    ours = abs(float(np.median(paths.length["wave"]) - np.median(paths.length["a-star"])))
    paper = abs(PAPER[name]["length"][0] - PAPER[name]["length"][1])
    rule = at_most(NEARLY, "medians of wave and A* at most {limit:g} cells apart")
    return Statement(f"{name}_length_difference", paper, ours, rule)


def _median_rows(name: str, paths: Paths) -> list[Statement]:
    made = []
    rule = covering()
    for quantity, values in (("length", paths.length), ("cost", paths.cost)):
        for planner, paper in zip(("paper", "a-star"), PAPER[name][quantity], strict=True):
            ours = _median(values[planner].astype(np.float64))
            made.append(Statement(f"{name}_{planner}_median_{quantity}", paper, ours, rule))
    return made


def _median(values: F64) -> Measured:
    """The median with its interval."""
    middle, ends = float(np.median(values)), quantile_interval(values, 0.5)
    return Measured(middle, f"{middle:g} ({ends.low:.3g} to {ends.high:.3g})", ends)


def _notes(found: Mapping[str, Paths]) -> tuple[str, ...]:
    notes = ["Medians (means) of length and of cost; the row of the paper is its spike wave and its A*."]
    for name, paths in found.items():
        parts = [
            f"{planner} {_middle(paths.length[planner])} and {_middle(paths.cost[planner])}"
            for planner in PLANNERS
        ]
        p = PAPER[name]
        parts.append(
            f"Table I: wave {p['length'][0]:g}, {p['cost'][0]:g}; A* {p['length'][1]:g}, {p['cost'][1]:g}"
        )
        notes.append(f"{name}: {'; '.join(parts)}.")
        notes.append(f"{name}: {_tests(paths)}.")
    return tuple(notes)


def _middle(values: I64) -> str:
    return f"{np.median(values):g} ({values.mean():.4g})"


def _tests(paths: Paths) -> str:
    told = []
    for planner in ("wave", "paper"):
        a, b = paths.cost[planner], paths.cost["a-star"]
        told.append(
            f"cost of {planner} against A*: cheaper on {int((a < b).sum())}, dearer on {int((a > b).sum())}"
            f" of {a.size}, signed rank p = {signed_rank(a, b):.2g}, rank sum p = {rank_sum(a, b):.2g}"
        )
    return "; ".join(told)


def _draw(found: Mapping[str, Paths], figure: Figure) -> None:
    """Costs by planner over Dijkstra's, and lengths, a group a map."""
    figure.set_size_inches(8.0, 4.4)
    axes = figure.subplots(1, 2)
    shown = ("paper", "wave", "a-star")
    for ax, quantity in zip(axes, ("length", "cost"), strict=True):
        for k, planner in enumerate(shown):
            values = [getattr(paths, quantity)[planner] for paths in found.values()]
            box = ax.boxplot(
                values, positions=np.arange(len(found)) + 0.26 * (k - 1), widths=0.2, patch_artist=True,
                medianprops={"color": "black"}, flierprops={"markersize": 2},
            )  # fmt: skip
            for patch in box["boxes"]:
                patch.set(facecolor=COLOURS[k], alpha=0.7)
        for m, name in enumerate(found):
            ax.plot([m - 0.4], [PAPER[name][quantity][0]], marker=">", color="black", markersize=4)
            ax.plot([m + 0.4], [PAPER[name][quantity][1]], marker="<", color="black", markersize=4)
        ax.set_xticks(range(len(found)), [name.replace("-", "\n") for name in found], fontsize=8)
        ax.set(ylabel=f"path {quantity}", ylim=(0.0, None))
    names = {"paper": "discrete wave, two passes", "wave": "ideal cells", "a-star": "the paper's A*"}
    for k, planner in enumerate(shown):
        axes[0].plot([], [], color=COLOURS[k], linewidth=6, alpha=0.7, label=names[planner])
    axes[0].plot([], [], color="black", marker=">", linestyle="", label="Table I, wave")
    axes[0].plot([], [], color="black", marker="<", linestyle="", label="Table I, A*")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)


EXPERIMENT = Experiment(
    "hwu2018-table1", "lengths and costs of paths: spike wave against A* on four maps", reproduce,
    nulls=NULLS,
)  # fmt: skip
