"""Training for silicon: the form against the equations and the chip, its way back, and the command."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from chips.aer import Events
from chips.rolls.circuit import FILTERS
from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import Program
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main
from system.mapping.certify.spiking import ChipPlayer
from system.mapping.chips import map_on
from system.mapping.dynamics import Cells, Dynamics, Filter, run
from system.mapping.network import Connection, Input, Network, Population, Probe
from system.mapping.network_file import read_network, write_network
from system.mapping.rolls.mapped import Mapped, Placed, PlacedFilter
from system.mapping.train.form import backward, form_of, forward
from system.mapping.train.ratios import Ratios, calibrated_form, nominal_ratios, ratios_of
from system.mapping.train.spiking import binned
from system.mapping.train.weights import trainable

RNG = np.random.default_rng(7)
TAU, WINDOW = 10e-3, 0.1


def matrix(rows: int, columns: int, most: float) -> tuple[tuple[float, ...], ...]:
    """Weights of both signs, more of them above 0."""
    return tuple(map(tuple, RNG.uniform(-0.3 * most, most, (rows, columns)).tolist()))


RECURRENT = Network(
    (Population("hidden", 12), Population("left", 3), Population("right", 3)),
    (Input("in", 5),),
    (
        Connection("in", "hidden", rule="matrix", tau=TAU, matrix=matrix(12, 5, 0.4)),
        Connection("hidden", "hidden", rule="matrix", tau=TAU, to_itself=False, matrix=matrix(12, 12, 0.2)),
        Connection("hidden", "left", rule="matrix", tau=TAU, matrix=matrix(3, 12, 0.4)),
        Connection("hidden", "right", rule="matrix", tau=TAU, matrix=matrix(3, 12, 0.4)),
    ),
    (Probe("goes left", "left"), Probe("goes right", "right")),
)


@pytest.fixture(scope="module")
def mapped() -> Mapped:
    """The recurrent network as if a chip had placed it: no bias is searched."""
    found = [
        Placed(p.name, first, False, 18e-3, 0.15, 40e-12, 2e-3, 50e-12)
        for p, first in zip(RECURRENT.populations, (0, 12, 15), strict=True)
    ]
    filters = tuple(PlacedFilter(name, TAU, 0.76, 80e-12, (1e-12,) * 4) for name in FILTERS)
    none, channels = np.zeros((NEURONS, NEURONS), np.int8), np.zeros((5, 18), np.int64)
    return Mapped(RECURRENT, tuple(found), filters, Program(none), channels, channels, ())


def spread(mapped: Mapped, rng: np.random.Generator) -> Ratios:
    """A die whose parts are off by a tenth."""
    one = nominal_ratios(mapped)

    def off(x: np.ndarray) -> np.ndarray:
        return np.asarray(x * np.exp(0.1 * rng.normal(size=x.shape)))

    return Ratios(
        off(one.rheobase), off(one.tau), off(one.refractory),
        {k: off(x) for k, x in one.filters.items()}, {k: off(x) for k, x in one.weights.items()},
    )  # fmt: skip


def test_forwards_it_is_the_equations_to_the_spike(mapped: Mapped) -> None:
    die = replace(spread(mapped, np.random.default_rng(1)), filters=nominal_ratios(mapped).filters)
    form, found = form_of(mapped, (die,)), trainable(mapped)
    on = found.on_dies(found.matrices, (die,))
    events = binned(np.array([[900.0, 400.0, 700.0, 0.0, 1200.0]]), WINDOW, round(WINDOW / 1e-4))
    count, _ = forward(form, on.weights, events, 1e-4)
    filters = tuple(
        Filter(bank.sign, TAU, w.neurons[0], w.channels[0], bank.power, bank.pivot)
        for bank, w in zip(form.banks, on.weights, strict=True)
    )
    cells = Cells(
        *(x[0, 0] for x in (form.cells.tau, form.cells.unit, form.cells.refractory)),
        form.cells.constant,
        form.cells.slope,
    )
    steps, channels = np.nonzero(events[:, 0])
    wanted = run(Dynamics(cells, filters), Events((steps + 0.5) * 1e-4, channels), WINDOW)
    assert count[0, 0].tolist() == np.bincount(wanted.neurons, minlength=18).tolist()
    assert count.sum() > 50


def test_backwards_it_tells_how_counts_change_with_the_weights(mapped: Mapped) -> None:
    rng = np.random.default_rng(2)
    dies = tuple(spread(mapped, rng) for _ in range(8))
    form, found = form_of(mapped, dies), trainable(mapped)
    events = binned(rng.uniform(300.0, 1500.0, (64, 5)), WINDOW, 125)
    on = found.on_dies(found.matrices, dies)
    count, tape = forward(form, on.weights, events, WINDOW / 125)
    by = backward(form, on.weights, tape, np.ones_like(count))
    for kind in (0, 1):  # weights from neurons, and from channels
        told = sum(float((g[kind] * w[kind]).sum()) for g, w in zip(by, on.weights, strict=True))
        ends = []
        for scale in (0.9, 1.1):
            other = [[x * (scale if k == kind else 1.0) for k, x in enumerate(w)] for w in on.weights]
            weights = tuple(type(w)(*o) for w, o in zip(on.weights, other, strict=True))
            ends.append(forward(form, weights, events, WINDOW / 125)[0].sum())
        assert told == pytest.approx((ends[1] - ends[0]) / 0.2, rel=0.1)  # a rate for spikes; ours


def test_a_matrix_is_moved_within_bounds_and_what_is_not_there_stays_away(mapped: Mapped) -> None:
    found = trainable(mapped)
    moved = found.moved(found.matrices, [np.full_like(m, 10.0) for m in found.matrices])
    network = found.network(moved)
    assert not np.diag(moved[1]).any()  # to_itself is off
    assert max(m.max() for m in moved[1:]) == np.abs(found.matrices[2]).max().clip(
        np.abs(found.matrices[3]).max()
    )
    assert [c.name for c in network.connections] == [c.name for c in RECURRENT.connections]


def test_what_all_synapses_of_a_die_share_is_calibrated_away(mapped: Mapped) -> None:
    one = nominal_ratios(mapped)
    strong = {k: 1.3 * x for k, x in one.weights.items()}
    found = calibrated_form(mapped, Ratios(one.rheobase, one.tau, one.refractory, one.filters, strong))
    for name, weights in found.weights.items():
        assert weights == pytest.approx(one.weights[name], rel=1e-6)


SIDES = Network(
    (Population("left", 8), Population("right", 8)),
    (Input("in", 2),),
    (
        Connection("in", "left", rule="matrix", tau=20e-3, matrix=((0.4, 0.1),) * 8),
        Connection("in", "right", rule="matrix", tau=20e-3, matrix=((0.2, 0.3),) * 8),
    ),
    (Probe("goes left", "left"), Probe("goes right", "right")),
)


def test_a_dies_neurons_fire_in_the_form_as_on_the_chip() -> None:
    on_chip, silicon = map_on("rolls", SIDES), Silicon(ROLLS_180, die=Die("A", 3))
    rates, found, one = np.array([[900.0, 700.0]]), trainable(on_chip), nominal_ratios(on_chip)
    counts = []
    for die in (one, ratios_of(on_chip)(silicon)):
        on = found.on_dies(found.matrices, (die,))
        count, _ = forward(form_of(on_chip, (die,)), on.weights, binned(rates, 0.4, 500), 0.8e-3)
        counts.append(count[0, 0])
    chip = ChipPlayer(on_chip, silicon, "generator", None)
    trains = chip._advance(chip._events(rates[0], 0.4), 0.4)
    off = counts[1] - np.bincount(trains.neurons, minlength=16)
    assert np.abs(off).max() <= 0.1 * counts[0].max()  # the mapping's bar
    assert off.std() < 0.3 * (counts[1] - counts[0]).std()  # most of what the die changes; ours


def test_the_command_finds_weights_and_refuses_in_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_network(
        "n.toml",
        replace(SIDES, connections=tuple(replace(c, matrix=((0.25, 0.25),) * 8) for c in SIDES.connections)),
    )
    labels = np.arange(40) % 2
    inputs = np.where(np.stack([labels == 0, labels == 1], axis=1), 900.0, 500.0)
    np.savez("s.npz", inputs=inputs, labels=labels, window_s=0.08)
    line = ["train", "n.toml", "--task", "s.npz", "-o", "t.toml", "--dies", "0", "--steps", "15", "--json"]
    assert main([*line, "--pace", "0.3", "--plot", "t.png"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["weights"], told["right_first"] < 0.8, told["right_last"]) == (32, True, 1.0)
    left = np.array(read_network("t.toml").connections[0].matrix)
    assert (left[:, 0] > left[:, 1]).all()
    for wrong, text in (
        (["--task", "s.npz", "--dies", "1001"], "dies: 1001, must be"),
        (["--task", "s.npz", "--seed", str(1 << 64)], "seed: 1.84467e+19, must be >= 0"),
        (["--task", "CartPole-v1"], "task: CartPole-v1, must be a FILE.npz"),
    ):
        assert main(["train", "n.toml", *wrong, "-o", "u.toml"]) == 2
        assert text in capsys.readouterr().err
    np.savez("s.npz", inputs=inputs, labels=labels + 1)
    assert main(line) == 2
    assert "task.labels: sample 1 has 2, must be 0 to 1, the outputs" in capsys.readouterr().err
    assert not Path("u.toml").exists()
