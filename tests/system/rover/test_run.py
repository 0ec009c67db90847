"""The rover as a system: plan, drive, learn, summary and picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from circuits.errors import CircuitError, ParameterError
from system.plot import save_picture
from system.rover.body import Rover
from system.rover.drive import polyline
from system.rover.run import SUMMARY, SYSTEM, Trace, run, summarise
from system.rover.scenario import Scenario
from system.rover.wave_planner import ChipPlanner
from tests.refusals import refusals

EXACT = Rover(
    reach=2.0, gps_drift=0.0, gps_noise=0.0, outage_rate=0.0, outage_rate_covered=0.0, compass_bias=0.0,
    compass_noise=0.0, wheel_spread=0.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def trace() -> Trace:
    return run(Scenario(seed=3))


def test_the_default_route_takes_the_road(trace: Trace) -> None:
    path = trace.trips[0].plan.path
    assert set(trace.cost_map.costs[path[:, 0], path[:, 1]].tolist()) == {1}
    assert path[0].tolist() == [2, 10]
    assert path[-1].tolist() == [19, 10]


def test_ideal_cells_need_no_codes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A map whose chip would have to be calibrated first is planned on without one."""

    def none(*given: object, **more: object) -> None:
        raise AssertionError(given)

    monkeypatch.setattr(Scenario, "codes_of", none)
    assert run(SYSTEM.on_silicon(ideal=True, map="map1-road")).trips[0].plan.regret == 0


def test_the_summary(trace: Trace) -> None:
    found = summarise(trace)
    assert tuple(found) == tuple(SUMMARY)
    assert found["regret"] == 0.0
    assert found["cost"] == found["optimal_cost"] == 24.0
    assert found["map_error"] is None
    planned = polyline(trace.cost_map, trace.trips[0].plan.path)
    apart = [np.hypot(*(trace.trips[0].drive.place[k] - planned[k])) for k in (0, -1)]
    # a leash is never shorter than what separates the ends, and it starts at the start
    assert apart[0] == 0.0
    assert found["frechet_m"] is not None
    assert found["frechet_m"] >= apart[1]


def test_needs_change_the_way() -> None:
    speed = run(Scenario(map="map1-road", need="speed")).trips[0].plan
    energy = run(Scenario(map="map1-road")).trips[0].plan
    assert speed.length == 18  # straight south
    assert energy.length > speed.length
    assert energy.regret == speed.regret == 0


@pytest.mark.parametrize("rate", [1.0, 0.5])
def test_an_exact_rover_learns_what_it_drove_over_and_finds_the_road(rate: float) -> None:
    # where unknown cells are taken for cheap, every way that seems better is tried until none does
    found = run(Scenario(map="map1-road", learn=rate, prior=1.0, trips=40, rover=EXACT))
    regrets = [trip.plan.regret for trip in found.trips]
    assert regrets[0] == 26
    assert regrets[-5:] == [0] * 5


def test_the_learnt_map_converges_on_a_beaten_track() -> None:
    # with the paper's prior of 5 the first way is never left, and its cells are updated once a trip: at rate
    # 1/2 what is off by d at first is off by d 2^-n after n trips
    found = run(Scenario(map="map1-without-road", learn=0.5, trips=8, rover=EXACT))
    errors = [trip.map_error for trip in found.trips]
    paths = [trip.plan.path.tolist() for trip in found.trips]
    assert paths[0] == paths[-1]
    assert errors[0] == pytest.approx(1.0)
    assert errors[-1] == pytest.approx(2.0**-7, rel=1e-9)


def test_posts_stop_it_and_sonars_spare_it() -> None:
    blind = [run(Scenario(map="map2", posts=True, seed=k)) for k in range(6)]
    seeing = [run(Scenario(map="map2", posts=True, sonar=True, seed=k)) for k in range(6)]
    counts = [sum(t.trips[0].drive.interventions for t in traces) for traces in (blind, seeing)]
    assert counts[0] > counts[1]


def test_the_same_seed_is_the_same_run(trace: Trace) -> None:
    again = run(trace.scenario)
    assert np.array_equal(again.trips[0].drive.place, trace.trips[0].drive.place)
    other = run(replace(trace.scenario, seed=4))
    assert not np.array_equal(other.trips[0].drive.place[-1], trace.trips[0].drive.place[-1])


test_bad_scenarios_are_refused = refusals(
    CircuitError,
    lambda change: run(Scenario(**change)),
    [
        ({"trips": 0}, "trips: 0, must be >= 1"),
        ({"seed": -1}, "seed: -1"),
        ({"learn": 2.0}, "learn: 2"),
        ({"planner": "magic"}, "planner: magic, must be wave, paper"),
        ({"cells": "foam"}, "cells: foam, must be"),
        ({"need": "rest"}, "need: rest"),
        ({"start": (20, 0)}, "start: 20,0"),
        ({"map": "nowhere"}, "map nowhere: unknown"),
    ],
)


def test_a_goal_behind_a_wall_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "wall.txt"
    path.write_text("1 0 1\n1 0 1\n")
    with pytest.raises(ParameterError, match="must be reachable"):
        run(Scenario(map=str(path), start=(0, 0), goal=(0, 2)))


def test_it_draws(trace: Trace, tmp_path: Path) -> None:
    picture = tmp_path / "way.png"
    save_picture(str(picture), lambda figure: SYSTEM.draw(trace, figure))
    assert picture.stat().st_size > 10_000  # an empty figure has 3 kB


def test_a_plan_is_made_at_the_temperature_of_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    planned, seen = ChipPlanner.__call__, []

    def noted(planner: ChipPlanner, *asked: Any) -> Any:
        seen.append(planner.cells.silicon.temperature_c)
        return planned(planner, *asked)

    monkeypatch.setattr(ChipPlanner, "__call__", noted)
    found = run(Scenario(seed=3, cells="chip", trips=2, course=((0.0, 27.0), (1e3, 47.0))))
    first = float(found.trips[0].drive.time[-1])
    # within half of the step in which a course is followed
    assert seen == [27.0, pytest.approx(27.0 + 0.02 * first, abs=0.05 + 1e-9)]
    assert seen[1] > 27.0
