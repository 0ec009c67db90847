"""Training of networks of values: the form against the NEF chip, its way back, and the command."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main
from system.mapping.certify.values import NeuronPlayer
from system.mapping.nef.mapped import MappedValues, map_on_nef
from system.mapping.nef.network import Connection, Ensemble, Probe, ValueNetwork
from system.mapping.network import Input
from system.mapping.network_file import write_network
from system.mapping.train.value_form import SOFT, ValueForm, backward, fired, forward, value_form
from system.mapping.train.values import value_learner

RNG = np.random.default_rng(7)
WINDOW, STEP = 0.08, 2e-3


def matrix(rows: int, columns: int, most: float) -> tuple[tuple[float, ...], ...]:
    """Weights of both signs."""
    return tuple(map(tuple, RNG.uniform(-most, most, (rows, columns)).tolist()))


NET = ValueNetwork(
    (Ensemble("hidden", 120, 3, radius=1.2), Ensemble("out", 60, 2)),
    (Input("in", 2),),
    (
        Connection("in", "hidden", transform=matrix(3, 2, 1.0)),
        Connection("hidden", "hidden", transform=matrix(3, 3, 0.3), synapse=20e-3),
        Connection("hidden", "out", "positive", matrix(2, 3, 0.8)),
        Connection("in", "out", transform=((0.2, 0.0), (0.0, -0.2))),  # shares the filters of the one above
    ),
    (Probe("first", "out"), Probe("size", "hidden", "length", 10e-3)),
)
MATRICES = tuple(np.array(c.transform) for c in NET.connections)
INPUTS = RNG.uniform(-1.0, 1.0, (24, 2))


@pytest.fixture(scope="module")
def mapped() -> MappedValues:
    """The network on its chip."""
    return map_on_nef(NET)


@pytest.fixture(scope="module")
def dies(mapped: MappedValues) -> tuple[tuple[ValueForm, F64], ...]:
    """Of the nominal die and of die 3, the form, and what the chip gives for the inputs."""
    found = []
    for die in (NOMINAL, Die("A", 3)):
        built = mapped.on(Silicon(ROLLS_180, die=die), "generator", solved=True)
        player, outputs = NeuronPlayer(NET, built), []
        for row in INPUTS:
            player.begin()
            outputs.append(player(row, WINDOW))
        found.append((value_form(NET, built), np.array(outputs)))
    return tuple(found)


def told(form: ValueForm, matrices: tuple[F64, ...] = MATRICES, inputs: F64 = INPUTS) -> F64:
    """Outputs of the form."""
    return forward(form, matrices, inputs, round(WINDOW / STEP), STEP)[0]


def test_forwards_it_decodes_what_the_chip_does(dies: tuple[tuple[ValueForm, F64], ...]) -> None:
    for form, chip in dies:
        off = told(form) - chip
        assert np.sqrt(np.mean(off**2)) < 0.02 * np.abs(chip).max()  # the ripple of 60 neurons' spikes; ours
        for k in range(chip.shape[1]):
            assert np.corrcoef(told(form)[:, k], chip[:, k])[0, 1] > 0.995


def test_backwards_it_tells_how_outputs_change_with_the_transforms(
    dies: tuple[tuple[ValueForm, F64], ...],
) -> None:
    form = dies[1][0]
    inputs = np.random.default_rng(3).uniform(-1.0, 1.0, (200, 2))
    outputs, tape = forward(form, MATRICES, inputs, 40, STEP)
    # over which neurons' thresholds are spread, at which the mean slope stands for the endless one
    by = backward(form, MATRICES, tape, np.ones_like(outputs), STEP)
    for k, matrix_ in enumerate(MATRICES):
        ends = []
        for scale in (1.02, 0.98):
            other = tuple(scale * m if j == k else m for j, m in enumerate(MATRICES))
            ends.append(told(form, other, inputs).sum())
        wanted = (ends[0] - ends[1]) / 0.04
        assert (by[k] * matrix_).sum() == pytest.approx(wanted, rel=0.05), k


def test_rates_have_the_slopes_that_they_have(dies: tuple[tuple[ValueForm, F64], ...]) -> None:
    group = dies[1][0].groups[0]
    p, n = np.random.default_rng(5).uniform(0.1, 0.5, (2, 8, 3))
    rate, by_current, _ = fired(group, p, n)
    lower, upper = (fired(replace(group, bias=group.bias + x), p, n)[0] for x in (-1e-6, 1e-6))
    # far enough above the threshold that no mean slope is taken
    current = group.bias + p @ group.up + n @ group.down - group.leak
    far = (current - 0.5 * group.rise > 2.0 * SOFT) & (rate > 1.0)
    assert far.mean() > 0.2
    assert by_current[far] == pytest.approx(((upper - lower) / 2e-6)[far], rel=1e-4)
    _, _, by_rise = fired(group, p, n)
    lower, upper = (fired(replace(group, rise=group.rise + x), p, n)[0] for x in (-1e-6, 1e-6))
    assert by_rise[far] == pytest.approx(((upper - lower) / 2e-6)[far], rel=1e-3)


def test_what_a_converter_clips_has_no_way_back(dies: tuple[tuple[ValueForm, F64], ...]) -> None:
    form = dies[0][0]
    outputs, tape = forward(form, MATRICES, np.array([[1e4, 0.0]]), 10, STEP)
    by = backward(form, MATRICES, tape, np.ones_like(outputs), STEP)
    assert not by[0].any()
    assert by[1].any()


def test_transforms_that_are_numbers_and_entries_of_0_stay() -> None:
    some = replace(
        NET,
        connections=(
            replace(NET.connections[0], transform=((1.0, 0.0),) * 3),
            *NET.connections[1:3],
            Connection("in", "out", transform=0.3),
        ),
    )
    weights = value_learner(some).weights
    moved = weights.moved(weights.matrices, [np.full_like(m, 0.5) for m in weights.matrices])
    network = weights.network(moved)
    assert isinstance(network, ValueNetwork)
    assert network.connections[0].transform == ((1.5, 0.0),) * 3
    assert network.connections[3].transform == 0.3
    assert network.connections[2].function == "positive"


def test_the_command_finds_transforms_and_refuses_in_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    sides = ValueNetwork(
        (Ensemble("sides", 40, 2),),
        (Input("in", 2),),
        (Connection("in", "sides", transform=((0.4, 0.4), (0.4, 0.4))),),
        (Probe("side", "sides"),),
    )
    write_network("n.toml", sides)
    labels = np.arange(40) % 2
    inputs = np.where(np.stack([labels == 0, labels == 1], axis=1), 0.8, 0.3)
    np.savez("s.npz", inputs=inputs, labels=labels, window_s=0.04)
    line = ["train", "n.toml", "--task", "s.npz", "-o", "t.toml", "--steps", "12", "--pace", "0.2"]
    assert main([*line, "--dies", "1", "--plot", "t.png", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["weights"], told["right_last"]) == (4, 1.0)
    for words in (["map", "t.toml", "--chip", "nef", "-o", "p.toml"], ["show", "p.toml", "--plot", "p.png"]):
        assert main(words) == 0
    assert "as train and certify count them: 0 'side[0]', 1 'side[1]'" in " ".join(
        capsys.readouterr().out.split()
    )
    Path("in.csv").write_text("time_s,channel,value\n0,0,0.8\n0,1,0.3\n", encoding="utf-8")
    assert main(["run", "p.toml", "--input", "in.csv", "--die", "1001", "--duration", "0.2s"]) == 0
    capsys.readouterr()
    write_network("m.toml", replace(sides, connections=(Connection("in", "sides"),)))
    for network, task, said in (
        ("m.toml", "s.npz", "connection: none with a transform in a matrix, which is trained; give it one"),
        ("n.toml", "CartPole-v1", "task: CartPole-v1, must be a FILE.npz"),
        ("n.toml", "odd.npz", "task.labels: sample 1 has 2, must be 0 to 1, the outputs"),
    ):
        np.savez("odd.npz", inputs=inputs, labels=labels + 1, window_s=0.04)
        assert main(["train", network, "--task", task, "-o", "u.toml"]) == 2
        assert said in capsys.readouterr().err
    assert not Path("u.toml").exists()
