"""By noctule's own controller a run step by step is the run that `run` makes; others steer in its place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.approach.run import run_in_loop
from system.forest.live import LiveForest
from system.play.run import LiveRun, open_robot, open_run
from system.registry import load_system, system_names
from tests.house import ROOT

OWN: dict[str, tuple[dict[str, Any], ...]] = {
    "forest": (
        {"pings": 60},
        {"pings": 60, "ranges": "sonar", "occlusion": True, "multipath": True},
        {"pings": 40, "ranges": "chip", "selection": "chip", "codes": "default"},
    ),
    "bug": ({"map": "bug-open", "seed": 0}, {"map": "bug-sealed", "agent": "bug1", "seed": 0}),
    "rover": ({}, {"posts": True, "sonar": True}),
    "car": ({"pings": 40}, {"pings": 40, "forest": "dense", "ranges": "exact"}),
    "head": ({"duration": 2.0, "codes": "default", "die": Die("A", 1001)},),
}


def played(name: str, given: dict[str, Any]) -> tuple[Any, Any, LiveRun]:
    """A run's trace and its system, and the same run step by step."""
    system = load_system(name)
    scenario = system.scenario(**{"seed": 1000, **given})
    run = LiveRun(open_robot(system, scenario))
    for _ in run:
        pass
    return system, system.run(scenario), run


def path_of(name: str, trace: Any) -> Any:
    """Where a run was, step by step."""
    if name == "rover":
        return trace.trips[0].drive.place[-1:]
    if name == "head":
        return np.stack([np.cos(trace.log.head), np.sin(trace.log.head)], axis=1)
    return trace.path


@pytest.mark.parametrize(("name", "given"), [(name, each) for name in OWN for each in OWN[name]])
def test_by_its_own_controller_a_run_is_the_run(name: str, given: dict[str, Any]) -> None:
    system, trace, run = played(name, given)
    path, way = path_of(name, trace), run.way[:, 1:]
    found = way[-1:] if name == "rover" else way[: len(path)]
    assert np.array_equal(found, path)
    assert run.over == system.account(trace).reason
    assert run.succeeded == system.account(trace).succeeded


def test_the_pushbot_on_its_chip_drives_as_in_a_run() -> None:
    _, trace, run = played("pushbot", {"duration": 0.3, "codes": "default", "die": Die("A", 1001)})
    assert np.array_equal(np.array(run.robot.drive.path), np.array(trace.drive.path))  # type: ignore[attr-defined]


def test_the_sonar_calls_as_in_a_run() -> None:
    system = load_system("approach")
    scenario = system.scenario(seed=1000, level="behavioural", duration=0.5)
    run = LiveRun(open_robot(system, scenario))
    for _ in run:
        pass
    calls = np.array(run.robot.log.calls)[:, 0]  # type: ignore[attr-defined]
    # the steps' ends thin lines elsewhere, within 1 mV of the proximity voltage
    assert np.allclose(calls, run_in_loop(scenario).calls[:, 0], atol=1e-3)


def test_the_robot_does_what_the_step_says() -> None:
    run = open_run("bug", map="bug-open", brain="reference", duration="100ms")
    for step in run:
        step.action = [0.0, 1.0]
    assert len(run.path) == 11
    assert run.over == "time of 0.1 s over"
    assert not run.succeeded


def test_a_controller_of_ones_own_is_asked_in_the_place_of_noctules() -> None:
    seen = []

    def to_the_goal(observation: Any) -> Any:
        seen.append(observation)
        return observation[9:11]

    run = open_run("bug", to_the_goal, map="bug-open", brain="reference")
    for _ in run:
        pass
    assert run.succeeded
    assert len(seen) == len(run.path) - 1


def test_a_forest_of_ones_own_is_flown_step_by_step(tmp_path: Any) -> None:
    file = tmp_path / "wall.csv"
    file.write_text("x_m,y_m\n" + "".join(f"30,{y}\n" for y in np.arange(0.0, 50.0, 0.5)))
    run = open_run(
        "forest", lambda _: [16, 2, 0], map=str(file), start=(40.0, 25.0), ranges="exact", selection="ideal"
    )
    for step in run:
        assert len(step.readings) >= 0
    assert run.over == "collided with an obstacle"
    assert run.way[-1, 1] == pytest.approx(30.3, abs=0.05)  # the zone of collision before the wall


def test_programs_stand_in_the_place_of_all_chips_where_that_is_asked_for() -> None:
    run = open_run("forest", seed=3, pings=2, ideal=True)
    assert isinstance(run.robot, LiveForest)
    assert run.robot.scenario.sensing.selection == "ideal"


def test_a_run_that_is_over_and_an_action_that_is_none_are_refused() -> None:
    run = open_run("bug", map="bug-open", brain="reference", duration="10ms")
    with pytest.raises(ParameterError, match=r"^bug\.action\[0\] \(steering vector.*\): 2 map units/s, must"):
        run.take([2.0, 0.0])
    run.take([0.0, 0.0])
    with pytest.raises(ParameterError, match=r"^bug: is over, time of 0\.01 s over; open another run$"):
        run.take([0.0, 0.0])


def test_a_system_without_runs_step_by_step_says_which_have_them() -> None:
    system = load_system("rolls")
    with pytest.raises(ParameterError, match="rolls: has no runs step by step, those that have are approach"):
        open_robot(system, system.scenario())


def test_every_robot_that_moves_has_runs_step_by_step() -> None:
    able = [name for name in system_names() if load_system(name).open is not None]
    assert set(OWN) | {"pushbot", "approach"} <= set(able)


@pytest.mark.parametrize("name", [*OWN, "pushbot"])
def test_observations_are_what_the_signals_say(name: str) -> None:
    system = load_system(name)
    robot = open_robot(system, system.scenario())
    seen = robot.sense()
    assert np.array_equal(robot.senses.checked(seen, name), seen)
    assert seen.shape == robot.senses.shape


def test_a_robot_of_ones_own_is_opened_from_its_file() -> None:
    path = f"{ROOT / 'examples' / 'light_seeker.py'}:Seeker"
    run = open_run(path, seed=1000)
    for step in run:
        assert step.observation.shape == (2,)
    assert run.over == "at the lamp"
    with pytest.raises(ParameterError, match=r"light_seeker\.py.*unexpected keyword argument 'sead'"):
        open_run(path, sead=1)


def test_outside_of_a_models_box_a_run_is_refused_or_warns() -> None:
    given: dict[str, Any] = {
        "seed": 1000,
        "ranges": "chip",
        "selection": "ideal",
        "codes": "default",
        "pings": 3,
    }
    with pytest.raises(ParameterError, match=r"ranging_chip\.temperature"):
        open_run("forest", **given, temperature_c=95.0)
    run = open_run("forest", **given, temperature_c=95.0, outside="warn")
    for _ in run:
        pass
    assert run.over
    assert any("ranging_chip" in sentence for sentence in run.cautions)
    assert open_run("forest", **given).cautions == ()


@pytest.mark.parametrize(
    ("system", "given", "told"),
    [
        ("car", {"forest": 3}, "forest: 3, must be a text"),
        ("bug", {"die": True}, "die: True, must be a Die"),
        ("bug", {"ideal": "yes"}, "ideal: 'yes', must be True or False"),
        (3, {}, "system: 3, must be a text"),
    ],
)
def test_what_is_of_another_kind_is_refused(system: str, given: dict[str, Any], told: str) -> None:
    with pytest.raises(ParameterError, match=told):
        open_run(system, **given)
