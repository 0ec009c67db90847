"""The experiment on the ranging chip under the full law: every row of it can fail."""

from __future__ import annotations

import math

import numpy as np

from system.papers.checks.ranging_law import Beside, statements


def _beside(circuit: str, model: str, t_inh: float = 1.0, best_delay: float = 1.0) -> Beside:
    return Beside("gate", 27.0, circuit, model, np.array([1.0, t_inh]), np.array([1.0, best_delay]))


def test_every_row_can_fail() -> None:
    wrong = [_beside("works", "never", t_inh=1.04), _beside("works", "works", best_delay=0.96)]
    rows = {row.name: row for row in statements([*wrong, _beside("works", "undecided", 1.0, math.nan)])}
    assert rows["class_share"].ours == 0.5
    assert not any(row.agrees for row in rows.values())
