"""The experiment on the selection and the head under the full law: every row of it can fail."""

from __future__ import annotations

import math

from chips.selection.measure import Pair
from system.papers.checks.choice_law import Heard, statements


def test_every_row_can_fail() -> None:
    pairs = [
        Pair(0, 3, 1e-5, 4, 1e-5, 0.1),
        Pair(0, 3, 1e-5, 3, 1.04e-5, 0.1),
        Pair(0, 3, 1e-5, 3, 1e-5, 0.0),
    ]
    wrong = Heard((2, 3), [(1e-3, 1.04e-3)], [(math.inf, 1e-5), (1e-5, 1.1e-5)], hears=True)
    rows = {row.name: row for row in statements(pairs, [wrong])}
    assert rows["winner_share"].ours == 0.5
    assert rows["hears_share"].ours == 0.5
    assert not any(row.agrees for row in rows.values())
