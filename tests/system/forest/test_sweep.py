"""Statements about two configurations, and pictures of many."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from system.forest.campaign import Case, Limits, Tally
from system.forest.sweep import at_speeds, differs_row, draw_sweep, fly_sweep, line, lines
from system.openspace.flight import Sample
from system.openspace.law import Bat
from system.plot import save_picture
from system.study.campaign import ALONE


def tally(avoided: int, collisions: int) -> Tally:
    met = [Sample(avoided // max(collisions, 1), True, 10, 1.0, 1.0, 0, 1, 0, 0, 0)] * collisions
    none = [Sample(avoided, False, 10, 1.0, 1.0, 0, 3, 2, 0, 0)] * (not collisions)
    return Tally(Case(), (*met, *none))


@pytest.mark.parametrize(
    ("one", "other", "direction"),
    [
        ((1000, 100), (9000, 100), -1),
        ((9000, 100), (1000, 100), 1),
        ((1000, 10), (1100, 10), 0),
        ((9000, 0), (900, 90), 1),
    ],
)
def test_a_row_agrees_with_what_is_so_and_nothing_else(
    one: tuple[int, int], other: tuple[int, int], direction: int
) -> None:
    for claimed in (-1, 0, 1):
        row = differs_row("x", tally(*one), tally(*other), claimed, "control")
        assert row.agrees == (claimed == direction)


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
