"""Rover: a robot that plans its way on a cost map by a wave of spikes, and drives it (Hwu et al. 2018).

cost map -> axon delays of the cells -> wave from start to goal -> path -> GPS waypoints -> steering by
bearing minus heading. The wave runs on ideal cells, whose delay is the cost, or on a chip, a die with its
mismatch and temperature; conventional planners can take its place.

With a learning rate the map is not known beforehand: every cell's delay begins at `prior`, each trip is
planned on the delays as they stand, and after it the delay of each cell in which a fix lay moves towards
the mean of the costs that were sensed there, by equation (5). A plan is judged on the true map.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.wavefront.calibration import NAME, Design, cell_codes
from chips.wavefront.chip import ChipCells
from circuits.arrays import F64, I64
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront import cell as wavefront_cell
from circuits.errors import ParameterError
from circuits.silicon.course import along, beginning_of, told_when
from system.meaning import meanings, of_run
from system.options.block import describe_run
from system.options.codes import described
from system.options.noise import device_noise
from system.options.outside import inside_boxes
from system.options.temperature import temperature_text
from system.plot import INK, entitle, silicon_text, sized_axes
from system.rover.cost_map import Cell, CostMap, check_codes, for_need, load_map
from system.rover.drive import Drive, cell_at, drive, polyline, scatter_obstacles, set_out, turn_away
from system.rover.frechet import discrete_frechet
from system.rover.live import LiveRover
from system.rover.online_map import OnlineMap, unknown_map
from system.rover.picture import draw_map, draw_scale_bar, draw_ways, map_shapes
from system.rover.planner import Plan, Planner, plan_path, planner_named
from system.rover.scenario import Scenario, no_silicon
from system.rover.wave_planner import ChipPlanner
from system.spikes.output import spikes_output
from system.system import PROGRAMS, SUCCEEDED, Account, RunTrace, System, part
from system.view.film import Film, Shape, Stage, Track, circles, corners, signal
from system.worlds.standing import SLOW, evenly, share_standing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUMMARY = meanings("""
length         number   -  cells of the planned path
cost           number   -  sum of the costs of its cells
optimal_cost   number   -  least sum that any path has
regret         number   -  cost beyond the least
regret_share   number   -  the regret over the least cost
frechet_m      number   m  discrete Frechet distance of the driven from the planned path
frechet_gps_m  number   m  the same of the GPS's fixes from the planned path
time_s         number   s  time of the drive
distance_m     number   m  way driven
interventions  number   -  times that the rover had to be helped, of all trips
gps_outages    number   -  times that the GPS was silent, of all trips
arrived        number   -  1 where every trip arrived, else 0
map_error      number?  -  mean error of the learnt costs; null where nothing is learnt
""")  # of the last trip where not said otherwise
DOCUMENT = meanings("""
map                  string       -    name of the map
rows                 integer      -    rows of its cells, from the north
columns              integer      -    columns of its cells, from the west
cell_width_m         number       m    extent of a cell to the east
cell_height_m        number       m    extent of a cell to the north
planned_path         integer[][]  -    row and column of each cell of the last trip's path
time_s               number[]     s    times of the last drive
driven_path_m        number[][]   m    its places at these times, east and north
gps_path_m           number[][]   m    where the GPS said that they were
blocked_m            number       m    way of the last drive over blocked cells, which bind the plan alone
trips                object[]     -    each trip
trips.planned_path   integer[][]  -    row and column of each cell of its path
trips.length         integer      -    cells of the path
trips.cost           integer      -    sum of their costs
trips.regret         integer      -    cost beyond the least
trips.interventions  integer      -    times that the rover had to be helped
trips.arrived        boolean      -    whether it arrived
trips.map_error      number?      -    mean error of the learnt costs after it
""")
SUCCESS = "on every trip a fix lies within the rover's reach of the goal before its patience is over"


LONGEST = 20.0  # m in a second, beyond which a rover was put back to its start; ours


@dataclass(frozen=True, slots=True)
class Trip:
    """One plan and the drive along it.

    map_error : mean error of the learnt delays after the trip, NaN where nothing is learnt.
    """

    plan: Plan
    drive: Drive
    map_error: float


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """What a run leaves: the map as the need sees it, and all trips.

    Attributes
    ----------
    cost_map : CostMap
        The true map, as the need sees it.
    trips : tuple of Trip
        Plan and drive of every trip, in their order.
    waves : tuple of array
        When every cell of the chip fired in each trip's wave, float64[rows, columns] each, s after the trip
        began, inf where it did not; empty without a chip.
    """

    cost_map: CostMap
    trips: tuple[Trip, ...]
    waves: tuple[F64, ...] = field(default=(), repr=False)


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Plan and drive every trip of a scenario; `progress` is told the share that is done."""
    cost_map = for_need(load_map(scenario.map), scenario.need)
    planner = planner_of(scenario, cost_map)
    learnt = None
    if scenario.learn is not None:
        learnt = unknown_map(cost_map.costs, scenario.prior, scenario.learn)
    trips: list[Trip] = []
    at = _followed(scenario, cost_map, planner)
    for k in range(scenario.trips):
        time = sum(float(trip.drive.time[-1]) for trip in trips)
        planner = at(k, time)
        with told_when(time) if scenario.course else nullcontext():
            trips.append(_trip(scenario, cost_map, planner, learnt, k))
        if progress is not None:
            progress((k + 1) / scenario.trips)
    waves = planner.arrivals if isinstance(planner, ChipPlanner) else ()
    return Trace(scenario, cost_map, tuple(trips), tuple(waves))


