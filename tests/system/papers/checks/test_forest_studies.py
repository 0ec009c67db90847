"""Studies of the forest with chips and with weights by speed: made with few samples, shares by hand."""

from __future__ import annotations

import math

import pytest

from system.forest.campaign import Case, Tally
from system.openspace.flight import Sample
from system.papers.checks.forest_silicon import BATS, Study, ranging_share, rows


def tally(mean: int, collisions: int = 100) -> Tally:
    return Tally(Case(), (Sample(mean, True, 10, 0.0, 0.0, 0, 1, 0, 0, 0, heard=9, missed=1),) * collisions)


def four(*means: int) -> dict[str, Tally]:
    return {name: tally(mean) for name, mean in zip(BATS, means, strict=True)}


def test_the_share_of_ranging() -> None:
    # ranging costs a factor 4 alone and 2 after the selection, the selection 4 alone: of ln 8 it has ln 8 / 2
    share, interval = ranging_share(four(800, 200, 200, 100))
    assert share == pytest.approx(math.log(4 * 2) / (2 * math.log(8)))
    assert interval.low <= share <= interval.high
    assert ranging_share(four(800, 100, 800, 100))[0] == pytest.approx(1.0)
    assert ranging_share(four(800, 800, 100, 100))[0] == pytest.approx(0.0)


def test_what_silicon_ought_to_do() -> None:
    def study(least: int, cold: int, ranging: int) -> Study:
        good, bad = four(800, ranging, 700, 500), four(800, 100, 700, cold)
        area = {1.0: four(800, 100, 700, least), 64.0: good}
        kinds = {("gate", t): bad if t != 27.0 else good for t in (10.0, 27.0, 44.0)}
        return Study(area, kinds)  # type: ignore[arg-type]

    assert all(row.agrees for row in rows(study(90, 80, 600)))
    wrong = [row.name for row in rows(study(500, 500, 300)) if not row.agrees]
    assert len(wrong) == 4
    assert wrong[0] == "nominal_die_ranging_over_exact"
