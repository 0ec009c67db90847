"""Rows of the chip's experiments say yes and no where they should."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from system.papers.checks import nef_chip
from system.papers.stockel2017 import chip as stockel2017_chip
from system.papers.stockel2017.drive import kept, program
from tests.system.papers.conftest import Draw


def test_small_ones_measure() -> None:
    assert abs(nef_chip.rate_errors(3001, 27.0, "gate", (0.25,))[0]) < nef_chip.CLOSE
    few, many = nef_chip.error(30, 3001), nef_chip.error(300, 3001)
    assert many < few / 2.0  # ten times the neurons: a third, on one die
    own, other = nef_chip.own_and_other(3001)
    assert own < other


def test_rows_of_the_chip() -> None:
    sizes = nef_chip.SIZES
    error = 1.0 / np.sqrt(np.array(sizes))[:, None] * np.ones((1, 3))
    good = nef_chip.Found(np.full((2, 3, 2, 5), 0.01), error, np.full(4, 1e-3), np.full(4, 5e-3))
    assert [r.agrees for r in nef_chip.rows(good)] == [True] * 3
    bad = nef_chip.Found(np.full((2, 3, 2, 5), -0.04), error**2, np.full(4, 1e-3), np.full(4, 2e-3))
    assert [r.agrees for r in nef_chip.rows(bad)] == [False] * 3


def test_rows_of_the_robots(drawn: Callable[[Draw], int]) -> None:
    there, around = (
        kept(program(world, 140.0), with_path=True)
        for world in (stockel2017_chip.FIELD, stockel2017_chip.SPIRAL)
    )
    stuck = replace(there, reached=False)

    def found(share: int) -> stockel2017_chip.Found:
        mixed = [there] * share + [stuck] * (20 - share)
        made = dict.fromkeys(stockel2017_chip.AGENTS, mixed)
        made[stockel2017_chip.SPIRAL, "bug0", "published"] = [around] * 20
        made[stockel2017_chip.FIELD, "bug2", "published"] = [there] * 8 + [stuck] * 12
        return made

    assert [r.name for r in stockel2017_chip.rows(found(19)) if r.agrees is False] == []
    wrong = [r.name for r in stockel2017_chip.rows(found(17)) if r.agrees is False]
    assert wrong == [
        "fig6_bug2_improved_reaches_share",
        "fig8_bug0_reaches_share",
        "fig8_bug2_improved_reaches_share",
    ]
    assert drawn(lambda figure: stockel2017_chip._draw(found(19), 140.0, figure)) > 10_000
