"""A mapped network at a task: windows, samples, environments, and the same task on the ideal and on a die."""

import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest

from chips.aer import Events
from chips.noise import SiliconNoise
from chips.rolls.brief.encoded import Encoded
from chips.rolls.chip import RollsChip
from chips.rolls.tables import Built
from circuits.catalogue import later
from circuits.errors import DataError, ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.cli import certify
from system.cli.certify_verb import Certify
from system.cli.command_line import main
from system.gym.environment import Environment
from system.mapping.certify import encoding
from system.mapping.certify.chips import CERTIFIED, NOTHING
from system.mapping.certify.spiking import ChipPlayer, IdealPlayer, SpikingPlayer
from system.mapping.certify.system import SYSTEM, contents_of
from system.mapping.certify.task import Episodes, Samples, environment_of, task_of
from system.mapping.chips import map_on
from system.mapping.dynamics import Trains
from system.mapping.network import Connection, Input, Network, Population, Probe
from system.mapping.program_file import read_program_file, write_program

NET = Network(
    (Population("left", 4), Population("right", 4)),
    (Input("in", 2),),
    tuple(
        Connection("in", name, rule="matrix", tau=20e-3, matrix=np.tile(row, (4, 1)))  # type: ignore[arg-type]
        for name, row in (("left", (0.5, 0.1)), ("right", (0.1, 0.5)))
    ),
    (Probe("goes left", "left"), Probe("goes right", "right")),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a program of two sides, and samples for each."""
    found = tmp_path_factory.mktemp("certify")
    write_program(found / "p.toml", map_on("rolls", NET))
    inputs = [[400.0, 40.0], [40.0, 400.0], [300.0, 30.0], [0.0, 0.0]]
    np.savez(found / "s.npz", inputs=inputs, labels=[0, 1, 0, 0], window_s=0.08)
    return found


def test_windows_go_on_as_one_run_does() -> None:
    player = IdealPlayer(NET)
    whole = player([310.0, 130.0], 0.08)
    player.begin()
    parts = [player([310.0, 130.0], 0.02) for _ in range(4)]
    assert sum(parts).tolist() == whole.tolist()
    assert whole[0] > whole[1] > 0.0
    with pytest.raises(ParameterError, match=r"task.rates: 1 from 0 to 5 Hz, must be 2"):
        player([5.0], 0.02)
    with pytest.raises(ParameterError, match=r"task.window: 0.0003 s, must be whole steps"):
        player([5.0, 5.0], 3e-4)


@pytest.fixture(scope="module")
def noisy(folder: Path) -> ChipPlayer:
    """The program of two sides on a die, with noise."""
    mapped = read_program_file(folder / "p.toml")
    return ChipPlayer(mapped, Silicon(ROLLS_180, die=Die("A", 1000)), "generator", SiliconNoise(5))


def when(player: ChipPlayer) -> tuple[float, ...]:
    """Times of spikes in 80 ms of events every 2 ms, from where the player is."""
    times = np.arange(0.0, 0.08, 2e-3)
    return tuple(player._advance(Events(times, np.zeros(times.size, np.int64)), 0.08).times.tolist())


def samples_of(player: ChipPlayer, numbers: Sequence[int]) -> dict[int, tuple[float, ...]]:
    found = {}
    for k in numbers:
        player.begin(k)
        found[k] = when(player)
    return found


def test_each_sample_has_noise_of_its_own_whatever_ran_before(noisy: ChipPlayer) -> None:
    found = samples_of(noisy, range(12))
    assert len(set(found.values())) == 12  # of one realisation of the noise they were all one
    assert samples_of(noisy, (7, 2, 11)) == {k: found[k] for k in (7, 2, 11)}


def test_samples_are_numbered_as_they_begin_unless_a_task_numbers_them(noisy: ChipPlayer) -> None:
    noisy.begin(4)
    noisy.begin()
    assert when(noisy) == samples_of(noisy, [5])[5]
    for wrong in (-1, 0.5):
        with pytest.raises(ParameterError, match=rf"task.begin: sample {wrong}, must be a whole number"):
            noisy.begin(wrong)  # type: ignore[arg-type]


def test_some_of_the_samples_have_the_noise_that_they_have_among_all(noisy: ChipPlayer) -> None:
    told: dict[int, list[int]] = {}

    class Spy(SpikingPlayer):
        def _rest(self, number: int) -> None:
            told[len(told)] = [number]

        def _advance(self, events: Events, window: float) -> Trains:
            told[len(told) - 1].append(round(events.times.size))
            return Trains(np.empty(0), np.empty(0, np.int64))

    inputs = 10.0 * np.arange(1, 21)[:, None] * np.ones((1, 2))  # as many events as tell the sample
    samples = Samples(inputs, np.zeros(20, np.int64), 1.0, most=6)
    samples(Spy(NET), 3)
    assert len(told) == 6
    assert all(events == 2 * 10 * (number + 1) for number, events in told.values())
    told.clear()
    network = Network(NET.populations, (Input("in", 9),), probes=NET.probes)
    Episodes("CartPole-v1", (1.0, 1.5, 0.2, 2.0), 3)(Spy(network), 1)
    assert [number for number, *_ in told.values()] == [0, 1, 2]


def test_a_die_is_scored_beside_the_ideal_and_silence_is_wrong(folder: Path) -> None:
    program, task = str(folder / "p.toml"), str(folder / "s.npz")
    given = {"program": program, "task": task, "codes": "default", "contents": contents_of(program, task)}
    for die, healed in ((Die(), "nothing"), (Die("A", 1000), "neurons")):
        trace = SYSTEM.run(SYSTEM.scenario(**given, die=die, healed=healed))
        assert trace.ideal == 0.75  # the last sample has no event, so that nothing spikes
        assert 0.0 <= trace.score <= 0.75
        summary = SYSTEM.summarise(trace)
        assert summary["lost"] == trace.ideal - trace.score
        assert summary["succeeded"] == (trace.score >= 0.72)
    with pytest.raises(ParameterError, match="has changed since; certify anew"):
        SYSTEM.run(SYSTEM.scenario(**{**given, "contents": "0"}))


@pytest.mark.parametrize("gives", ["3.0", "float('nan')", "-0.1", "'1'"])
def test_a_score_that_is_no_share_is_refused(folder: Path, gives: str) -> None:
    (folder / "own.py").write_text(f"def task(network, seed):\n    return {gives}\n", encoding="utf-8")
    program, task = str(folder / "p.toml"), f"{folder / 'own.py'}:task"
    given = {"program": program, "task": task, "codes": "default", "contents": contents_of(program, task)}
    with pytest.raises(ParameterError, match=r"task: .*own\.py:task gives .*, must be a number from 0 to 1$"):
        SYSTEM.run(SYSTEM.scenario(**given))


def test_a_program_of_another_chip_is_refused_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "v.toml").write_text('format = "noctule-program/1"\nchip = "nef"\n', encoding="utf-8")
    with pytest.raises(DataError, match=r"v\.toml: a program of nef, must be of rolls; map"):
        read_program_file(tmp_path / "v.toml")


def test_what_is_healed_is_a_part_of_the_chip(folder: Path) -> None:
    program = read_program_file(folder / "p.toml").program

    def built(healed: str) -> Built:
        return RollsChip(program, SYSTEM.scenario(die=Die("A", 1000), healed=healed).silicon).built()

    plain = built(NOTHING)
    for name in (NOTHING, *CERTIFIED["rolls"].parts):
        found = built(name)
        # neurons have tables of their own; synapses, filters and pulses are in the filters' charges
        own = np.array_equal(found.tables.membranes.top, plain.tables.membranes.top)
        charges = np.array_equal(found.tables.omega, plain.tables.omega)
        assert (own, charges) == (name != "neurons", name in {"nothing", "neurons"}), name


def test_an_environment_takes_the_action_whose_output_spikes_most() -> None:
    task = task_of("CartPole-v1", 1, "1,1.5,0.2,2")
    assert isinstance(task, Episodes)
    network = Network((Population("a", 1),), (Input("in", 9),), probes=(Probe("x", "a"), Probe("y", "a")))
    score = task(IdealPlayer(network), 3)  # which never spikes, so that it pushes to one side until it falls
    assert 8 / 475 <= score <= 11 / 475


@pytest.mark.parametrize(
    ("task", "told"),
    [
        ("CartPole-v1", "must be 4 numbers above 0, by commas; CartPole-v1 has no such bounds of its own"),
        ("NoSuch-v0", "name an environment, FILE.npz or FILE.py:NAME"),
        ("Pendulum-v1", "has no actions to choose from"),
        ("none.npz", "none.npz: No such file"),
    ],
)
def test_a_task_that_is_none_is_refused_in_a_line(
    task: str, told: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises((ParameterError, DataError)):
        task_of(task, 0, "")
    assert main(["certify", str(folder / "p.toml"), "--task", task]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert told in error


@pytest.mark.parametrize("given", ["noctule/Rover-v0", "system.gym:noctule/Rover-v0"])
def test_an_environment_of_ours_is_found_by_its_id_alone(given: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in gymnasium.registry if name.startswith("noctule/")]:
        monkeypatch.delitem(gymnasium.registry, name)
    monkeypatch.delitem(sys.modules, "system.gym", raising=False)
    assert isinstance(environment_of(given).unwrapped, Environment)
    with pytest.raises(ParameterError, match=f"task: {given} has no actions to choose from; write a FILE.py"):
        task_of(given, 1, "")


def test_an_environment_of_another_package_is_found_by_its_entry_point(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def register() -> None:
        gymnasium.register("plugged/Pole-v0", "gymnasium.envs.classic_control:CartPoleEnv", 475.0, 500)

    monkeypatch.setattr(gymnasium.envs.registration, "registry", gymnasium.registry.copy())
    own = SimpleNamespace(load=lambda: register)
    groups = SimpleNamespace(select=lambda name: [own] if name == "plugged" else [])
    monkeypatch.setattr("system.mapping.certify.task.entry_points", lambda _: groups)
    found = task_of("plugged/Pole-v0", 3, "1,1.5,0.2,2")
    assert found == Episodes("plugged/Pole-v0", (1.0, 1.5, 0.2, 2.0), 3)


@pytest.mark.parametrize(
    ("task", "told"),
    [
        ("nosuch:Pole-v0", "task: nosuch:Pole-v0, No module named 'nosuch'"),
        ("noctule/System-v0", "missing 1 required positional argument: 'system'"),
        ("noctule/Nope-v0", "Environment `Nope` doesn't exist in namespace noctule"),
    ],
)
def test_an_environment_that_cannot_be_made_is_refused_in_a_line(task: str, told: str) -> None:
    with pytest.raises(ParameterError, match=re.escape(told)) as found:
        task_of(task, 1, "")
    assert "\n" not in str(found.value)


def test_without_gymnasium_what_to_install_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("system.mapping.certify.task.gymnasium", later("gymnasium"))
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(ParameterError, match=r'task: CartPole-v1, .*; pip install "noctule\[gymnasium\]"'):
        task_of("CartPole-v1", 1, "")


@pytest.mark.parametrize("task", ["FrozenLake-v1", "Blackjack-v1"])
def test_an_environment_that_shows_no_array_or_has_no_threshold_is_refused(task: str) -> None:
    with pytest.raises(ParameterError, match=f"task: {task} (shows no array of numbers|has no threshold)"):
        task_of(task, 1, "")


def test_the_reach_of_an_environment_is_the_larger_of_its_bounds() -> None:
    task = task_of("MountainCar-v0", 1, "")  # from -1.2 to 0.6
    assert isinstance(task, Episodes)
    assert task.reach == pytest.approx((1.2, 0.07))


def test_a_program_that_is_written_anew_is_read_anew(folder: Path, tmp_path: Path) -> None:
    given = {"program": str(tmp_path / "p.toml"), "task": str(folder / "s.npz"), "codes": "default"}
    scores = []
    for outputs in (NET.probes, NET.probes[::-1]):
        write_program(tmp_path / "p.toml", map_on("rolls", replace(NET, probes=outputs)))
        scores.append(SYSTEM.run(SYSTEM.scenario(**given)).ideal)
    assert scores == [0.75, 0.0]


def test_dies_of_one_lot_are_told_as_such(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["certify", str(folder / "p.toml"), "--task", str(folder / "s.npz"), "-o", str(tmp_path / "kept")]
    more = ["--dies", "2", "--change", "none", "--lot", "B", "--variation", "transistors"]
    assert main([*words, *more]) == 0
    told, shared = capsys.readouterr().out, "The dies are of lot B and 1 wafer of it, whose draws they share"
    assert shared in told
    assert shared in (tmp_path / "kept" / "report.html").read_text(encoding="utf-8")
    assert "16 to 100 %" in told  # Clopper's and Pearson's for 2 of 2


def test_no_change_is_tried_where_none_is_asked(folder: Path) -> None:
    files = {"program": str(folder / "p.toml"), "task": str(folder / "s.npz")}
    assert certify._asked(Certify(**files, change=("none",))).changes == ()
    assert certify._asked(Certify(**files, change=("area=4",))).changes == ("area=4",)


def test_the_command_that_is_kept_has_every_option_of_the_runs() -> None:
    asked = Certify(
        program="p.toml", task="t.npz", dies=3, temperature=("17", "37"), change=("area=4",), output="o"
    )
    said = " ".join(certify._command(asked))
    wanted = "--task t.npz --dies 3 --temperature 17 --temperature 37 --change area=4"
    assert said == f"noctule certify p.toml {wanted}"


def test_scores_of_dies_that_could_not_be_run_are_none() -> None:
    score = np.array([0.5, np.nan, np.nan])
    table = SimpleNamespace(
        die=np.array([1, 2, 3]), column=lambda name: {"score": score}.get(name, np.ones(3))
    )
    found: Any = SimpleNamespace(way=SimpleNamespace(name="27C"), table=table)
    assert certify._scores(found)["least"] == 0.5
    score[0] = np.nan
    assert certify._scores(found)["score"] is None


@pytest.mark.parametrize(
    ("inputs", "labels", "window", "told"),
    [
        ([[400.0, 40.0], [np.nan, 1.0]], [0, 1], 0.08, r"inputs\[1,0\] nan Hz, must be from 0 to 10000 Hz"),
        ([[400.0, -4.0]], [0], 0.08, r"inputs\[0,1\] -4 Hz, must be from 0 to 10000 Hz, a rate"),
        ([[400.0, 40.0]], [0.5], 0.08, r"labels\[0\] 0.5, must be the number of an output"),
        ([[400.0, 40.0]], [2], 0.08, "task.labels: sample 0 has 2, must be 0 to 1, the outputs"),
        ([[400.0, 40.0, 1.0]], [1], 0.08, "task.inputs: 3 channels, must be the network's 2"),
        ([[400.0, 40.0]], [1], -0.08, "task.window: -0.08 s, must be whole steps of 0.0004 s"),
        ("CartPole-v1", None, None, "task.CartPole-v1: 9 channels, must be the network's 2"),
    ],
)
def test_a_task_that_does_not_fit_is_refused_before_any_run(
    folder: Path, inputs: Any, labels: Any, window: Any, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    task = str(folder / "odd.npz")
    more = ["--reach", "2,2,0.2,2"] if isinstance(inputs, str) else []
    if isinstance(inputs, str):
        task = inputs
    else:
        np.savez(task, inputs=inputs, labels=labels, window_s=window)
    capsys.readouterr()
    assert main(["certify", str(folder / "p.toml"), "--task", task, "--dies", "1", *more]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(told, line)


@pytest.fixture(scope="module")
def busy() -> Network:
    """Two sides of many neurons, which strong channels drive so that the bus loses events."""
    rows = (("left", np.repeat((0.4, 0.2), 4)), ("right", np.repeat((0.2, 0.4), 4)))
    ways = tuple(
        Connection("in", name, rule="matrix", tau=20e-3, matrix=np.tile(row, (30, 1)))  # type: ignore[arg-type]
        for name, row in rows
    )
    populations = Population("left", 30), Population("right", 30)
    return Network(populations, (Input("in", 8),), ways, (Probe("l", "left"), Probe("r", "right")))


def test_samples_in_one_go_are_to_the_bit_what_the_whole_chip_gives(
    busy: Network, monkeypatch: pytest.MonkeyPatch
) -> None:
    mapped, encoded = map_on("rolls", busy), []
    events = type(mapped).events
    inputs = np.random.default_rng(3).uniform(0.0, 900.0, (4, 8))
    inputs[0] = 800.0 * (1.0 - np.arange(8) / 8.0)  # whose first events come at one time
    for die, noise in ((1000, SiliconNoise(2)), (1001, SiliconNoise(5)), (1001, None)):
        silicon = Silicon(ROLLS_180, die=Die("A", die))
        chip = RollsChip(mapped.program, silicon, "generator", noise=noise)
        player, whole = (ChipPlayer(mapped, silicon, "generator", noise) for _ in range(2))
        whole._chip, whole._first = chip, chip.at_rest()
        assert player._chip is not chip
        assert player._first.values.shape[1] == 64
        wanted = []
        for k, each in enumerate(inputs):
            whole.begin(k)
            wanted.append(whole(each, 0.06))
        monkeypatch.setattr(type(mapped), "events", lambda *given: encoded.append(1) or events(*given))
        found = [player.answer(k, each, 0.06) for k, each in enumerate(inputs)]
        monkeypatch.undo()
        assert len(encoded) == 4  # once for all dies
        assert np.array_equal(found, wanted)
        assert player.lost == whole.lost > 0
        assert min(found[0]) > 0.0
        assert np.array_equal(player(inputs[3], 0.06), wanted[3])  # the next window begins at rest


def test_what_asks_for_single_events_gets_them(monkeypatch: pytest.MonkeyPatch) -> None:
    player = ChipPlayer(map_on("rolls", NET), Silicon(ROLLS_180), "generator", SiliconNoise(1))
    wanted = player.answer(2, [400.0, 40.0], 0.08)
    monkeypatch.setattr(RollsChip, "run_encoded", lambda *_: None)
    assert player.answer(2, [400.0, 40.0], 0.08).tolist() == wanted.tolist()
    with pytest.raises(ParameterError, match=r"task.rates: 1 from 0 to 5 Hz, must be 2"):
        player.answer(2, [5.0], 0.08)


def test_what_is_kept_of_samples_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, made = encoding._Kept(), []

    def make(size: int) -> Encoded:
        made.append(size)
        return Encoded(np.zeros(size, np.uint8), np.zeros((0, 2, 0), np.uint8), 0)

    monkeypatch.setattr(encoding, "MOST", 100)
    for name in (b"a", b"b", b"a", b"c", b"a"):  # b has to go for c
        kept.get((name, b"", 0.1), lambda: make(40))
    assert made == [40, 40, 40]
    kept.get((b"b", b"", 0.1), lambda: make(40))
    assert made == [40] * 4
    kept.get((b"whole", b"", 0.1), lambda: make(200))  # more than is ever kept
    kept.get((b"a", b"", 0.1), lambda: make(40))
    assert made == [40, 40, 40, 40, 200, 40]


def test_what_two_threads_make_at_once_counts_once(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, key = encoding._Kept(), (b"a", b"", 0.1)
    own = Encoded(np.zeros(60, np.uint8), np.zeros((0, 2, 0), np.uint8), 0)

    def while_another_makes_it() -> Encoded:
        kept.get(key, lambda: own)
        return own

    monkeypatch.setattr(encoding, "MOST", 100)
    assert kept.get(key, while_another_makes_it) is own
    assert kept.get(key, lambda: None) is own  # and nothing has gone for it
