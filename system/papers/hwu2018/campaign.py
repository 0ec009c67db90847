"""What mismatch, temperature and speed cost the wavefront chip's plans: regret against Dijkstra over dies.

No figure of the paper: Hwu et al. 2018 (IV.B) take a delay line on neuromorphic hardware for exact. The
costs of the chip's paths are compared with the lowest ones, between conditions. 200 dies (A/1000 on) plan 20
routes on map 1 with road and obstacles, and on a map of costs drawn uniformly from 1 to 31 (seed 1000), where
hardly two paths are equally cheap. About the design point (gate biases, 100 us a unit, 27 degC, the drawn
areas) one quantity is varied at a time, for both kinds of bias. `system.rover.campaign` says what is
estimated; the share of optimal paths below which a condition counts as one where paths stop being optimal is
95 % (ours).

Rows: exact delays lose nothing; at the design point the mean regret on map 1 stays below 1 % (ours, set after
trials on dies below 1000); devices of 16 times the area lose less than those of a quarter, by intervals that
do not overlap.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chips.wavefront.axon_graph import grid_graph
from circuits.arrays import I64
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import COLOURS, INK, draw_estimates
from system.rover.campaign import Case, Outcome, first_failure, regrets, run_case
from system.rover.cost_map import MAX_CODE, CostMap, load_map, random_pairs
from system.rule import Measured, apart_below, below, exactly
from system.statement import Statement
from system.verdict.null import Null, nulls_of, shuffled

DIES, FIRST_DIE, ROUTES, SEED = 200, 1000, 20, 1000
PARK, ANY = "map1-road-obstacles", "random-1-to-31"
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")
UNITS = (2e-6, 5e-6, 10e-6, 20e-6, 50e-6, 100e-6, 200e-6, 500e-6)  # s
TEMPERATURES = (-10.0, 0.0, 27.0, 45.0, 65.0)  # degC
AREAS = (0.25, 0.5, 1.0, 2.0, 4.0, 16.0)  # below, mismatch leaves the record's box
SWEEPS: Mapping[str, tuple[float, ...]] = {"unit": UNITS, "temperature_c": TEMPERATURES, "area": AREAS}
MOST = 0.01  # mean regret at the design point, share of the lowest cost
ENOUGH = 0.95  # share of optimal paths
CONSTANT, DRAWN = "every condition is alike", "conditions drawn anew"
NULLS = (CONSTANT, DRAWN)
LABELS = {"unit": "unit delay (us)", "temperature_c": "temperature (degC)", "area": "area of devices"}

Found = Mapping[tuple[str, BiasKind, str], Sequence[Outcome]]


def reproduce(
    progress: Progress, dies: int = DIES, routes: int = ROUTES, sweeps: Mapping[str, Sequence[float]] = SWEEPS
) -> Report:
    """Plan all sweeps on both maps; the design point must be among them, and areas must rise."""
    silicon = [Die("A", FIRST_DIE + k) for k in range(dies)]
    maps = {name: (cost_map, _routes(cost_map, routes)) for name, cost_map in _maps().items()}
    known: dict[tuple[str, Case], Outcome] = {}
    found: dict[tuple[str, BiasKind, str], list[Outcome]] = {}
    cases = [(m, k, q, v) for m in maps for k in KINDS for q, values in sweeps.items() for v in values]
    for name, kind, quantity, value in with_progress(cases, progress):
        case = _case(kind, quantity, value)
        if (name, case) not in known:
            cost_map, pairs = maps[name]
            known[name, case] = run_case(case, cost_map, pairs, silicon, np.random.default_rng(SEED))
        found.setdefault((name, kind, quantity), []).append(known[name, case])
    exact = [int(_exact(cost_map, pairs).sum()) for cost_map, pairs in maps.values()]
    nulls = _nulls(found, exact)
    return Report(rows(found, exact), lambda figure: _draw(found, figure), _notes(found), nulls)


def _nulls(found: Found, exact: Sequence[int]) -> tuple[Null, ...]:
    """Conditions that all have the regret of the middle one, and conditions whose regrets change places."""
    places = [(key, k) for key, outcomes in found.items() for k in range(len(outcomes))]
    every = [found[key][k] for key, k in places]
    known = [o for o in every if np.isfinite(o.regret.value)]
    middle = sorted(known, key=lambda o: o.regret.value)[len(known) // 2]

    def told(outcomes: Sequence[Outcome]) -> Found:
        made: dict[tuple[str, BiasKind, str], list[Outcome]] = {}
        for (key, k), other in zip(places, outcomes, strict=True):
            made.setdefault(key, []).append(replace(other, case=found[key][k].case))
        return made

    def judged(made: Found) -> tuple[Statement, ...]:
        return rows(made, exact)

    return (
        *nulls_of(judged, {CONSTANT: told([middle] * len(every))}),
        shuffled(DRAWN, judged, lambda order: told([every[k] for k in order]), len(every)),
    )


def _case(kind: BiasKind, quantity: str, value: float) -> Case:
    """The design point but for one quantity."""
    changed: Any = {quantity: value}
    return replace(Case(kind), **changed)


def _maps() -> dict[str, CostMap]:
    random = np.random.default_rng(SEED)
    drawn = CostMap(ANY, random.integers(1, MAX_CODE + 1, (20, 20)))
    return {PARK: load_map(PARK), ANY: drawn}


def _routes(cost_map: CostMap, count: int) -> I64:
    """Routes between places in bounds; on the drawn map between any places."""
    places = np.argwhere(cost_map.costs > 0) if cost_map.name == ANY else None
    return random_pairs(cost_map, count, np.random.default_rng(SEED), places)


def _exact(cost_map: CostMap, routes: I64) -> I64:
    """Regret of delays that are the costs."""
    graph = grid_graph(*cost_map.shape)
    return regrets(cost_map, graph, cost_map.costs.ravel()[None].astype(np.float64), routes)


def rows(found: Found, exact: Sequence[int]) -> tuple[Statement, ...]:
    """Make the statements about exact delays, the design point and the area of the devices."""
    design = next(o for o in found[PARK, "gate", "unit"] if o.case == Case())
    total = float(sum(exact))
    return (
        Statement("exact_delays_regret", "none", total, exactly(0.0, "{limit:g} on both maps")),
        Statement(
            f"{PARK}_design_point_regret", None, design.regret.value, below(MOST, "below {percent:g} %")
        ),
        *(_area_row(name, kind, found[name, kind, "area"]) for name in (PARK, ANY) for kind in KINDS),
    )


def _area_row(name: str, kind: str, outcomes: Sequence[Outcome]) -> Statement:
    small, large = outcomes[0].regret, outcomes[-1].regret
    rule = apart_below(small, "regret at area x16 below that at x0.25, {limit:.3g}, intervals apart")
    ours = Measured(large.value, large.value, large.interval)
    return Statement(f"{name}_{kind}_area_16_regret", None, ours, rule)


def _notes(found: Found) -> tuple[str, ...]:
    first = (
        "A condition a line: mean regret as a share of the lowest cost (95 % interval), the worst path's;"
        " share of dies with every route optimal (interval), of all paths, of the nominal die's; unit delay"
        " and spread of a cell."
    )
    lines = [
        f"{name}: {_line(outcome)}"
        for (name, _, quantity), outcomes in found.items()
        for outcome in outcomes
        if quantity == "unit" or outcome.case != Case(outcome.case.bias_kind)
    ]
    return (first, *lines, *(_stops(key, outcomes) for key, outcomes in found.items()))


def _line(o: Outcome) -> str:
    low, high = 100 * o.regret.interval.low, 100 * o.regret.interval.high
    outside = f"; {o.outside} dies outside the record" if o.outside else ""
    return (
        f"{o.case}: regret {100 * o.regret.value:.3g} % ({low:.3g} to {high:.3g}), worst"
        f" {100 * o.worst:.3g} %, dies {100 * o.optimal.value:.3g} % ({100 * o.optimal.interval.low:.3g} to"
        f" {100 * o.optimal.interval.high:.3g}), paths {100 * o.paths_optimal:.4g} %, nominal"
        f" {100 * o.nominal:.3g} %; {1e6 * o.unit:.3g} us, {100 * o.spread:.2g} %{outside}"
    )


def _stops(key: tuple[str, BiasKind, str], outcomes: Sequence[Outcome]) -> str:
    name, kind, quantity = key
    worse = first_failure(outcomes, ENOUGH)
    over = f"{name}, {kind}, over {LABELS[quantity]}"
    if worse is None:
        return f"{over}: at least {100 * ENOUGH:g} % of paths optimal everywhere."
    bad = [o for o in outcomes if o.paths_optimal < ENOUGH]
    values = ", ".join(f"{getattr(o.case, quantity) * (1e6 if quantity == 'unit' else 1.0):g}" for o in bad)
    return f"{over}: fewer than {100 * ENOUGH:g} % of paths optimal at {values}."


def _draw(found: Found, figure: Figure) -> None:
    """Regret over each quantity, a row a map."""
    figure.set_size_inches(9.0, 5.2)
    axes = figure.subplots(2, len(SWEEPS), sharey="row", squeeze=False)
    for row, name in zip(axes, (PARK, ANY), strict=True):
        row[0].set_ylabel(f"{name}\nmean regret (%)", fontsize=8)
        for ax, quantity in zip(row, SWEEPS, strict=True):
            for k, kind in enumerate(KINDS):
                _draw_sweep(found[name, kind, quantity], quantity, kind, COLOURS[k], ax)
            ax.set_xlabel(LABELS[quantity])
            if quantity != "temperature_c":
                ax.set_xscale("log")
        row[0].set_ylim(0.0, 1.05 * max(ax.dataLim.y1 for ax in row))
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)


def _draw_sweep(outcomes: Sequence[Outcome], quantity: str, kind: str, colour: str, ax: Axes) -> None:
    scale = 1e6 if quantity == "unit" else 1.0
    kept = [o for o in outcomes if np.isfinite(o.regret.value)]
    x = [scale * getattr(o.case, quantity) for o in kept]
    look = {"color": colour, "marker": "o", "markersize": 3, "capsize": 2, "label": f"{kind} biases"}
    draw_estimates(x, [o.regret for o in kept], look, ax, 100.0)
    ax.tick_params(colors=INK)


EXPERIMENT = Experiment(
    "hwu2018-campaign",
    "regret of the wavefront chip's paths over dies, area, temperature, speed, bias",
    reproduce,
    nulls=NULLS,
)
