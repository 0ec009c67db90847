"""Drives among many blocks: what is read off one, and what is compared between networks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from system.papers.milde2017 import clutter
from system.pushbot.body import SPEED_OF_FACTOR
from system.pushbot.campaign import Drive, Summary, drive_again
from tests.system.papers.conftest import Draw


@pytest.fixture(scope="module")
def driven() -> Summary:
    speed = clutter.SPEEDS[1] / SPEED_OF_FACTOR
    scenario = replace(clutter.NETWORKS["plain"], speed_factor=speed, duration=1.0, way=clutter.WAY)
    return clutter.outcome(drive_again(Drive(scenario)))


def test_a_drive_tells_where_it_was_and_what_it_touched(driven: Summary) -> None:
    assert driven["time_s"] == pytest.approx(1.0, abs=0.06)
    assert driven["path_m"] is not None
    assert driven["path_m"] == pytest.approx(driven["way_early_m"], rel=1e-6)
    assert driven["squares"] is not None
    assert 1.0 <= driven["squares"] <= 2.0 + driven["path_m"] / clutter.SQUARE
    assert (driven["touched_block"], driven["touched_wall"], driven["touched_early"]) == (0.0, 0.0, 0.0)


def test_networks_are_compared_scene_by_scene_and_by_the_metre(
    driven: Summary, drawn: Callable[[Draw], int]
) -> None:
    hit = {**driven, "collided": 1.0, "touched_block": 1.0, "touched_early": 1.0, "touched_visible": 1.0}
    cells = [(name, speed) for name in clutter.NETWORKS for speed in clutter.SPEEDS]
    found = {cell: [hit if cell[0] == "plain" else driven] * 12 for cell in cells}
    rows = {row.name: row for row in clutter.rows(found)}
    assert rows["collides_less_than_plain"].agrees
    assert not rows["collides_less_than_plain_turn_factor_1"].agrees
    told = clutter.notes(found)
    assert len(told) == len(cells)
    assert "collided 12 of 12" in told[0]
    assert drawn(lambda figure: clutter._draw(found, figure)) > 5_000
