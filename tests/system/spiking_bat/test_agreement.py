"""Kappa of tables whose kappa is known, its interval, and a chip that is asked what it was asked before."""

import numpy as np
import pytest

from system.openspace.law import MIDDLE, Bat, arcs_of
from system.spiking_bat.agreement import Recorder, cohens_kappa, confusion, group_of, kappa_interval, replayed
from system.spiking_bat.chip_brain import chip_brain
from system.spiking_bat.numbers import Numbers

ARCS, S = arcs_of(Bat(ping_rate=10.0)), Numbers()


def test_kappa_is_cohens() -> None:
    table = np.zeros((7, 7))
    table[:2, :2] = [[20, 5], [10, 15]]
    # p_o 0.7, p_e 0.5: the textbook's example
    assert cohens_kappa(table) == pytest.approx(0.4)
    assert cohens_kappa(np.diag([3.0, 4.0])) == 1.0
    assert cohens_kappa(np.diag([3.0, 0.0])) == 1.0


def test_the_interval_holds_kappa_and_narrows() -> None:
    random = np.random.default_rng(1)
    widths = []
    for count in (500, 5000):
        a = random.integers(0, 5, count)
        b = np.where(random.random(count) < 0.9, a, random.integers(0, 5, count))
        kappa, low, high = kappa_interval(a, b)
        # 0.9 agree, and a fifth of the others by chance
        assert low < kappa < high
        assert kappa == pytest.approx(0.9, abs=0.05)
        widths.append(high - low)
    assert widths[1] < 0.6 * widths[0]
    assert kappa_interval(np.zeros(10, int), np.zeros(10, int)) == (1.0, -1.0, 1.0)


def test_a_chip_that_hears_its_own_pings_answers_the_same() -> None:
    recorder = Recorder(chip_brain(ARCS, S))
    views = [np.array([[1.5, 0.1]]), np.array([[2.0, -0.3], [1.2, 0.8]]), np.empty((0, 2))]
    groups = [
        group_of(recorder.ping(head, MIDDLE, views[k % 3])) for k, head in enumerate((2, 1, 2, 3, 2, 2))
    ]
    again = replayed(chip_brain(ARCS, S), recorder.rows)
    assert again.tolist() == groups
    assert np.trace(confusion(again, np.array(groups))) == 6
