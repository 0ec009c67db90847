"""Figure 15 of Wen & Horiuchi 2022, in small: its rows, and their rules."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from system.car.run import ENDS
from system.car.world import FORESTS
from system.papers.wen2022 import fig15 as wen2022_fig15
from system.papers.wen2022.fig15 import Drive, Found, drive_one, note, rows, summed
from system.study.campaign import Numbered
from tests.system.papers.conftest import Draw


@pytest.fixture(scope="module")
def first() -> Found:
    return summed([drive_one(Numbered("corridor, exact ranges", wen2022_fig15.FIRST_SEED))])


def made(first: Found, collided: int, side: float) -> Found:
    ends = {**dict.fromkeys(ENDS, 0), "collided": collided, "through": 100 - collided}
    spread = 0.01 * np.random.default_rng(0).standard_normal(100)
    return replace(first, ends=ends, side=side + spread)


def test_a_share_is_told_with_its_exact_interval(first: Found) -> None:
    # Clopper and Pearson's of 100 of 100 begins at 0.025^(1/100) = 0.96378
    assert note("open, flight", made(first, 0, 0.1)).startswith("open, flight: 100 of 100 (96 to 100 %) free")


def test_it_agrees_where_the_runs_do(first: Found) -> None:
    good = {name: made(first, 5, side) for name, side in zip(FORESTS, (0.1, 0.4, 0.5), strict=True)}
    assert all(row.agrees for row in rows(good))
    assert [row.name for row in rows(good) if not row.fitted] == ["open_side_pings", "dense_side_pings"]
    worse = {**good, "dense": made(first, 11, 0.5)}
    assert [row.name for row in rows(worse) if not row.agrees] == ["dense_collision_free"]
    even = {**good, "open": made(first, 5, 0.1)}
    assert [row.name for row in rows(even) if not row.agrees] == ["open_side_pings"]


def test_nulls_are_of_runs_in_any_forest() -> None:
    sides = dict(zip(FORESTS, (0.05, 0.5, 0.6), strict=True))
    flown = {name: [Drive("through", side + 0.001 * k) for k in range(30)] for name, side in sides.items()}
    nulls = wen2022_fig15._nulls(flown)
    assert tuple(null.name for null in nulls) == wen2022_fig15.EXPERIMENT.nulls
    ours = sum(bool(row.agrees) for row in rows({name: summed(each) for name, each in flown.items()}))
    collides, stands, drawn = (sum(bool(row.agrees) for row in null.rows) for null in nulls)
    assert (ours, collides, stands) == (6, 1, 3)
    assert 3 <= drawn < ours


def test_it_draws(first: Found, drawn: Callable[[Draw], int]) -> None:
    found = dict.fromkeys(FORESTS, first)
    assert drawn(lambda figure: wen2022_fig15._draw(found, figure)) > 20_000