def planner_of(scenario: Scenario, cost_map: CostMap) -> Planner:
    """Return the planner that a scenario asks for.

    Raises `UnknownNameError` for a planner, and `ParameterError` for cells, for a chip without a wave, and
    for a map that has no codes on it.
    """
    planner = planner_named(scenario.planner)
    if scenario.cells == "ideal":
        return planner
    if scenario.planner != "wave":
        raise ParameterError(
            f"cells: chip, must be ideal with `planner={scenario.planner}`; a chip runs a wave"
        )
    check_codes(cost_map)
    begin = beginning_of(scenario.temperature_c, scenario.course)
    return ChipPlanner(cells_of(scenario, cost_map, begin), scenario.unit)


def cells_of(scenario: Scenario, cost_map: CostMap, temperature_c: float) -> ChipCells:
    """Return the cells of a scenario's die at a temperature, degC, for a map.

    Raises `ParameterError` for silicon or codes that there are none of.
    """
    design = Design(cost_map.shape, scenario.unit)
    codes = scenario.codes_of(NAME, setup=design)
    calibrated = None if codes is None else cell_codes(codes, design)
    silicon = scenario.silicon_at(temperature_c)
    noise = device_noise(scenario)
    return ChipCells(silicon, scenario.bias_kind, noise=noise, calibrated=calibrated)


def _followed(scenario: Scenario, cost_map: CostMap, planner: Planner) -> Callable[[int, float], Planner]:
    """The planner of a trip by its number and time, s: of a chip with its cells at their temperature then."""
    if not isinstance(planner, ChipPlanner):
        return lambda _number, _time: planner
    cells = along(scenario.course, scenario.temperature_c, partial(cells_of, scenario, cost_map))
    return lambda number, time: replace(planner, number=number, cells=cells(time))


