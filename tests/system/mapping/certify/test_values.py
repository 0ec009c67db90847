"""A network of values at a task: what it is given, what it answers, its noise, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from chips.noise import SiliconNoise
from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main
from system.mapping.certify.chips import CERTIFIED, Where
from system.mapping.certify.ends import ends_of
from system.mapping.certify.system import SYSTEM, contents_of
from system.mapping.certify.task import Episodes, Samples
from system.mapping.certify.values import NeuronPlayer
from system.mapping.chips import map_on
from system.mapping.nef.mapped import MappedValues, ideal_of
from system.mapping.nef.network import Connection, Ensemble, Probe, ValueNetwork
from system.mapping.nef.program_file import write_value_program
from system.mapping.network import Input

NET = ValueNetwork(
    (Ensemble("sides", 50, 2),),
    (Input("in", 2),),
    (Connection("in", "sides", transform=((1.0, -0.5), (-0.5, 1.0))),),
    (Probe("left and right", "sides"),),
)
INPUTS = np.array([[0.8, 0.1], [0.1, 0.8], [0.6, 0.0], [-0.9, -0.1]])
LABELS = np.array([0, 1, 0, 0])  # the last one is wrong


@pytest.fixture(scope="module")
def mapped() -> MappedValues:
    """The larger of two values on the NEF chip."""
    found = map_on("nef", NET)
    assert isinstance(found, MappedValues)
    return found


@pytest.fixture(scope="module")
def folder(mapped: MappedValues, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with its program, and samples for it."""
    found = tmp_path_factory.mktemp("values")
    write_value_program(found / "p.toml", mapped)
    np.savez(found / "s.npz", inputs=INPUTS, labels=LABELS, window_s=0.06)
    return found


@pytest.fixture(scope="module")
def noisy(mapped: MappedValues) -> NeuronPlayer:
    """The network on a die with noise, with the codes of the nominal one."""
    where = Where(Silicon(ROLLS_180, die=Die("A", 1000)), 1.0, "generator", "default", SiliconNoise(5))
    found = CERTIFIED["nef"].on_die(mapped, where)
    assert isinstance(found, NeuronPlayer)
    return found


def test_an_output_is_the_mean_of_its_value_and_windows_go_on(mapped: MappedValues) -> None:
    player = CERTIFIED["nef"].ideal(mapped)
    whole = player(INPUTS[0], 0.06)
    player.begin()
    parts = [player(INPUTS[0], 0.02) for _ in range(3)]
    assert np.mean(parts, axis=0) == pytest.approx(whole)
    # 0.8 - 0.05 and 0.1 - 0.4, which the probe of 20 ms behind a filter of 5 ms has come near to
    assert whole[0] > 0.3
    assert whole[1] < 0.0
    player(INPUTS[0], 0.3)
    assert player(INPUTS[0], 0.02) == pytest.approx([0.75, -0.3], abs=1e-6)


def test_each_sample_has_noise_of_its_own_whatever_ran_before(noisy: NeuronPlayer) -> None:
    def of(k: int) -> tuple[float, ...]:
        noisy.begin(k)
        return tuple(noisy(INPUTS[0], 0.03).tolist())

    found = [of(k) for k in range(4)]
    assert len(set(found)) == 4
    assert [of(k) for k in (2, 0, 3)] == [found[k] for k in (2, 0, 3)]
    noisy.begin(1)
    noisy.begin()
    assert tuple(noisy(INPUTS[0], 0.03).tolist()) == found[2]


def test_the_largest_output_is_the_answer_and_silence_is_wrong(mapped: MappedValues) -> None:
    ideal = CERTIFIED["nef"].ideal(mapped)
    samples = Samples(INPUTS, LABELS, 0.06)
    assert samples(ideal, 0) == 0.75
    still = Ensemble("a", 20, intercepts=(0.5, 0.9))  # at 0, where it is, no neuron fires
    dumb = ValueNetwork((still,), (Input("in", 2),), (), (Probe("o", "a"),))
    silent = NeuronPlayer(dumb, ideal_of(dumb))
    assert Samples(INPUTS, np.zeros(4, np.int64), 0.002)(silent, 0) == 0.0


def test_numbers_that_are_seen_are_values_over_their_reach() -> None:
    assert ends_of(NET).of_shares(np.array([0.5, -1.0])).tolist() == [0.5, -1.0]
    four = ValueNetwork(
        (Ensemble("a", 9, 2),), (Input("in", 4),), (Connection("in", "a", transform=((1.0,) * 4,) * 2),),
        (Probe("o", "a"),),
    )  # fmt: skip
    Episodes("CartPole-v1", (1.0, 1.5, 0.2, 2.0), 1).check(four)
    with pytest.raises(ParameterError, match=r"task\.CartPole-v1: 4 channels, must be the network's 2"):
        Episodes("CartPole-v1", (1.0, 1.5, 0.2, 2.0), 1).check(NET)


