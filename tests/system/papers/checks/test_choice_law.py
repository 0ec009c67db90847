"""The experiment on the selection and the head under the full law: every row of it can fail."""

from __future__ import annotations

import math

import numpy as np

from system.papers.checks.choice_law import Beside, Decision, statements


def test_every_row_can_fail() -> None:
    decisions = (
        Decision((3, 4), np.array([1e-5, 1e-5]), 0.1),
        Decision((3, 3), np.array([1e-5, 1.04e-5]), 0.1),
        Decision((3, 3), np.array([1e-5, 1e-5]), 0.0),
    )
    delays = np.array([(math.nan, 1e-5), (1e-5, 1.1e-5)])
    wrong = Beside(decisions, (2, 3), np.array([(1e-3, 1.04e-3)]), delays, True, True, True)
    unknown = Beside(decisions, (2, 3), np.array([(1e-3, 1.04e-3)]), delays, True, False, False)
    rows = {row.name: row for row in statements([wrong, unknown])}
    assert rows["winner_share"].ours == 0.5
    assert rows["hears_share"].ours == 0.5
    assert rows["count_share"].ours == 0.0
    assert rows["count_undecided_share"].ours == rows["hears_undecided_share"].ours == 0.5
    assert not any(row.agrees for row in rows.values())
