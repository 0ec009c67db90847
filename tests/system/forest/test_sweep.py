"""Statements about two configurations, and pictures of many."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from system.forest.campaign import COLLISIONS, Case, Limits, Tally, equivalent_p
from system.forest.sweep import (
    MARGIN,
    NULLS,
    Sweep,
    at_speeds,
    differs_row,
    draw_sweep,
    fly_sweep,
    line,
    lines,
    sweep_nulls,
)
from system.openspace.flight import Sample
from system.openspace.law import Bat
from system.plot import save_picture
from system.statement import Statement
from system.study.campaign import ALONE
from system.study.statistics.power import detectable_ratio


def tally(avoided: int, collisions: int) -> Tally:
    met = [Sample(avoided // max(collisions, 1), True, 10, 1.0, 1.0, 0, 1, 0, 0, 0)] * collisions
    none = [Sample(avoided, False, 10, 1.0, 1.0, 0, 3, 2, 0, 0)] * (not collisions)
    return Tally(Case(), (*met, *none))


@pytest.mark.parametrize(
    ("one", "other", "direction"),
    [
        ((1000, 100), (9000, 100), -1),
        ((9000, 100), (1000, 100), 1),
        ((100_000, 1000), (101_000, 1000), 0),
        ((9000, 0), (900, 90), 1),
    ],
)
def test_a_row_agrees_with_what_is_so_and_nothing_else(
    one: tuple[int, int], other: tuple[int, int], direction: int
) -> None:
    for claimed in (-1, 0, 1):
        row = differs_row("x", tally(*one), tally(*other), claimed, "control")
        assert row.agrees == (claimed == direction)


def test_what_is_not_told_apart_is_not_yet_alike() -> None:
    few = differs_row("x", tally(1000, 10), tally(1100, 10), 0, "control")
    assert not few.agrees
    assert "within a factor of 1.34" in few.rule.text
    assert "not told apart" in str(differs_row("x", tally(1000, 10), tally(1100, 10), 1, "control").shown)


def test_the_margin_is_what_the_papers_test_finds_in_four_of_five_cases() -> None:
    assert pytest.approx(detectable_ratio(1.0, 1.0, 2 * COLLISIONS), abs=0.005) == MARGIN


def test_two_means_are_alike_where_their_90_percent_interval_is_within_the_factor() -> None:
    one, other = tally(20_000, 200), tally(20_000, 200)
    # of equal means the error of the logarithm of their ratio is 0.1, and 1.645 of it are 5 %
    assert equivalent_p(one, other, math.exp(0.1645)) == pytest.approx(0.05, abs=0.01)
    assert equivalent_p(one, other, 2.0) < 1e-6
    assert equivalent_p(one, tally(40_000, 200), 1.5) > 0.9
    assert equivalent_p(tally(50, 0), tally(50, 0), 1.5) == 1.0


def test_nulls_of_a_sweep_keep_what_is_flown_and_lose_what_it_says() -> None:
    found = {("a", 1.0): tally(1000, 100), ("b", 1.0): tally(9000, 100), ("c", 1.0): tally(90_000, 100)}

    def rows(flown: Sweep) -> tuple[Statement, ...]:
        return (
            differs_row("b_over_a", flown["b", 1.0], flown["a", 1.0], 1, "a"),
            differs_row("c_over_b", flown["c", 1.0], flown["b", 1.0], 1, "b"),
        )

    alike, drawn = sweep_nulls(rows, found)
    assert (alike.name, drawn.name) == NULLS
    assert [row.agrees for row in alike.rows] == [False, False]
    assert "90 against 90" in str(alike.rows[0].shown)
    assert sum(row.agrees is True for row in drawn.rows) == 1  # of the six orders, that of the median


def test_a_line_says_what_was_censored() -> None:
    assert "0 collisions, 1 samples without one, 10 pings, trapped 2 times" in line(tally(50, 0))
    assert "without one" not in line(tally(50, 5))


def test_a_sweep_and_its_picture(tmp_path: Path) -> None:
    fractions: list[float] = []
    bats = {"quick": Bat(), "slow": Bat(ping_rate=2.0)}
    found = fly_sweep(ALONE, "ours", at_speeds(bats, (3.0, 6.0)), Limits(3, 20_000, 0), fractions.append)
    assert list(found) == [("quick", 3.0), ("quick", 6.0), ("slow", 3.0), ("slow", 6.0)]
    assert found["slow", 6.0].case.bat == Bat(max_speed=6.0, ping_rate=2.0)
    assert fractions == [0.25, 0.5, 0.75, 1.0]
    assert len(lines(found)) == 4
    picture = tmp_path / "sweep.png"

    def draw(figure: Figure) -> None:
        draw_sweep({**found, ("none", 3.0): tally(500, 0)}, figure.subplots())

    save_picture(str(picture), draw)
    assert picture.stat().st_size > 10_000  # an empty figure has 3 kB
