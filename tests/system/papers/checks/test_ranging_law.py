"""The experiment on the ranging chip under the full law: one die of it, and rows that can fail."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from system.papers.checks.ranging_law import Beside, compare, statements
from system.papers.checks.ranging_law import _draw as draw


def _beside(circuit: str, model: str, t_inh: float = 1.0, best_delay: float = 1.0) -> Beside:
    return Beside("gate", 27.0, circuit, model, (1.0, t_inh), (1.0, best_delay))


def test_a_die_is_within_every_margin() -> None:
    found = compare((1003,))
    assert len(found) == 6
    assert any(b.circuit == "works" for b in found)
    rows = {row.name: row for row in statements(found)}
    assert all(row.agrees for row in rows.values())
    figure = Figure()
    draw(found, figure)
    assert figure.axes[0].lines


def test_every_row_can_fail() -> None:
    wrong = [_beside("works", "never", t_inh=1.04), _beside("works", "works", best_delay=0.96)]
    rows = {row.name: row for row in statements([*wrong, _beside("works", "undecided", 1.0, math.nan)])}
    assert rows["class_share"].ours == 0.5
    assert not any(row.agrees for row in rows.values())
