"""What the defaults move in every robot: rows of both silicons, and one robot that really runs."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from system.papers.checks import defaults
from system.registry import SYSTEMS, load_system
from system.study.campaign import Numbered


def outcome(key: Numbered) -> defaults.Outcome:
    """Number and success by the condition: what the defaults have is twice the paper's."""
    changed = key.condition.endswith("defaults")
    return defaults.Outcome(succeeded=changed or key.number != 1001, number=2.0 if changed else 1.0)


def test_every_robot_has_rows_that_tell_what_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(defaults, "run_one", outcome)
    report = defaults.reproduce(lambda _: None, dies=2)
    rows = {row.name: row for row in report.rows}
    assert set(defaults.ROBOTS) == set(SYSTEMS)
    assert len(rows) == 3 * len(SYSTEMS)
    error = rows["head_nominal_error_rms_deg"]
    assert (error.paper, error.shown, error.agrees) == (1.0, 2.0, None)
    assert error.rule.text == "moved by +1 (+100 %)"
    assert (rows["head_dies_succeed"].paper, rows["head_dies_succeed"].shown) == (0.5, 1.0)
    assert any(note.startswith("head: of 2 drawn dies succeed 1 (paper), ") for note in report.notes)
    figure = Figure()
    report.draw(figure)
    assert len(figure.axes[0].patches) == len(SYSTEMS) * len(defaults.WAYS)


@pytest.mark.parametrize("name", defaults.ROBOTS)
def test_a_robot_s_options_are_its_own_and_put_its_chips_into_the_loop(name: str) -> None:
    robot, system = defaults.ROBOTS[name], load_system(name)
    for way in defaults.WAYS.values():
        scenario = system.scenario(seed=1000, **{**robot.options, **robot.paper, **way})
        assert scenario.law == way.get("law", "ideal")
    assert robot.number in system.metrics


def test_a_car_runs_on_both_silicons() -> None:
    paper, ours = (defaults.run_one(Numbered(f"car, {way}", 1000)) for way in ("paper", "defaults"))
    assert paper.number is not None
    assert ours.number is not None
    assert paper != ours