@pytest.mark.parametrize(("die", "healed", "area"), [(Die(), "nothing", 1.0), (Die("A", 1000), "lines", 4.0)])
def test_a_die_is_scored_beside_the_equations(folder: Path, die: Die, healed: str, area: float) -> None:
    program, task = str(folder / "p.toml"), str(folder / "s.npz")
    given = {"program": program, "task": task, "contents": contents_of(program, task)}
    trace = SYSTEM.run(SYSTEM.scenario(**given, die=die, healed=healed, area=area))
    assert (trace.ideal, trace.score) == (0.75, 0.75)
    assert SYSTEM.summarise(trace)["lost"] == 0.0


def test_what_is_healed_is_a_part_of_the_chip(mapped: MappedValues) -> None:
    def numbers(healed: str) -> dict[str, np.ndarray]:
        where = SYSTEM.scenario(die=Die("A", 1000), healed=healed).silicon
        built = mapped.on(where, "ideal", solved=False)
        assert built.chip is not None
        assert built.bends is not None
        chip, stages = built.chip, built.chip.net.encoder
        outputs = np.exp(built.bends.output[chip.step > 0.0].max(axis=1))
        return {
            "neurons": chip.refractory, "stages": stages[stages != 0.0], "filters": outputs,
            "lines": chip.lines[0],
        }  # fmt: skip

    plain = numbers("nothing")
    for name in CERTIFIED["nef"].parts:
        found = numbers(name)
        # what all parts of a kind share is the calibration's
        spread = {part: np.ptp(found[part] / plain[part]) > 1e-3 for part in plain}
        assert [part for part, moved in spread.items() if moved] == [name]


def test_a_study_of_two_dies_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["certify", str(folder / "p.toml"), "--task", str(folder / "s.npz"), "--dies", "2"]
    assert main([*words, "--change", "none"]) == 0
    told = capsys.readouterr().out
    assert "16 to 100 %" in told  # Clopper's and Pearson's for 2 of 2
    assert "75.0%" in told


def test_a_function_of_a_users_own_is_part_of_the_program(tmp_path: Path) -> None:
    own = tmp_path / "own.py"
    own.write_text("def half(x):\n    return 0.5 * x\n", encoding="utf-8")
    (tmp_path / "p.toml").write_text(
        f'chip = "nef"\n[network]\nprobe = [{{name = "o", ensemble = "a", function = "{own}:half"}}]\n',
        encoding="utf-8",
    )
    before = contents_of(str(tmp_path / "p.toml"), "none")
    own.write_text("def half(x):\n    return 0.4 * x\n", encoding="utf-8")
    assert contents_of(str(tmp_path / "p.toml"), "none") != before


@pytest.mark.parametrize(
    ("given", "more", "told"),
    [
        (
            {"inputs": [[np.nan, 0.0]]},
            (),
            r"task: inputs\[0,0\] nan, must be from -1e\+06 to 1e\+06, a value",
        ),
        ({"labels": [2]}, (), "task.labels: sample 0 has 2, must be 0 to 1, the outputs"),
        ({"inputs": [[1.0]]}, (), "task.inputs: 1 channels, must be the network's 2"),
        ({"window_s": 0.0004}, (), "task.window: 0.0004 s, must be whole steps of 0.001 s"),
        (
            {},
            ("--change", "healed=synapses"),
            "healed: synapses, the NEF chip has none; take neurons, stages,",
        ),
    ],
)
def test_a_task_that_does_not_fit_is_refused_before_any_run(
    given: dict[str, Any], more: tuple[str, ...], told: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task = str(folder / "odd.npz")
    np.savez(task, **{"inputs": [[1.0, 0.0]], "labels": [0], "window_s": 0.06, **given})
    capsys.readouterr()
    assert main(["certify", str(folder / "p.toml"), "--task", task, "--dies", "1", *more]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(told, line)


def test_a_program_without_outputs_or_of_no_chip_is_refused(
    tmp_path: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_value_program(
        tmp_path / "p.toml", map_on("nef", ValueNetwork((Ensemble("a", 9),), (Input("i", 2),)))
    )
    (tmp_path / "l.toml").write_text('format = "noctule-program/1"\nchip = "latency"\n', encoding="utf-8")
    for name, told in (
        ("p", "probe: none, must be one for each output"),
        ("l", "chip latency, must be rolls, nef"),
    ):
        assert main(["certify", str(tmp_path / f"{name}.toml"), "--task", str(folder / "s.npz")]) == 2
        assert told in capsys.readouterr().err


def test_a_window_in_one_go_is_to_the_bit_what_its_steps_add_up_to(noisy: NeuronPlayer) -> None:
    def by_steps(inputs: F64) -> list[float]:
        running, total = noisy._running, np.zeros(2)
        running.set("in", inputs)
        for _ in range(20):
            running.advance(1e-3)
            total += running.read("left and right")
        return (total / 20).tolist()

    noisy.begin(3)
    found = [noisy(inputs, 0.02).tolist() for inputs in INPUTS]
    time, counts = noisy._running.time, noisy._running.counters
    noisy.begin(3)
    assert found == [by_steps(inputs) for inputs in INPUTS]
    assert noisy._running.time == time > 0.079
    assert noisy._running.counters == counts
    assert counts["spikes"] > 100
    running = noisy._running
    sums, before = running.summed(["left and right"], 5), len(running.recorded()[0])
    running.record()
    assert running.summed(["left and right"], 5).shape == sums.shape
    assert len(running.recorded()[0]) > before == 0  # step by step, as each spike is kept