def _trip(
    scenario: Scenario, cost_map: CostMap, planner: Planner, learnt: OnlineMap | None, number: int
) -> Trip:
    """One trip, with noise of its own; what it sensed is learnt at its end."""
    sensed: dict[Cell, list[int]] = {}

    def sense(under: Cell, reckoned: Cell) -> None:
        sensed.setdefault(reckoned, []).append(int(cost_map.costs[under]))

    plan = _planned(scenario, cost_map, planner, learnt)
    posts = scatter_obstacles(cost_map, (scenario.seed,)) if scenario.posts else ()
    avoid = turn_away(scenario.rover, posts) if scenario.sonar else None
    key = scenario.seed, number
    driven = drive(scenario.rover, cost_map, plan.path, key, posts, visit=sense, avoid=avoid)
    if learnt is None:
        return Trip(plan, driven, math.nan)
    for cell, costs in sensed.items():
        learnt.learn(cell, sum(costs) / len(costs))
    return Trip(plan, driven, learnt.error(cost_map.costs))


def _planned(scenario: Scenario, cost_map: CostMap, planner: Planner, learnt: OnlineMap | None) -> Plan:
    """The plan of a trip, on what is known of the map."""

    def on_what_is_known(costs: I64, start: Cell, goal: Cell) -> I64 | None:
        return planner(costs if learnt is None else learnt.codes(), start, goal)

    return plan_path(cost_map, scenario.start, scenario.goal, on_what_is_known)


def open_drive(scenario: Scenario) -> LiveRover:
    """Return the rover of a scenario at the start of its planned way, which goes on by 0.1 s.

    Raises `ParameterError` for several trips, and what `run` raises.
    """
    if scenario.trips != 1:
        raise ParameterError(
            f"trips: {scenario.trips}, must be 1 in a run step by step; open a run for each trip"
        )
    cost_map = for_need(load_map(scenario.map), scenario.need)
    learnt = None
    if scenario.learn is not None:
        learnt = unknown_map(cost_map.costs, scenario.prior, scenario.learn)
    plan = _planned(scenario, cost_map, planner_of(scenario, cost_map), learnt)
    posts = scatter_obstacles(cost_map, (scenario.seed,)) if scenario.posts else ()
    voyage = set_out(scenario.rover, cost_map, plan.path, (scenario.seed, 0))
    return LiveRover(voyage, plan, posts, turn_away(scenario.rover, posts) if scenario.sonar else None)


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a run by their names; None where a number is not defined.

    They are those of the last trip, but interventions and outages of the GPS are summed over all trips.
    """
    trip = trace.trips[-1]
    plan, driven = trip.plan, trip.drive
    planned = polyline(trace.cost_map, plan.path)
    error = trip.map_error
    return {
        "length": float(plan.length),
        "cost": float(plan.cost),
        "optimal_cost": float(plan.optimal_cost),
        "regret": float(plan.regret),
        "regret_share": plan.regret / plan.optimal_cost,
        "frechet_m": discrete_frechet(planned, driven.place),
        "frechet_gps_m": discrete_frechet(planned, driven.fix),
        "time_s": float(driven.time[-1]),
        "distance_m": driven.distance,
        "interventions": float(sum(t.drive.interventions for t in trace.trips)),
        "gps_outages": float(sum(t.drive.outages for t in trace.trips)),
        "arrived": float(all(t.drive.arrived for t in trace.trips)),
        "map_error": None if math.isnan(error) else error,
    }


def account(trace: Trace) -> Account:
    """Say whether a run succeeded, why it ended, and what it ran on.

    Way and standing are those of the last trip; a run succeeds where all trips arrive.
    """
    s, driven = trace.scenario, trace.trips[-1].drive
    on: dict[str, Any] = {"planner": s.planner, "cells": s.cells}
    if s.cells == "chip":
        on |= {
            **described(s),
            "unit_s": s.unit,
            "silicon_noise": s.silicon_noise,
            **describe_run(s),
        }
    path = evenly(driven.time, driven.place, s.rover.gps_period)
    return Account(
        succeeded=all(t.drive.arrived for t in trace.trips),
        reason=_reason(trace),
        ran_on=on,
        parts=_parts(s),
        distance_m=driven.distance,
        standing_share=share_standing(path, SLOW * s.rover.speed),
        outside=trace.outside,
    )


def _parts(scenario: Scenario) -> dict[str, str]:
    """What plans and what drives."""
    cells = part(scenario.cells, "wavefront chip", {"ideal": "ideal cells"})
    return {
        "planning": cells if scenario.planner == "wave" else f"program {scenario.planner}, as asked for",
        "fixes, steering and wheels": PROGRAMS,
    }


def _reason(trace: Trace) -> str:
    """Why the last trip ended; of several trips how many arrived too."""
    s, last = trace.scenario, trace.trips[-1].drive
    why = f"time of {last.time[-1]:.0f} s over"
    if last.arrived:
        why = f"goal reached: a fix within {s.rover.reach:g} m of it"
    if len(trace.trips) == 1:
        return why
    arrived = sum(t.drive.arrived for t in trace.trips)
    return f"{why}; arrived on {arrived} of {len(trace.trips)} trips"


def draw(trace: Trace, figure: Figure) -> None:
    """Fill `figure` with the map and the last trip's planned and driven way."""
    (rows, columns), cells = trace.cost_map.shape, trace.cost_map
    shape = rows * cells.cell_height / (columns * cells.cell_width)
    ax = sized_axes(figure, 6.4, min(max(5.0 * shape + 1.4, 3.4), 9.4))
    trip = trace.trips[-1]
    draw_map(trace.cost_map, figure, ax)
    draw_ways(polyline(trace.cost_map, trip.plan.path), [trip.drive.place], ax, trace.scenario.rover.reach)
    ax.plot(
        *trip.drive.fix[-1], marker="+", color=INK, markersize=7, linestyle="", zorder=4, label="last fix"
    )
    draw_scale_bar(trace.cost_map, ax)
    ax.set_xlabel("east (m)")
    ax.set_ylabel("north (m)")
    s = trace.scenario
    title = f"{trace.cost_map.name}, {s.planner}: {trip.plan.length} cells, cost {trip.plan.cost}"
    on = silicon_text(s.die, s.temperature_c, s.bias_kind, s.course, s.law)
    chip = "" if s.cells == "ideal" else f", {on}"
    entitle(f"{title}{chip}\n{account(trace).headline}", ax)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)


