"""Figures of Wen & Horiuchi 2022 are made with few samples; their rows say no where a claim is not so."""

from __future__ import annotations

import numpy as np

from system.forest.campaign import Case, Tally
from system.forest.coverage import Coverage
from system.openspace.flight import Sample
from system.openspace.law import Bat
from system.papers.wen2022 import fig5 as wen2022_fig5
from system.papers.wen2022 import fig10 as wen2022_fig10
from system.papers.wen2022 import fig11a as wen2022_fig11a
from system.papers.wen2022 import fig11b as wen2022_fig11b
from system.papers.wen2022 import fig11c as wen2022_fig11c
from system.papers.wen2022 import fig11d as wen2022_fig11d
from system.papers.wen2022 import fig11e as wen2022_fig11e


def tally(mean: int, collisions: int = 100) -> Tally:
    return Tally(Case(), (Sample(mean, True, 1, 0.0, 0.0, 0, 1, 0, 0, 0),) * collisions)


def test_figure_5_fails_in_another_scene() -> None:
    clear = [(ahead, left + 20.0) for ahead, left in wen2022_fig5.OBSTACLES]
    rows = {row.name: row for row in wen2022_fig5.reproduce(lambda _: None, clear).rows}
    assert not rows["ping_1_detected"].agrees
    assert not rows["ping_1_head_turns_to"].agrees
    assert not rows["ping_2_body_turns"].agrees


def test_figure_10_fails_on_a_beaten_track() -> None:
    gaps = frozenset((0, k) for k in range(1, 101))
    few = wen2022_fig10.rows(Coverage(gaps, {(0, k): 50 for k in range(1, 6)}))
    most = wen2022_fig10.rows(Coverage(gaps, {(0, k): 50 for k in range(1, 61)}))
    assert [row.agrees for row in few] == [False, False]
    assert [row.agrees for row in most] == [True, True]


def test_figure_11a_wants_a_steep_fall() -> None:
    steep = wen2022_fig11a.rows({500: tally(5000), 1100: tally(900), 1700: tally(200)})
    flat = wen2022_fig11a.rows({500: tally(500), 1100: tally(480), 1700: tally(460)})
    assert [row.agrees for row in steep] == [True] * 3
    assert [row.agrees for row in flat] == [False] * 3


def test_figure_11b_wants_each_term_where_the_paper_has_it() -> None:
    means = {"control": (500, 500), "no hysteresis": (500, 250), "no ping-direction bias": (900, 250)}
    found = {(n, v): tally(m) for n, both in means.items() for v, m in zip((1.0, 2.0), both, strict=True)}
    assert all(row.agrees for row in wen2022_fig11b.rows(found))
    same = dict.fromkeys(found, tally(500))
    wrong = [row.name for row in wen2022_fig11b.rows(same) if not row.agrees]
    assert wrong == ["no_hysteresis_at_2", "no_ping-direction_bias_at_1", "no_ping-direction_bias_at_2"]


def test_figure_11c_wants_each_function() -> None:
    way = np.linspace(0.0, 5.0, 101)
    same = dict.fromkeys(wen2022_fig11c.groups(Bat()), 10.0 * (1.0 - way / 5.0))
    wrong = [row.name for row in wen2022_fig11c.rows(way, same) if not row.agrees]
    assert "control_largest_difference" not in wrong
    assert {"Steep_largest_difference", "steep_beyond_3_m", "squared_emphasises_close"} <= set(wrong)


def test_figure_11d_wants_an_order() -> None:
    means = {"control": 900, "Steep": 100, "Flat": 600, "Squared": 300}
    found = {(n, 2.0): tally(m) for n, m in means.items()}
    assert all(row.agrees for row in wen2022_fig11d.rows(found))
    swapped = {**found, ("Steep", 2.0): tally(600), ("Flat", 2.0): tally(100)}
    assert not any(row.agrees for row in wen2022_fig11d.rows(swapped) if "squared" in row.name)


def test_figure_11e_wants_a_slower_decline() -> None:
    means = {"5 Hz": (500, 50), "10 Hz": (900, 300)}
    found = {(n, v): tally(m) for n, both in means.items() for v, m in zip((2.0, 4.0), both, strict=True)}
    assert all(row.agrees for row in wen2022_fig11e.rows(found))
    faster = {**found, ("10 Hz", 4.0): tally(60)}
    assert not wen2022_fig11e.rows(faster)[-1].agrees
    unsure = {**found, ("10 Hz", 2.0): Tally(Case(), (Sample(900, False, 1, 0.0, 0.0, 0, 1, 0, 0, 0),))}
    assert not wen2022_fig11e.rows(unsure)[-1].agrees
