"""The experiment on the wavefront chip under the full law: every row of it can fail."""

from __future__ import annotations

import numpy as np

from system.papers.checks.wavefront_law import Axons, statements

CODES = np.array([1, 1, 1, 9])


def _axons(*model: float) -> Axons:
    circuit = np.array([1.0, 1.1, 1.3, 9.0])
    return Axons("gate", 27.0, CODES, circuit, np.array(model), np.full(3, 0.05))


def test_axons_of_one_code_contest_and_a_near_end_is_undecided() -> None:
    assert _axons(1.0, 1.2, 1.1, 9.0).contests() == [(True, True), (True, False)]
    assert _axons(1.0, 1.01, 1.2, 9.0).contests() == [(False, True), (True, True)]


def test_every_row_can_fail() -> None:
    found = [_axons(1.0, 1.2, 1.1, 9.0), _axons(1.0, 1.01, 1.2, 9.0)]
    wave = np.array([[0.0, 1.0]]), np.array([[0.0, 1.04]])
    rows = {row.name: row for row in statements(found, [(1.0, 1.06)], [wave])}
    assert rows["first_of_two_share"].ours == 2.0 / 3.0
    assert rows["undecided_share"].ours == 0.25
    assert rows["wave_error_max"].ours == np.float64(1.04) - 1.0
    assert not any(row.agrees for row in rows.values())