def film(trace: Trace, _: tuple[str, ...] | None) -> Film:
    """Return the film of all trips, one after the other: the map, what was planned and what was driven."""
    cells, trips = trace.cost_map, trace.trips
    ways = [polyline(cells, trip.plan.path) for trip in trips]
    lengths = [float(trip.drive.time[-1]) + 1.0 for trip in trips]
    begun = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    time = np.concatenate([b + trip.drive.time for b, trip in zip(begun, trips, strict=True)])
    place, fix = (np.concatenate([getattr(t.drive, name) for t in trips]) for name in ("place", "fix"))
    shapes = map_shapes(cells) + [
        Shape(role="way", points=corners(w), closed=False, name="planned") for w in ways
    ]
    reach = trace.scenario.rover.reach
    shapes += circles("goal", ways[0][-1:], reach, f"arrived with a fix within {reach:g} m")
    shapes += circles("start", ways[0][:1])
    rover = Track(name="rover", time=time, x=place[:, 0], y=place[:, 1], radius=1.0, longest=LONGEST)
    told = (
        signal("distance to the goal", "m", time, np.hypot(*(place - ways[0][-1]).T), "distance"),
        signal("error of the GPS", "m", time, np.hypot(*(fix - place).T), "last fix"),
    )
    stage = Stage(unit="m", shapes=tuple(shapes), tracks=(rover,))
    return Film(title="", headline="", duration=float(time[-1]), world=stage, panels=told)


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys.

    The planned and the driven way are those of the last trip.
    """
    last = trace.trips[-1]
    return {
        "map": trace.cost_map.name,
        "rows": trace.cost_map.shape[0],
        "columns": trace.cost_map.shape[1],
        "cell_width_m": trace.cost_map.cell_width,
        "cell_height_m": trace.cost_map.cell_height,
        "planned_path": last.plan.path,
        "time_s": last.drive.time,
        "driven_path_m": last.drive.place,
        "gps_path_m": last.drive.fix,
        "blocked_m": over_blocked(trace),
        "trips": [_described(trip) for trip in trace.trips],
    }


def _described(trip: Trip) -> dict[str, Any]:
    return {
        "planned_path": trip.plan.path,
        "length": trip.plan.length,
        "cost": trip.plan.cost,
        "regret": trip.plan.regret,
        "interventions": trip.drive.interventions,
        "arrived": trip.drive.arrived,
        "map_error": trip.map_error,
    }


def over_blocked(trace: Trace) -> float:
    """Return the way of the last drive that leads over blocked cells, m."""
    place = trace.trips[-1].drive.place
    middle = 0.5 * (place[1:] + place[:-1])
    cells = [cell_at(trace.cost_map, east, north) for east, north in middle]
    blocked = np.array([trace.cost_map.costs[cell] == 0 for cell in cells], dtype=np.bool_)
    return float(np.hypot(*(place[1:] - place[:-1]).T)[blocked].sum())


def told(trace: Trace) -> Iterator[str]:
    """Return the last planned way, and a line for each trip where there are several."""
    way = " ".join(f"{row},{column}" for row, column in trace.trips[-1].plan.path.tolist())
    yield f"planned on {trace.cost_map.name}: {way}"
    blocked = over_blocked(trace)
    if blocked > 0.0:
        yield f"driven over blocked cells: {blocked:.1f} m; they bind the plan, and nothing stands there"
    for k, trip in enumerate(trace.trips if len(trace.trips) > 1 else ()):
        plan = trip.plan
        costs = f"length {plan.length}, cost {plan.cost}, regret {plan.regret}"
        yield f"trip {k}: {costs}, map error {trip.map_error:.3g}"


def spike_trains(trace: Trace) -> tuple[dict[str, F64], float]:
    """Return the spikes of all cells in the waves of all trips, s, and the end of the last trip, s.

    Raises `ParameterError` for a run without a chip.
    """
    if not trace.waves:
        raise ParameterError("spikes: only those of a chip are recorded; run it on one")
    lasted = [float(trip.drive.time[-1]) for trip in trace.trips]
    begins = np.cumsum([0.0, *lasted[:-1]])
    fired = np.stack([begin + wave for begin, wave in zip(begins, trace.waves, strict=True)], axis=-1)
    cells = ((f"cell[{row},{column}]", fired[row, column]) for row, column in np.ndindex(fired.shape[:2]))
    return {name: times[np.isfinite(times)] for name, times in cells}, sum(lasted)


def title(trace: Trace) -> str:
    """Return the heading of the table of a run's numbers."""
    s = trace.scenario
    die = "" if s.cells == "ideal" else f", {temperature_text(s.temperature_c, s.course)} degC, {s.die}"
    return f"{s.planner} on {s.cells} cells{die}"


def usual(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the option with which the wave runs over a chip; other planners have none."""
    return {"cells": "chip"} if given.get("planner", "wave") == "wave" else {}


SYSTEM = System(
    name="rover",
    summary="rover that plans by a wave of spikes on a cost map, drives by GPS (Hwu et al. 2018)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    yes_no=(SUCCEEDED, "arrived"),
    study_metrics=("regret_share", "frechet_m"),
    usual=usual,
    ideal={"cells": "ideal"},
    no_silicon=no_silicon,
    open=open_drive,
    document=document,
    meanings=of_run(SUMMARY, DOCUMENT),
    title=title,
    before=told,
    outputs={"spikes": spikes_output("the spikes of the wavefront chip", spike_trains, no_silicon)},
    circuits=lambda: (axon_delay.build(), wavefront_cell.build()),
)
