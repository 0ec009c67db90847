"""Experiments on Milde et al. 2017: all are known, small ones run, and their rules can fail."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from system.papers.milde2017 import clutter as milde2017_clutter
from system.papers.milde2017 import fig5 as milde2017_fig5
from system.papers.milde2017 import moving as milde2017_moving
from system.papers.milde2017 import office as milde2017_office
from system.papers.milde2017 import pairs as milde2017_pairs
from system.papers.milde2017 import table1 as milde2017_table1
from system.papers.milde2017 import target as milde2017_target
from system.papers.milde2017 import variability as milde2017_variability
from system.papers.milde2017.avoided import avoided
from system.pushbot.campaign import Summary
from system.pushbot.course import Errand, stood
from system.pushbot.drive import begin_run
from system.pushbot.network.biases import LEVELS
from system.pushbot.network.plain import pushbot_network
from system.pushbot.run import Trace
from system.pushbot.scenario import Scenario, scene_of
from system.pushbot.wiring import HALF_ROWS
from system.study.statistics.share import Share
from system.worlds.arena.geometry import obstacles_of, outline_at
from system.worlds.camera.sensor import Dvs, open_eye, picture, sensor_of


def test_figure_5_agrees_and_sees_a_wrong_sign() -> None:
    good = milde2017_fig5.rows(pushbot_network(levels=LEVELS))
    assert all(row.agrees for row in good)
    wrong = milde2017_fig5.rows(pushbot_network(levels=replace(LEVELS, obstacle_to_speed=2)))
    assert not wrong[0].agrees


def cell(colour: str, factors: tuple[float, float], distance: float, passed: int) -> milde2017_table1.Cell:
    return milde2017_table1.Cell(colour, factors, distance, 1.0, 20, Share(passed, 20))


def test_table_1_judges_the_paper_s_own_numbers_as_right_and_constant_ones_as_wrong() -> None:
    paper = {
        (colour, f): cell(colour, f, d, 20 if d == 0.0 or colour == "yellow" else 0)
        for colour, distances in milde2017_table1.PAPER.items()
        for f, d in zip(milde2017_table1.CELLS, distances, strict=True)
    }
    assert all(row.agrees for row in milde2017_table1.rows(paper))
    flat = {key: cell(*key, 10.0, 0) for key in paper}
    wrong = {row.name for row in milde2017_table1.rows(flat) if not row.agrees}
    assert {"blue_3/1_collided", "yellow_collided", "blue_turn_1_over_0.5_cm"} <= wrong


def summaries(**values: list[float]) -> list[Summary]:
    size = len(next(iter(values.values())))
    return [{name: value[k] for name, value in values.items()} for k in range(size)]


def test_pairs_fail_above_five_percent() -> None:
    good = summaries(collided=[0.0] * 20, crossed=[1.0] * 20, between=[0.0] * 20)
    bad = summaries(collided=[1.0] * 2 + [0.0] * 18, crossed=[1.0] * 20, between=[0.0, 0.0] + [1.0] * 18)
    for name in milde2017_pairs.AROUND:
        assert all(row.agrees for row in milde2017_pairs.rows({name: good}))
        assert not any(row.agrees for row in milde2017_pairs.rows({name: bad}))


def test_between_the_blocks_of_the_loose_triple_there_is_room() -> None:
    between = summaries(collided=[0.0] * 20, crossed=[1.0] * 20, between=[1.0] * 20)
    assert all(row.agrees for row in milde2017_pairs.rows({"triple-loose": between}))


def test_variability_needs_both_sides() -> None:
    both, one = summaries(passed=[1.0, -1.0] * 5), summaries(passed=[1.0] * 10)
    assert all(r.agrees for r in milde2017_variability.rows({"die 1000": both, "other dies": both}))
    assert not any(r.agrees for r in milde2017_variability.rows({"die 1000": one, "other dies": one}))


@pytest.mark.parametrize("factor", milde2017_moving.FACTORS)
def test_the_cup_stands_in_the_way_where_a_straight_robot_would_have_gone_0_8_m(factor: float) -> None:
    scenario = Scenario(scene="moving", speed_factor=factor)
    obstacles = obstacles_of(milde2017_moving.pushed(scenario))
    cup = next(k for k, b in enumerate(scene_of(scenario).bodies) if b.motion is not None)
    there = 0.8 / (0.7 * factor)  # 0.7 m/s at factor 1
    y = [outline_at(obstacles, cup, t).centroid.y for t in (there - 0.1, there, there + 5.0)]
    assert y == pytest.approx([0.98, 1.0, 1.0], abs=1e-3)


def test_a_moving_cup_may_cost_five_points() -> None:
    none, ten, few = (summaries(collided=[1.0] * k + [0.0] * (200 - k)) for k in (0, 10, 2))
    assert [r.agrees for r in milde2017_moving.rows({"0.5": (few, none), "1": (ten, none)})] == [True, False]
    # as many of few runs do not show it
    assert not milde2017_moving.rows({"0.5": (none[:20], none[:20])})[0].agrees


def clutter(plain: list[Summary], modified: list[Summary]) -> milde2017_clutter.Found:
    return {
        (name, speed): modified if name == "modified" else plain
        for name in milde2017_clutter.NETWORKS
        for speed in milde2017_clutter.SPEEDS
    }


def test_clutter_is_paired() -> None:
    usual = {"touched_visible": [0.0] * 10, "touched_early": [0.0] * 10, "path_m": [4.0] * 10}
    usual["time_s"] = [10.0] * 10
    hit, free = summaries(collided=[1.0] * 10, **usual), summaries(collided=[0.0] * 10, **usual)
    better = {row.name: row.agrees for row in milde2017_clutter.rows(clutter(hit, free))}
    assert better["collides_less_than_plain"]
    # what comes after the time that is compared does not count
    assert not better["collides_less_than_plain_in_40_s"]
    assert not milde2017_clutter.rows(clutter(hit, hit))[0].agrees
    assert not milde2017_clutter.rows(clutter(free, hit))[0].agrees


def test_clutter_tells_standing_still_from_avoiding() -> None:
    usual = {"touched_visible": [0.0] * 10, "touched_early": [0.0] * 10, "time_s": [10.0] * 10}
    # 10 collisions each: in 10 m of the plain network, in 60 m of the modified one; binomial, p below 1e-4
    slow = summaries(collided=[1.0] * 10, path_m=[1.0] * 10, **usual)
    fast = summaries(collided=[1.0] * 10, path_m=[6.0] * 10, **usual)
    agrees = {row.name: row.agrees for row in milde2017_clutter.rows(clutter(slow, fast))}
    assert agrees["collisions_a_metre_than_plain"]
    assert not agrees["collides_less_than_plain"]
    assert agrees["modified_moves_at_0.5_m_per_s"]
    assert not agrees["plain_moves_at_0.5_m_per_s"]
    path = np.zeros((201, 4))
    path[:, 0] = 5e-3 * np.arange(201)
    path[:101, 1] = 0.5 * path[:101, 0]
    path[101:, 1] = path[100, 1]
    # half of a second at 0.5 m/s, the other half at rest
    assert stood(path) == pytest.approx(0.5, abs=0.1)
    assert milde2017_clutter.way_until(path, 0.25) == pytest.approx(0.125)
    assert milde2017_clutter.way_until(path, 9.0) == pytest.approx(0.25)


def test_a_run_out_of_time_counts_as_far_as_it_went() -> None:
    # of four robots one stops after 1 m, then one of the other three touches at 2 m: a third of the rest
    runs = summaries(collided=[0.0, 1.0, 0.0, 0.0], path_m=[1.0, 2.0, 12.0, 12.0])
    ways, left = milde2017_clutter.kept(runs)
    assert ways.tolist() == [0.0, 1.0, 2.0, 12.0]
    assert left == pytest.approx([1.0, 1.0, 2.0 / 3.0, 2.0 / 3.0])


def test_a_robot_that_turns_in_one_place_is_on_few_squares() -> None:
    angle = np.linspace(0.0, 20.0 * np.pi, 4001)
    circles = np.column_stack([angle, 0.5 + 0.05 * np.cos(angle), 0.5 + 0.05 * np.sin(angle), angle])
    ahead = np.column_stack([angle, 0.05 + 0.05 * angle, np.full_like(angle, 0.5), 0.0 * angle])
    assert milde2017_clutter.squares(circles) == 1.0
    assert milde2017_clutter.squares(ahead) == 16.0


def test_office_counts_by_the_minute() -> None:
    few = summaries(collided=[1.0, 0.0, 0.0, 0.0], walked_into=[0.0] * 4, time_s=[60.0] * 4)
    many = summaries(collided=[1.0] * 20, walked_into=[0.0] * 20, time_s=[4.0] * 20)
    kicked = summaries(collided=[1.0] * 20, walked_into=[1.0] * 20, time_s=[4.0] * 20)
    assert milde2017_office.rows({"normal": few, "dark": many})[0].agrees
    assert not milde2017_office.rows({"normal": many, "dark": few})[0].agrees
    # what walks into the robot is no crash of its own, but its time counts
    crashes, minutes = milde2017_office.crashes_in(kicked)
    assert crashes == 0
    assert minutes == pytest.approx(20 * 4.0 / 60.0)
    interval = milde2017_office.poisson(1, 4.0)
    # Garwood's interval of one event: 0.0253 to 5.572
    assert (interval.low, interval.high) == pytest.approx((0.0253 / 4, 5.572 / 4), rel=1e-2)


def test_an_office_run_begins_free_at_a_place_of_its_seed() -> None:
    starts = {milde2017_office.started(Scenario(scene="office", seed=seed)).start for seed in (1, 2, 1)}
    assert len(starts) == 2
    obstacles = obstacles_of(scene_of(Scenario(scene="office")))
    assert all(milde2017_office.is_free(obstacles, start) for start in starts)
    # the wall at x = 6 m is nearer than a metre
    assert not milde2017_office.is_free(obstacles, (5.3, 2.2, 0.0))


@pytest.mark.parametrize(("heading", "walked_into"), [(0.0, False), (0.5 * math.pi, True), (math.pi, True)])
def test_a_leg_beside_or_behind_the_robot_has_walked_into_it(heading: float, walked_into: bool) -> None:
    scene = scene_of(Scenario(scene="office"))
    leg = next(b for b in scene.bodies if b.name == "person[0].left")
    # the leg's middle 10 cm ahead along x
    drive = begin_run(replace(scene, start=(leg.at[0] - 0.10, leg.at[1], heading)), seed=0)
    drive.touched = leg.name
    trace = Trace(Scenario(), Errand(scene, None, 1.0), None, drive, None)  # type: ignore[arg-type]
    assert milde2017_office.is_walked_into(trace) is walked_into
    drive.touched = "wall"
    assert not milde2017_office.is_walked_into(trace)


def test_every_wall_and_box_of_the_office_shows_an_edge_to_a_robot_that_stands_before_it() -> None:
    # 12 cm before the lens the floor's edge has left the picture: what is smooth there makes no event
    sensor, up = sensor_of(Dvs(), scene_of(Scenario(scene="office"))), 0.5 * math.pi
    walls = [(5.84, 0.1 * k, 0.0) for k in range(3, 38)]
    for x, y, heading in ((2.2, 0.55, -up), (0.54, 3.0, math.pi), (2.0, 3.84, up), *walls):
        seen = picture(sensor, open_eye(sensor, 0, (x, y, heading)))[:HALF_ROWS]
        steps = np.abs(np.diff(np.log(seen), axis=1))
        assert steps.max() > Dvs().threshold_off, (x, y)


def test_the_target_is_reached_or_not() -> None:
    there = summaries(reached=[1.0] * 10, touched_robot=[0.0] * 10, touched_block=[0.0] * 10)
    away = summaries(reached=[0.0] * 10, touched_robot=[0.0] * 10, touched_block=[1.0] * 10)
    assert all(row.agrees for row in milde2017_target.rows(there, there))
    assert not any(row.agrees for row in milde2017_target.rows(away, away))


def test_a_robot_that_stands_avoids_nothing() -> None:
    runs = summaries(collided=[0.0, 0.0, 1.0], crossed=[0.0, 1.0, 1.0])
    assert avoided({"one": runs}) == {"one": Share(1, 3)}
