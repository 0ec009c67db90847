"""The environments of Gymnasium: its checker finds nothing, seeds make worlds, what is none is refused."""

from __future__ import annotations

import tomllib
from importlib.metadata import EntryPoint
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from circuits.errors import ParameterError
from system.gym.environment import Environment, in_units, normal_of
from system.gym.registration import IDS, id_of, register_all
from system.live.signals import Channel, Signals
from system.play.run import open_run
from tests.house import ROOT

QUICK = {"Approach": {"duration": 0.3}, "Head": {"duration": 1.0}}
ROBOTS = [name for name in IDS if name != "System"]


def made(name: str, **given: Any) -> Any:
    """An environment without Gymnasium's wrappers."""
    return gymnasium.make(f"system.gym:{id_of(name)}", **{**QUICK.get(name, {}), **given}).unwrapped


@pytest.mark.parametrize("name", ROBOTS)
def test_gymnasiums_checker_finds_nothing(name: str) -> None:
    environment = made(name, render_mode="rgb_array")
    check_env(environment)  # a warning is an error here
    assert environment.reset(seed=1)[0] in environment.observation_space


def test_a_picture_is_of_the_world() -> None:
    environment = made("Bug", render_mode="rgb_array", map="bug-open")
    environment.reset(seed=0)
    first = environment.render()
    for _ in range(50):
        environment.step([1.0, 0.0])
    assert first.shape == (480, 480, 3)
    assert first.dtype == np.uint8
    assert (first != environment.render()).any()


def test_a_seed_makes_the_world_of_a_run_and_without_one_the_next_is_drawn() -> None:
    environment = made("Forest")
    first, _ = environment.reset(seed=1000)
    run = open_run("forest", lambda _: [16, 2, 0], seed=1000, ranges="exact", selection="ideal")
    assert np.array_equal(first, run.look().observation)
    drawn = [environment.reset()[0] for _ in range(2)]
    environment.reset(seed=1000)
    again = [environment.reset()[0] for _ in range(2)]
    assert np.array_equal(drawn, again)
    assert not np.array_equal(drawn[0], drawn[1])


def test_a_run_is_terminated_by_its_end_and_truncated_by_its_time() -> None:
    environment = made("Bug", map="bug-open", duration="200ms")
    environment.reset(seed=0)
    for _ in range(20):
        _, reward, terminated, truncated, info = environment.step([1.0, 0.0])
    assert (terminated, truncated) == (False, True)
    assert info["ended"] == "time of 0.2 s over"
    assert not info["succeeded"]
    assert reward == pytest.approx(0.01)  # 10 ms at 1 map unit a second straight to the goal
    observation, info = environment.reset(seed=0, options={"duration": "100s"})
    assert set(info) == {"time_s"}
    terminated = False
    while not terminated:
        observation, reward, terminated, truncated, info = environment.step(observation[9:11])
    assert info["succeeded"]
    assert reward > 9.0


def test_actions_outside_of_their_space_are_refused_in_one_line() -> None:
    environment = made("Rover")
    environment.reset(seed=0)
    with pytest.raises(
        ParameterError, match=r"^noctule/Rover-v0\.action\[0\] \(turn rate.*\): 1\.5, must be"
    ) as told:
        environment.step([1.5])
    assert "\n" not in str(told.value)
    forest = made("Forest")
    with pytest.raises(ParameterError, match=r"the run is over; call reset$"):
        forest.step([16, 2, 0])
    forest.reset(seed=0)
    with pytest.raises(ParameterError, match=r"\[0\] \(arc, from the left\): 33, must be a whole number"):
        forest.step([33, 2, 0])
    with pytest.raises(ParameterError, match="render_mode: human, must be rgb_array"):
        Environment("bug", render_mode="human")


def test_the_senses_are_on_the_die_that_is_asked_for() -> None:
    given: dict[str, Any] = {"ideal": False, "selection": "ideal", "codes": "default"}
    seen = [made("Forest", die=die, **given).reset(seed=1001)[0] for die in (1001, 1001, 1002)]
    assert np.array_equal(seen[0], seen[1])
    assert not np.array_equal(seen[0], seen[2])


def test_several_environments_go_on_together() -> None:
    together = gymnasium.make_vec(f"system.gym:{id_of('Rover')}", num_envs=2, vectorization_mode="sync")
    observations, _ = together.reset(seed=5)
    alone = made("Rover").reset(seed=6)[0]
    assert np.array_equal(observations[1], alone)
    observations, rewards, _, _, _ = together.step(np.zeros((2, 1)))
    assert observations.shape == (2, alone.size)
    assert rewards.shape == (2,)
    together.close()


def test_any_system_is_an_environment_by_its_name() -> None:
    environment = made("System", system="bug", map="bug-cup")
    assert environment.reset(seed=0)[0].shape == environment.observation_space.shape


def test_a_robot_of_ones_own_is_an_environment_from_its_file() -> None:
    environment = made("System", system=f"{ROOT / 'examples' / 'light_seeker.py'}:Seeker")
    check_env(environment, skip_render_check=True)
    environment.reset(seed=1)
    assert environment.step([1.0, 1.0])[1] != 0.0


def test_gymnasiums_entry_point_registers_all_once() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (entry,) = project["entry-points"]["gymnasium.envs"].items()
    assert EntryPoint(*entry, group="gymnasium.envs").load() is register_all
    register_all()
    assert all(id_of(name) in gymnasium.registry for name in IDS)


def test_shares_of_bounds_are_in_the_units_of_the_channels() -> None:
    actions = Signals((Channel("volts", "V", 0.0, 5.0), Channel("turn", "rad/s", -0.8, 0.8)))
    assert in_units(actions, np.array([-1.0, 1.0])).tolist() == [0.0, 0.8]
    assert in_units(actions, np.array([0.0, -0.5])).tolist() == [2.5, -0.4]
    assert next(c.name for c in normal_of(actions).channels) == "volts, -1 for 0 to 1 for 5 V"
