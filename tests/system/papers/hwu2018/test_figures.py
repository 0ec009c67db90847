"""Tables and figures of Hwu et al. 2018 are made again, and every row agrees."""

from __future__ import annotations

import numpy as np

from chips.wavefront.paper_walk import plan_in_two_passes
from system.papers.hwu2018 import fig1 as hwu2018_fig1
from system.papers.hwu2018 import fig2 as hwu2018_fig2
from system.papers.hwu2018 import table1 as hwu2018_table1
from system.papers.hwu2018 import table2 as hwu2018_table2
from system.papers.hwu2018.table1 import Paths, rank_sum, signed_rank
from system.rover.cost_map import MAPS, load_map


def test_table_1_fails_where_the_wave_is_no_cheaper() -> None:
    same = dict.fromkeys(hwu2018_table1.PLANNERS, np.full(40, 12))
    rows = {row.name: row for row in hwu2018_table1.rows(dict.fromkeys(MAPS, Paths(same, same)))}
    assert not rows["map2_signed_rank_p"].agrees
    assert not rows["map2_rank_sum_p"].agrees
    assert rows["map2_wave_not_optimal"].agrees


def test_table_1_fails_where_the_wave_is_not_optimal() -> None:
    cost = dict.fromkeys(hwu2018_table1.PLANNERS, np.full(40, 12))
    cost["wave"] = np.arange(40)
    rows = {row.name: row for row in hwu2018_table1.rows(dict.fromkeys(MAPS, Paths(cost, cost)))}
    assert rows["map1-road_wave_not_optimal"].shown == 39.0
    assert not rows["map1-road_wave_not_optimal"].agrees


def test_the_tests_of_table_1() -> None:
    random = np.random.default_rng(0)
    low = random.integers(10, 30, 60)
    assert signed_rank(low, low) == 1.0
    assert signed_rank(low, low + random.integers(0, 3, 60)) < 1e-6
    assert signed_rank(low + 1, low) > 0.99
    # shifted by little, pairs tell what a rank sum of unpaired values does not
    assert rank_sum(low, low + 1) > 0.05


def test_table_2_fails_beyond_its_span() -> None:
    values = np.ones((6, 4))
    far = hwu2018_table2.Trials(
        (), frechet=26 * values, frechet_gps=values, interventions=values, arrived=values
    )
    rows = {row.name: row for row in hwu2018_table2.rows(dict.fromkeys(MAPS, far))}
    assert not rows["map2_frechet_m"].agrees
    assert not rows["interventions_a_trial_map2"].agrees  # as many on all maps
    assert rows["arrived_share"].agrees


def test_figure_1_fails_without_a_road() -> None:
    report = hwu2018_fig1.reproduce(lambda _: None)
    assert report.agrees
    plain = load_map("map1-without-road")
    wave = hwu2018_fig1.Wave(plain, plan_in_two_passes(plain.costs, hwu2018_fig1.START, hwu2018_fig1.GOAL))
    agrees = {row.name: row.agrees for row in hwu2018_fig1.rows(wave, wave)}
    assert agrees.pop("path_length_without_road")
    assert not any(agrees.values())


def test_figure_2_fails_where_the_second_pass_does_not_help() -> None:
    park = load_map("map1-road")
    short, long = np.array([[2, 10], [3, 10]]), np.array([[2, 10], [2, 11], [3, 10]])
    worse = hwu2018_fig2.Instance(park, short, long, 4)
    agrees = {row.name: row.agrees for row in hwu2018_fig2.rows([worse])}
    assert not any(agrees.values())
    better = hwu2018_fig2.Instance(park, long, short, 4)
    assert all(row.agrees for row in hwu2018_fig2.rows([better]))
    assert (better.saved, better.regret(long), better.regret(short)) == (1, 1, 0)
