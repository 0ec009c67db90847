"""Spikes of runs as files, from the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from system.bug.neural import NeuralBrain
from system.bug.run import make_brain
from system.cli.command_line import main
from system.play.run import open_robot
from system.registry import load_system, system_names
from system.spikes.output import trains_of
from tests.system.conftest import Run, RunJson

WITH_SPIKES = {"approach", "bug", "car", "forest", "head", "pushbot", "rolls", "rover", "spiking-bat"}


def _trains(path: Path) -> dict[str, list[float]]:
    with path.open("rb") as opened, np.load(opened) as held:
        time, address = held["time_s"], held["address"]
        return {name: time[address == k].tolist() for k, name in enumerate(held["name"].tolist())}


def test_trains_are_those_of_their_addresses() -> None:
    found = trains_of("n", 3, np.array([0.1, 0.2, 0.3]), np.array([2, 0, 2]))
    assert {name: times.tolist() for name, times in found.items()} == {
        "n[0]": [0.2], "n[1]": [], "n[2]": [0.1, 0.3],
    }  # fmt: skip


def test_a_simulation_writes_the_spikes_that_it_tells(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    found = run_json("simulate", "rebound-neuron", "--law", "ideal", "--spikes", str(path))
    assert _trains(path) == {"spike": found["spikes_s"]}
    assert found["spikes_s"]


def test_a_replay_writes_those_of_its_die(run_json: RunJson, run: Run, tmp_path: Path) -> None:
    path, study = tmp_path / "a.npz", str(tmp_path / "study")
    run_json("montecarlo", "axon-delay", "-n", "1", "--metric", "unit_delay", "--output", study)
    found = run_json("replay", study, "--die", "1000", "--spikes", str(path))
    assert _trains(path) == found["spikes_s"]
    assert any(found["spikes_s"].values())
    status, out, err = run("replay", study, "--die", "1000", "--spikes", str(tmp_path / "a.dat"))
    assert (status, out, err.count("\n")) == (2, "", 1)


def test_the_bat_writes_spikes_of_its_chip(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    words = ("run", "spiking-bat", "--codes", "default", "--pings", "6")
    found = run_json(*words, "--spikes", str(path))
    trains = _trains(path)
    assert list(trains)[::33] == ["arc[0]", "emergency"]
    spikes = np.sort(np.concatenate(list(trains.values())))
    turned = [time for time in found["time_s"] if abs(time - round(time, 1)) > 1e-9]  # between two pings
    assert len(turned) == found["summary"]["pings"] == 6
    # the body turns at the first spike after a ping
    first = [spikes[spikes > 0.1 * k][0] for k in range(6)]
    assert first == pytest.approx(turned, abs=1e-9)


def test_the_rover_writes_its_waves(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    (tmp_path / "map.txt").write_text("1 1 1\n1 9 1\n1 1 1\n")
    words = ("run", "rover", "--codes", "default", "--map", str(tmp_path / "map.txt"))
    found = run_json(*words, "--start", "0,0", "--goal", "2,2", "--spikes", str(path))
    trains = _trains(path)
    assert list(trains)[:2] == ["cell[0,0]", "cell[0,1]"]
    assert len(trains) == 9
    fired = [trains[f"cell[{row},{column}]"][0] for row, column in found["planned_path"]]
    assert fired == sorted(fired)  # the wave came along the path that was read from it
    assert fired[0] < fired[-1]


def test_the_head_writes_as_many_as_it_counts(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    words = ("run", "head", "--codes", "default", "--duration", "1s")
    found = run_json(*words, "--spikes", str(path))
    trains = _trains(path)
    late = found["summary"]["late_spikes"]
    counted = sum(found["spikes_left"]) + sum(found["spikes_right"])
    assert sum(map(len, trains.values())) == counted + late > 0
    assert list(trains) == ["left", "right"]


def test_the_approach_writes_its_spikes(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    words = ("run", "approach", "--codes", "default", "--duration", "0.3s")
    found = run_json(*words, "--spikes", str(path))
    trains = _trains(path)
    assert trains["onset"] == sorted(found["echoes_s"])
    assert trains["high_threshold"] == sorted(found["pulses_s"])
    told = sorted((each["time_s"], f"neuron[{each['neuron']}]") for each in found["spikes"])
    kept = sorted((t, name) for name, times in trains.items() if name.startswith("neuron") for t in times)
    assert told == kept
    assert told


def test_the_bug_writes_its_neurons_which_a_run_does_not_keep(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    system = load_system("bug")
    scenario = system.scenario(agent="bug0", brain="ideal", map="bug-open", duration=0.2, neurons=300)
    trace = system.run(scenario)
    system.outputs["spikes"].write(str(path), trace, lambda _: None)
    robot, brain = open_robot(system, scenario), make_brain(scenario, trace.world)
    assert isinstance(brain, NeuralBrain)
    for _ in trace.state:  # the same drive, without a record
        robot.act(brain.step(robot.readings()).clip(-1.0, 1.0))
    counts = [len(times) for times in _trains(path).values()]
    assert counts == brain.simulation.state.spikes.tolist()
    assert sum(counts) > 100


@pytest.mark.parametrize(
    ("name", "given"), [("forest", {"ranges": "chip", "pings": 30}), ("car", {"ranges": "chip", "pings": 30})]
)
def test_the_bat_and_the_car_write_the_spikes_by_which_they_read_echoes(
    name: str, given: dict[str, Any], tmp_path: Path
) -> None:
    path = tmp_path / "a.npz"
    system = load_system(name)
    trace = system.run(system.scenario(seed=1000, codes="default", **given))
    system.outputs["spikes"].write(str(path), trace, lambda _: None)
    trains = _trains(path)
    assert list(trains) == [f"neuron[{k}]" for k in range(13)]
    found = system.numbers(trace)
    heard = found["heard"] if name == "forest" else found["echoes"]
    assert sum(map(len, trains.values())) >= heard > 0  # one neuron at least answers what is heard


@pytest.mark.usefixtures("unmeasured_power")
def test_the_chips_of_the_pushbot_and_of_rolls_write_theirs(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    found = run_json("run", "rolls", "--codes", "default", "--duration", "0.12s", "--spikes", str(path))
    trains = _trains(path)
    assert len(trains) == 256
    for k in (0, 100, 255):
        chosen = np.array(found["spike_neurons"]) == k
        assert trains[f"neuron[{k}]"] == sorted(np.array(found["spike_times_s"])[chosen].tolist())
    run_json("run", "pushbot", "--codes", "default", "--duration", "100ms", "--spikes", str(path))
    assert len(_trains(path)) == 256
    assert sum(map(len, _trains(path).values())) > 0


def test_each_robot_has_the_option_or_refuses_it_in_one_line(run: Run, tmp_path: Path) -> None:
    assert {name for name in system_names() if "spikes" in load_system(name).outputs} == WITH_SPIKES
    path = tmp_path / "a.npz"
    refused = {
        ("bug", "--ideal"): "--spikes: only those of a chip are recorded; add --brain chip",
        ("car", "--ranges", "exact"): "--spikes: only those of a chip are recorded; give --ranges chip",
        ("forest", "--ranges", "exact"): "--spikes: only those of a chip are recorded; give --ranges chip",
        (
            "forest",
            "--bias-kind",
            "gate",
            "--silicon-noise",
            "off",
        ): "recorded; give --silicon-noise white, or all, or leave it out",
        ("rover", "--ideal"): "--spikes: only those of a chip are recorded; add --cells chip",
        ("spiking-bat", "--ideal"): "--spikes: only those of a chip are recorded; add --brain chip",
    }
    for words, told in refused.items():
        status, out, err = run("run", *words, "--spikes", str(path))
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert told in err
    assert not path.exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("rebound-neuron", "--spikes", "a.dat"), "a.dat: must end with .aedat4"),
        (("rebound-neuron", "--analysis", "ac", "--spikes", "a.csv"), "--spikes: not of --analysis ac"),
        (
            ("follower.cir", "--spikes", "a.csv"),
            "--spikes: follower.cir watches no node",
        ),
    ],
)
def test_simulate_refuses_in_one_line(
    words: tuple[str, ...], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    Path("follower.cir").write_text("follower\nv1 a 0 1\nr1 a b 1k\nc1 b 0 1u\n.tran 1m 5m\n.end\n")
    assert main(["simulate", *words]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1
    assert not Path("a.csv").exists()
