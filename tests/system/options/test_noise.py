"""Noise of a system's chips: on unless a run is asked to be without, chosen by the seed."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from chips.noise import SiliconNoise
from chips.rolls.layout import ZETA
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.approach import run as approach
from system.bug import run as bug
from system.car import run as car
from system.car.sonar import _ranges
from system.cli.command_line import main
from system.forest import run as forest
from system.head import run as sonar_head
from system.openspace.senses import Sensing
from system.options.noise import NOISELESS, check_noise, device_noise
from system.pushbot import run as pushbot
from system.pushbot.campaign import drive_each
from system.pushbot.drive import begin_run
from system.pushbot.loop import Brain, open_loop
from system.rolls.run import SYSTEM, run
from system.rolls.scenario import Scenario
from system.spiking_bat import run as spiking_bat
from system.spiking_bat.run import account
from system.worlds.arena.file import load_scene

RUN = ["run", "approach", "--level", "behavioural", "--duration", "0.4s", "--json"]


@pytest.fixture
def spikes(capsys: pytest.CaptureFixture[str]) -> Callable[..., list[Any]]:
    def run(*options: str) -> list[Any]:
        assert main([*RUN, *options]) == 0
        return [s["time_s"] for s in json.loads(capsys.readouterr().out)["spikes"]]

    return run


def test_another_seed_is_another_run_of_the_same_die(spikes: Callable[..., list[Any]]) -> None:
    plain = spikes("--die", "1000", "--seed", "1", "--silicon-noise", "off")
    assert spikes("--die", "1000", "--seed", "2", "--silicon-noise", "off") == plain
    noisy = spikes("--die", "1000", "--seed", "1")
    assert spikes("--die", "1000", "--seed", "1", "--silicon-noise", "all") == noisy
    others = [
        spikes("--die", "1000", "--seed", "2", "--silicon-noise", "all"),
        spikes("--die", "1000", "--seed", "1", "--silicon-noise", "white"),
        plain,
    ]
    assert all(other != noisy for other in others)
    # before the first call that differs by more than jitter, spikes move by tens of microseconds
    assert noisy[0] == pytest.approx(plain[0], abs=100e-6)


def test_a_rover_plans_anew_every_trip(capsys: pytest.CaptureFixture[str]) -> None:
    route = ["run", "rover", "--cells", "chip", "--die", "1000", "--trips", "6", "--json"]
    found = {}
    for noise in ("off", "all"):
        assert main([*route, "--silicon-noise", noise, "--seed", "5"]) == 0
        document = json.loads(capsys.readouterr().out)
        assert document["silicon_noise"] == noise
        found[noise] = [trip["planned_path"] for trip in document["trips"]]
    assert all(path == found["off"][0] for path in found["off"])
    # jitter of microseconds decides only where two ways are as close: the cost of the way stays
    assert all(path[0] == found["off"][0][0] for path in found["all"])


def test_a_pushbots_chip_has_noise_of_its_own() -> None:
    def spikes(**fields: Any) -> list[float]:
        brain = pushbot.make_brain(pushbot.Scenario(scene="pair", **fields))
        loop = open_loop(brain, begin_run(load_scene("pair", seed=3), seed=3), pushbot.Scenario().read())
        return [*loop.state.values[ZETA]]

    plain, noisy = spikes(silicon_noise="off"), spikes(silicon_noise="all", noise_seed=1)
    assert spikes(silicon_noise="all", seed=1) == noisy
    assert plain != noisy != spikes(silicon_noise="all", noise_seed=2)


def test_a_campaign_makes_a_chip_for_each_noise() -> None:
    base = pushbot.Scenario(scene="pair", duration=0.05, silicon_noise="off")
    noisy = replace(base, silicon_noise="all", noise_seed=1)
    made: list[SiliconNoise | None] = []

    def make(scenario: pushbot.Scenario) -> Brain:
        made.append(device_noise(scenario))
        return pushbot.make_brain(scenario)

    asked = [base, noisy, base, replace(noisy, noise_seed=2), noisy]
    spikes = drive_each(asked, keep=lambda t: {"v": float(t.drive.pose[0])}, make=make)
    assert len(spikes) == len(asked)
    assert sorted(map(repr, made)) == sorted(map(repr, (None, SiliconNoise(1), SiliconNoise(2))))


def test_rolls_rates_differ_with_the_seed_of_its_noise() -> None:
    quiet = Scenario(duration=0.2)
    found = [run(replace(quiet, silicon_noise=noise)).spikes.times for noise in ("white", "all")]
    assert found[0].size != found[1].size or (found[0] != found[1]).any()
    assert SYSTEM.study_options("behavioural", None, {"silicon_noise": "all"})["silicon_noise"] == "all"
    with pytest.raises(ParameterError, match="silicon_noise: loud, must be off, white or all"):
        replace(quiet, silicon_noise="loud")


def test_a_bug_robots_chip_has_noise_of_its_own() -> None:
    asked = bug.Scenario(
        agent="bug0", brain="chip", neurons=600, map="bug-cup", duration=1.0, silicon_noise="off"
    )
    quiet = bug.run(asked).path
    noisy = [bug.run(replace(asked, silicon_noise="all", noise_seed=seed)).path for seed in (1, 1, 2)]
    assert (noisy[0] == noisy[1]).all()
    assert (noisy[0] != noisy[2]).any()
    assert (noisy[0] != quiet).any()
    fields = bug.SYSTEM.study_options("behavioural", None, {"silicon_noise": "white", "noise_seed": "3"})
    assert device_noise(bug.Scenario(**fields)) == SiliconNoise(3, flicker=WHITE_ONLY)


def test_a_latency_chips_recall_has_noise(capsys: pytest.CaptureFixture[str]) -> None:
    flight = ["run", "spiking-bat", "--brain", "chip", "--pings", "12", "--seed", "900", "--json"]
    found = {}
    for noise in ("off", "all"):
        assert main([*flight, "--silicon-noise", noise]) == 0
        document = json.loads(capsys.readouterr().out)
        assert document["silicon_noise"] == noise
        found[noise] = document["path_m"]
    assert found["all"] != found["off"]
    # microseconds of jitter move a turn by less than it takes to reach another arc
    assert found["all"][3] == pytest.approx(found["off"][3], abs=0.05)


def test_a_forests_selection_has_noise() -> None:
    """The same forest and die: noise moves the microseconds that decisions take."""
    die = Die("A", 1004)
    found = []
    for options in (
        {"silicon_noise": "off"},
        *({"silicon_noise": "white", "noise_seed": k} for k in (1, 1, 2)),
    ):
        sensing = Sensing(selection="chip", **options)  # type: ignore[arg-type]
        trace = forest.run(forest.Scenario(sensing=sensing, seed=5, die=die, pings=40))
        found.append(trace.sample.deciding_s)
    quiet, one, same, other = found
    assert one == same
    assert len({quiet, one, other}) == 3
    assert [one, other] == pytest.approx([quiet, quiet], rel=0.2)


@pytest.mark.parametrize(
    "command",
    [
        ["bug", "--ideal", "--duration", "100ms"],
        ["forest", "--ideal", "--pings", "3"],
        ["forest", "--ranges", "sonar", "--selection", "ideal", "--pings", "3"],
        ["car", "--ideal", "--pings", "3"],
        ["spiking-bat", "--brain", "lif", "--pings", "2"],
        ["rover", "--ideal", "--goal", "3,10"],
    ],
)
def test_without_a_chip_in_the_loop_the_word_changes_nothing(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    found = []
    for options in ([], ["--silicon-noise", "white"], ["--silicon-noise", "off"]):
        assert main(["run", *command, "--json", *options]) in {0, 1}
        found.append(json.loads(capsys.readouterr().out))
    ran_on = [document["summary"].pop("ran_on") for document in found]
    assert all("silicon_noise" not in each for each in ran_on)
    for document in found:
        document.pop("silicon_noise", None)
    assert found[0] == found[1] == found[2]


def test_parts_at_transistor_level_are_told_to_make_none() -> None:
    """The rest of the chip is noisy, and the unit is not."""
    asked = spiking_bat.Scenario(brain="chip", pings=2, units=((3, 4),))
    assert account(spiking_bat.run(asked)).ran_on[NOISELESS] == "units at transistor level"
    assert account(spiking_bat.run(replace(asked, silicon_noise="off"))).ran_on[NOISELESS] is None
    boxes = approach.Scenario(duration=0.05, level="behavioural", transistors=frozenset({"vocalization"}))
    assert approach.SYSTEM.account(approach.run(boxes)).ran_on[NOISELESS] == "vocalization"


@pytest.mark.parametrize(
    "command",
    [
        ["pushbot"],
        ["bug", "--brain", "chip"],
        ["spiking-bat", "--brain", "chip"],
        ["head"],
        ["forest", "--ranges", "chip"],
        ["car", "--ranges", "chip"],
    ],
)
def test_a_word_that_is_no_noise_is_refused(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", *command, "--silicon-noise", "loud"]) == 2
    assert "--silicon-noise: loud, must be off, white or all" in capsys.readouterr().err


def test_a_seed_of_noise_wants_noise() -> None:
    with pytest.raises(ParameterError, match="noise_seed: 3, there is no noise; give `silicon_noise"):
        check_noise("off", 3)
    check_noise("off", None)
    check_noise("white", 3)


def test_a_head_has_noise() -> None:
    """The same die, target and echoes: another seed of noise is another run, its own is the same."""
    quiet = sonar_head.Scenario(duration=3.0, seed=1, die=Die(number=1000), silicon_noise="off")
    noisy = [replace(quiet, silicon_noise="all", noise_seed=k) for k in (1, 1, 2)]
    silent, one, same, other = (sonar_head.run(s).log for s in (quiet, *noisy))
    assert np.array_equal(one.spikes, same.spikes)
    assert not np.array_equal(one.spikes, other.spikes)
    # a millisecond is two spikes' distance: microseconds of jitter move none beyond
    before = min(len(silent.spikes), len(one.spikes), 4)
    assert one.spikes[:before] == pytest.approx(silent.spikes[:before], abs=20e-6)
    assert not np.array_equal(one.spikes[:before], silent.spikes[:before])


def test_a_robots_chip_has_noise(capsys: pytest.CaptureFixture[str]) -> None:
    drive = ["run", "car", "--ranges", "chip", "--pings", "20", "--seed", "3", "--json"]
    assert main([*drive, "--silicon-noise", "white"]) == 0
    assert json.loads(capsys.readouterr().out)["silicon_noise"] == "white"
    scenario = car.Scenario(ranges="chip", silicon_noise="white", noise_seed=4)
    delay = np.linspace(3e-3, 12e-3, 400)
    heard = []
    for fields in ({}, {}, {"noise_seed": 5}, {"silicon_noise": "off", "noise_seed": None}):
        sonar, _ = car.sonar_of(replace(scenario, **fields), np.random.default_rng(0))
        assert sonar is not None
        heard.append([_ranges(sonar(0.1 * k), delay[k : k + 1], 0.1 * k)[0] for k in range(delay.size)])
    one, same, other, quiet = np.array(heard)
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
    assert not np.isnan(one).any()
    assert 0.0 < np.abs(one - quiet).mean() < 0.02  # m, by some ten us of jitter
