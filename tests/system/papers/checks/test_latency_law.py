"""The experiment on the latency chip under the full law: every row of it can fail."""

from __future__ import annotations

from system.papers.checks.latency_law import TIMES, Beside, statements


def _beside(off: float, *, detected: bool, undecided: bool = False) -> Beside:
    times = tuple((name, off, 1.0) for name in (*TIMES, "tonic"))
    return Beside(27.0, times, ((True, True), (False, detected)), undecided)


def test_every_row_can_fail() -> None:
    found = [_beside(1.04, detected=True), _beside(1.0, detected=True, undecided=True)]
    rows = {row.name: row for row in statements(found)}
    assert rows["detection_share"].ours == 0.5
    assert rows["short_period_share"].ours == 0.5
    assert {row.agrees for name, row in rows.items() if name != "short_period_share"} == {False}


def test_a_chip_as_good_as_its_margins_agrees() -> None:
    rows = statements(500 * [_beside(1.02, detected=False)])
    assert {row.agrees for row in rows} == {True, None}
