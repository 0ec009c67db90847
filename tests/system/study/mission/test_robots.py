"""Every robot of ours can be on a mission: its worlds and its noise have seeds of their own."""

import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.options.noise import device_noise
from system.registry import SYSTEMS, load_system
from system.study.mission.mission import NOISE_SEED, Asked, mission_of
from system.study.plan import WORLDS, seeds_of
from system.study.target import SystemTarget, open_target


@pytest.mark.parametrize("name", sorted(SYSTEMS))
def test_a_robot_has_worlds_and_noise_of_a_die(name: str) -> None:
    mission = mission_of(Asked(name, dies=2, worlds=2, trials=2))
    (way,) = mission.ways
    assert mission.definition == load_system(name).success
    assert (mission.runs, way.bias_kind) == (8, "generator")
    target = open_target(way.study.subject)
    assert isinstance(target, SystemTarget)
    seeds = [target.seeds(Die(number=1000 + k), trial) for k in range(2) for trial in range(4)]
    assert seeds[0] == {"seed": 1000 * WORLDS, NOISE_SEED: 1000 * WORLDS**2}
    assert len({each["seed"] for each in seeds}) == 4
    assert len({each[NOISE_SEED] for each in seeds}) == 8


@pytest.mark.parametrize("name", ["approach", "rover", "spiking-bat", "rolls"])
def test_noise_is_drawn_from_its_own_seed(name: str) -> None:
    system = load_system(name)
    fields = {"die": Die(number=1000), "seed": 3}
    fields |= {} if name not in {"rover", "spiking-bat"} else dict(system.usual(fields))
    own = device_noise(system.scenario(**fields, noise_seed=5))
    assert own == device_noise(system.scenario(**{**fields, "seed": 5}))
    assert own != device_noise(system.scenario(**fields))
    with pytest.raises(ParameterError, match="noise_seed: 5, there is no noise"):
        system.scenario(**fields, noise_seed=5, silicon_noise="off")


def test_seeds_go_through_worlds_and_runs_in_each() -> None:
    assert [seeds_of(7, trial, 2) for trial in range(3)] == [
        (7000, 7_000_000), (7000, 7_000_001), (7001, 7_001_000),
    ]  # fmt: skip
    assert seeds_of(7, 2, 1) == (7002, None)


def test_a_robot_without_a_chip_has_no_mission() -> None:
    with pytest.raises(ParameterError, match="mission: no chip is in the loop"):
        mission_of(Asked("car", options={"ranges": "exact"}))


def test_usual_changes_follow_from_what_a_robot_has() -> None:
    def changes(name: str, **asked: object) -> list[str]:
        made = mission_of(Asked(name, changes=("usual",), **asked))  # type: ignore[arg-type]
        return [way.change for way in made.ways if way.change]

    assert changes("forest") == ["area=4", "bias-kind=ideal"]
    assert changes("approach", options={"codes": "default"}) == ["codes=calibrated", "bias-kind=ideal"]
    assert changes("approach", temperatures_c=(47.0,)) == ["calibrated-at=47degC", "bias-kind=ideal"]
