"""The learning experiment, small."""

from matplotlib.figure import Figure

from chips.rolls.setups.learning import Task
from system.papers.checks import rolls_learning


def test_one_short_lesson_is_reported_and_drawn(monkeypatch):
    monkeypatch.setattr(rolls_learning, "SILENCE", 1.0)
    monkeypatch.setattr(rolls_learning, "GROUPS", ("neurons",))
    task = Task(training=4, tests=2)
    report = rolls_learning.reproduce(lambda _: None, dies=1, gate_dies=0, pairs=1, task=task)
    named = {row.name: row for row in report.rows}
    assert named["share of weights unchanged after 100 s of silence"].shown == 1.0
    assert len([name for name in named if name.startswith("the same, mismatch of")]) == 2
    assert all(0.0 <= float(row.shown) <= 1.0 for row in report.rows)
    report.draw(Figure())


def test_an_agreement_counts_events():
    found = rolls_learning.agreement(3, 27.0)
    assert 0 < found.alike <= found.events == 50
    assert found.error <= found.worst
