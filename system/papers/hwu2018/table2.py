"""Table II of Hwu et al. 2018: discrete Frechet distances between planned and driven routes.

The rover drives six routes four times on each of the four maps, planned by ideal cells, and its mean
distances from the planned routes are compared with the paper's. The world, the rover and its sensors are
ours (`system.rover.body`), so that the paper's single figures cannot be expected: the mean of each map
must lie within 7 to 25 m, about the span of the paper's Table II. Obstacles that no map has stand about,
and the rover has no sonar, as the paper's robot relied on GPS and compass: an operator redirects it, "very
infrequently in map 1, and more frequently in map 2", which is a row too.

Trial k of route n has seed 1000 + 10 n + k, whichever the map. Distances are taken to the true places, once a
second; the paper has only its GPS, and distances to the fixes are in the notes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64, I64
from system.experiment import Experiment, Progress, Report, with_progress
from system.rover.cost_map import MAPS, load_map
from system.rover.drive import polyline
from system.rover.picture import draw_map, draw_scale_bar, draw_ways
from system.rover.run import Trace, run, summarise
from system.rover.scenario import Scenario
from system.rule import above, all_of, between
from system.statement import Statement
from system.verdict.null import Null, nulls_of, shuffled

ROUTES = (
    ((2, 10), (19, 10)), ((10, 10), (5, 3)), ((16, 3), (10, 10)),
    ((5, 3), (15, 16)), ((15, 16), (16, 3)), ((19, 10), (5, 3)),
)  # fmt: skip
TRIALS = 4
FIRST_SEED = 1000
STILL, CONSTANT, DRAWN = "never moves", "one answer for every drive", "drives drawn anew"
NULLS = (STILL, CONSTANT, DRAWN)
LOWEST, HIGHEST = 7.0, 25.0  # m, of a map's mean
PAPER: dict[str, tuple[float, ...]] = {  # means of four trials, m
    "map1-without-road": (12.54, 9.28, 18.20, 13.05, 8.39, 23.70),
    "map1-road": (19.44, 14.28, 13.04, 16.56, 8.73, 18.15),
    "map1-road-obstacles": (18.67, 11.47, 16.06, 12.87, 7.92, 21.44),
    "map2": (11.69, 10.69, 18.46, 14.78, 20.11, 22.98),
}


@dataclass(frozen=True, slots=True)
class Trials:
    """All drives of a map by route and trial: traces, and numbers of each, float64[route, trial]."""

    traces: tuple[tuple[Trace, ...], ...]
    frechet: F64
    frechet_gps: F64
    interventions: F64
    arrived: F64


def reproduce(progress: Progress) -> Report:
    """Drive all routes of all maps."""
    found: dict[str, Trials] = {}
    for name in with_progress(MAPS, progress):
        found[name] = drive_map(name)
    return Report(rows(found), lambda figure: _draw(found, figure), _notes(found), _nulls(found))


def _nulls(found: dict[str, Trials]) -> tuple[Null, ...]:
    """A rover that stays at the start, drives that are all alike, and drives of any map and route."""
    still = {name: _ended(t, _from_start(name, t), 0.0, 0.0) for name, t in found.items()}
    every = np.stack([t.frechet for t in found.values()]), np.stack([t.interventions for t in found.values()])
    mean = [float(each.mean()) for each in every]
    alike = {name: _ended(t, np.full_like(t.frechet, mean[0]), mean[1], 1.0) for name, t in found.items()}

    def drawn(order: I64) -> dict[str, Trials]:
        new = [each.ravel()[order].reshape(each.shape) for each in every]
        return {
            name: replace(t, frechet=new[0][k], interventions=new[1][k])
            for k, (name, t) in enumerate(found.items())
        }

    return (*nulls_of(rows, {STILL: still, CONSTANT: alike}), shuffled(DRAWN, rows, drawn, every[0].size))


def _ended(trials: Trials, frechet: F64, interventions: float, arrived: float) -> Trials:
    """The same drives with these distances (m), and so many interventions and arrivals in each."""
    like = trials.arrived
    told = np.full_like(like, interventions), np.full_like(like, arrived)
    return replace(trials, frechet=frechet, interventions=told[0], arrived=told[1])


def _from_start(name: str, trials: Trials) -> F64:
    """Distance (m) of the planned way from its start: Frechet's from a way that stays there."""
    found = np.empty_like(trials.frechet)
    for (route, trial), _ in np.ndenumerate(found):
        way = polyline(load_map(name), trials.traces[route][trial].trips[0].plan.path)
        found[route, trial] = np.hypot(*(way - way[0]).T).max()
    return found


