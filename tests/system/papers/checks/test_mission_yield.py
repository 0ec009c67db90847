"""Yield of every robot: rows with their rules, nulls by the same rules, and one robot that really runs."""

from __future__ import annotations

from dataclasses import replace

import pytest
from matplotlib.figure import Figure

from circuits.errors import SolverError
from system.papers.checks import mission_yield
from system.registry import SYSTEMS, load_system
from system.study.campaign import Numbered


def outcome(key: Numbered) -> mission_yield.Outcome:
    """Calibrated dies do as the program does; of the others and the warm ones every second fails."""
    works = "calibrated" in key.condition or "ideal" in key.condition or key.number % 2 == 0
    if not works and "default" in key.condition:
        return mission_yield.Outcome(succeeded=False, failed="it is deaf")
    return mission_yield.Outcome(works, 1.0 if works else 0.1, 0.0, 80.0)


def test_rows_hold_where_calibrated_dies_do_as_the_program_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mission_yield, "run_one", outcome)
    report = mission_yield.reproduce(lambda _: None, dies=4)
    rows = {row.name: row for row in report.rows}
    assert set(mission_yield.ROBOTS) == set(SYSTEMS)
    assert rows["approach_calibrated_succeed"].agrees is True
    assert rows["forest_calibrated_avoided"].agrees is True
    assert rows["head_calibrated_succeed"].agrees is True  # whose number has no rule
    assert rows["car_17_C_succeed"].agrees is False  # a half, of which 0.8 was to be left
    assert rows["rover_calibrated_regret_share"].agrees is False  # 1, and a hundredth is allowed
    idle, usual = report.nulls
    assert {row.name: row.agrees for row in idle.rows}["car_calibrated_succeed"] is False
    assert {row.name: row.agrees for row in usual.rows}["approach_calibrated_succeed"] is False
    figure = Figure()
    report.draw(figure)
    assert len(figure.axes[0].patches) == len(SYSTEMS) * len(mission_yield.WAYS)


def test_a_die_on_which_a_circuit_does_not_work_is_one_that_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_: object) -> None:
        raise SolverError("bias generator: no operating point")

    rover = load_system("rover")
    monkeypatch.setattr(mission_yield, "load_system", lambda _: replace(rover, run=broken))
    found = mission_yield.run_one(Numbered("rover, calibrated", 5000))
    assert (found.succeeded, found.failed) == (False, "bias generator: no operating point")


@pytest.mark.parametrize("name", mission_yield.ROBOTS)
def test_a_robot_s_number_is_its_own_and_its_chips_have_codes(name: str) -> None:
    robot, system = mission_yield.ROBOTS[name], load_system(name)
    assert robot.number in {*system.metrics, ""}
    assert "codes" in system.settings
    assert system.on_silicon(seed=5000, **robot.options).die.number == 1000


def test_a_rover_on_a_die_and_as_a_program() -> None:
    ours, ideal = (mission_yield.run_one(Numbered(f"rover, {way}", 900)) for way in ("calibrated", "ideal"))
    assert (ours.succeeded, ideal.succeeded, ideal.number) == (True, True, 0.0)