def drive_map(name: str) -> Trials:
    """Drive all routes of a map, each as often as the paper did."""
    traces = tuple(
        tuple(
            run(Scenario(map=name, start=start, goal=goal, posts=True, seed=FIRST_SEED + 10 * n + k))
            for k in range(TRIALS)
        )
        for n, (start, goal) in enumerate(ROUTES)
    )
    summaries = [[summarise(trace) for trace in row] for row in traces]

    def table(quantity: str) -> F64:
        return np.array([[s[quantity] for s in row] for row in summaries], dtype=np.float64)

    return Trials(
        traces, table("frechet_m"), table("frechet_gps_m"), table("interventions"), table("arrived")
    )


def rows(found: dict[str, Trials]) -> tuple[Statement, ...]:
    """Make the statements about the mean distance on each map, interventions and arrivals."""
    open_area = np.mean([found[name].interventions.mean() for name in MAPS if name != "map2"])
    cluttered = float(found["map2"].interventions.mean())
    arrived = float(np.mean([t.arrived.mean() for t in found.values()]))
    return (
        *(_mean_row(name, trials) for name, trials in found.items()),
        Statement(
            "interventions_a_trial_map2",
            "more frequent than in map 1",
            cluttered,
            above(float(open_area), "above map 1's {limit:.3g}"),
        ),
        Statement("arrived_share", 1.0, arrived, all_of(1.0)),
    )


def _mean_row(name: str, trials: Trials) -> Statement:
    ours = float(trials.frechet.mean())
    rule = between(LOWEST, HIGHEST, "mean of all drives within {low:g} to {high:g} m")
    return Statement(f"{name}_frechet_m", float(np.mean(PAPER[name])), ours, rule)


def _notes(found: dict[str, Trials]) -> tuple[str, ...]:
    routes = "; ".join(f"{a[0]},{a[1]} to {b[0]},{b[1]}" for a, b in ROUTES)
    return (
        f"Routes: {routes}. Mean and standard deviation of {TRIALS} trials, m, ours and (the paper's mean).",
        *(
            f"{name}: {', '.join(_cell(t.frechet[n], PAPER[name][n]) for n in range(len(ROUTES)))};"
            f" mean to the GPS fixes {t.frechet_gps.mean():.3g};"
            f" interventions {int(t.interventions.sum())} in {t.interventions.size} drives"
            for name, t in found.items()
        ),
    )


def _cell(values: F64, paper: float) -> str:
    return f"{values.mean():.1f}±{values.std(ddof=1):.1f} ({paper:.1f})"


def _draw(found: dict[str, Trials], figure: Figure) -> None:
    """A row a map, a column a route, as the paper's Figures 7 to 10."""
    figure.set_size_inches(11.0, 7.6)
    axes = figure.subplots(len(found), len(ROUTES), squeeze=False)
    for row, (name, trials) in zip(axes, found.items(), strict=True):
        row[0].set_ylabel(name, fontsize=8)
        for ax, traces, (start, goal) in zip(row, trials.traces, ROUTES, strict=True):
            cost_map = load_map(name)
            draw_map(cost_map, None, ax)
            planned = polyline(cost_map, traces[0].trips[0].plan.path)
            draw_ways(planned, [t.trips[0].drive.place for t in traces], ax, traces[0].scenario.rover.reach)
            draw_scale_bar(cost_map, ax, label=False)
            ax.set_xticks(())
            ax.set_yticks(())
            ax.set_aspect("auto")  # cells square, as the paper shows map 2
            if ax in axes[0]:
                ax.set_title(f"S({start[0]},{start[1]}) E({goal[0]},{goal[1]})", fontsize=8)
    figure.supxlabel(
        "black: planned; colours: four drives; dashed: a fix within arrives; bars: 10 m", fontsize=8
    )


EXPERIMENT = Experiment(
    "hwu2018-table2",
    "Frechet distances between planned and driven routes: 6 routes, 4 trials, 4 maps",
    reproduce,
    nulls=NULLS,
)
