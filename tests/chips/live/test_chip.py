"""Chips that are driven live do as in a run; states and biases are written; what is none is refused."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from chips.aer import Bus
from chips.live.chip import LiveChip
from chips.live.loopback import LoopbackEngine
from chips.live.nef import NefEngine
from chips.live.rolls import RollsEngine
from chips.live.table import live_names, open_chip
from chips.nef.simulation import Simulation
from chips.ranging.chip import RangingChip
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.arrays import I64, Bools
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from tests.chips.looped import looped
from tests.chips.nef.test_part import network

DIE = Die("A", 1001)


def rolls_chip(bus: Bus | None = None) -> RollsChip:
    """Forty neurons that an input drives, and ten that they drive."""
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    levels[:40, 7], levels[40:50, :30] = 2, 1
    biases = default_biases().with_code("IF_DC_P", 5, 150)
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003))
    return RollsChip(Program(levels, biases), silicon, bus=bus)


def test_a_rolls_chip_that_is_driven_in_pieces_is_its_run() -> None:
    chip = rolls_chip(Bus(service=20e-6, depth=40))
    times = np.sort(np.random.default_rng(3).uniform(1e-3, 20e-3, 400))
    neurons, columns = np.arange(400) % 40, np.full(400, 256 + 7)
    whole, _ = chip.run(chip.at_rest(), 24e-3, Inputs(times, neurons, columns))
    live = LiveChip(RollsEngine(chip), "rolls")
    live.send(times[:200], (neurons + (columns << 8))[:200])
    told = [live.advance(1.3e-3) for _ in range(5)]
    live.state = pickle.loads(pickle.dumps(live.state))
    assert times[200] >= live.time
    live.send(times[200:], (neurons + (columns << 8))[200:])
    told += [live.advance(2.5e-3) for _ in range(7)]
    late = live.state.inner.due  # what is on its way when the run ends
    found = (
        np.concatenate([*(t.times for t in told), late[0]]),
        np.concatenate([*(t.addresses for t in told), late[1]]),
    )
    # a piece counts its steps from its own beginning, which rounds otherwise
    assert np.allclose(found[0], whole.times, rtol=0.0, atol=1e-12)
    assert np.array_equal(found[1], whole.neurons)
    assert live.lost == {"lost_in": whole.lost_in, "lost_out": whole.lost_out, "held": whole.held}
    assert whole.lost_out > 0


def test_a_bias_of_rolls_is_written_while_it_runs() -> None:
    live = LiveChip(RollsEngine(rolls_chip()), "rolls")
    before = live.read_bias("IF_DC_P")
    rate = live.advance(20e-3).times.size
    assert live.write_bias("IF_DC_P", 3.0 * before) == pytest.approx(3.0 * before, rel=0.01)
    assert live.time == pytest.approx(20e-3)
    assert live.advance(20e-3).times.size > 1.5 * rate
    with pytest.raises(ParameterError, match="IF_DC_P: 0 A, must be above 0"):
        live.write_bias("IF_DC_P", 0.0)


def test_the_ranging_chip_answers_as_in_a_loop() -> None:
    live = open_chip("ranging-chip", DIE)
    live.send([1e-3, 9e-3], [live.address("call"), live.address("echo")])
    told = [live.advance(7e-3) for _ in range(5)]
    said, _ = looped(RangingChip(Silicon(die=DIE)), [("call", 1e-3), ("echo", 9e-3)], 35e-3)
    found = [(f"spike[{a}]", t) for each in told for t, a in zip(each.times, each.addresses, strict=True)]
    assert len(said) > 3
    assert [port for port, _ in found] == [port for port, _ in said]
    # the loop stops every millisecond, and a stop moves the steps that come after it
    assert np.allclose([t for _, t in found], [t for _, t in said], rtol=0.0, atol=1e-6)


def test_a_state_that_was_kept_is_put_back() -> None:
    live = open_chip("ranging-chip", DIE)
    live.advance(5e-3)
    kept = pickle.loads(pickle.dumps(live.state))
    first = live.advance(20e-3)
    live.write_bias("i_rtau", 5e-10)
    live.state = kept
    assert live.read_bias("i_rtau") == pytest.approx(4e-10)
    assert np.array_equal(live.advance(20e-3).times, first.times)


def test_a_wave_starts_where_an_event_says_and_follows_its_unit() -> None:
    live = open_chip("wavefront-chip", DIE, costs=np.full((3, 3), 3))
    live.send(live.time, [4])
    first = live.advance(5e-3)
    assert first.addresses[0] == 4
    assert sorted(first.addresses.tolist()) == list(range(9))
    live.write_bias("unit", 2.0 * live.read_bias("unit"))
    live.send(live.time, [4])
    second = live.advance(5e-3)
    ratio = (second.times[1:] - 5e-3).mean() / first.times[1:].mean()
    assert ratio == pytest.approx(2.0, rel=0.05)
    assert live.lost["waves"] == 2


def test_a_network_on_the_nef_chip_is_its_simulation() -> None:
    built = network()
    live, run = LiveChip(NefEngine(built, ("x?",)), "nef-chip"), Simulation(built)
    live.drive("in", [0.8, 0.0])
    run.set("in", [0.8, 0.0])
    told = [live.advance(25e-3) for _ in range(4)]
    run.advance(0.1)
    counts = np.bincount(np.concatenate([t.addresses for t in told]), minlength=80)
    assert np.array_equal(counts, run.state.spikes)
    assert np.array_equal(live.show()["x?"], run.read("x?"))
    assert live.lost["spikes"] == run.counters["spikes"]
    assert np.array_equal(run.snapshot().base.y, live.state.inner.base.y)
    with pytest.raises(ParameterError, match=r"nef-chip\.address: 0, not on the chip; it has none"):
        live.send(live.time, [0])
    with pytest.raises(UnknownNameError, match="nef-chip line out: unknown; known are clock, in"):
        live.drive("out", 1.0)


def test_a_wire_gives_back_what_it_is_sent() -> None:
    live = open_chip("loopback")
    live.send([1e-3, 2e-3], [7, 2**31 - 1])
    assert live.advance(2e-3).addresses.tolist() == [7]
    assert live.advance(1e-3).addresses.tolist() == [2**31 - 1]
    assert live.lost == {"events": 2}
    with pytest.raises(ParameterError, match=r"loopback\.address: 2147483648, not on the chip"):
        live.send(live.time, [2**31])


class Shut(LoopbackEngine):
    """A wire without an open end."""

    def takes(self, addresses: I64) -> Bools:
        return np.zeros(addresses.shape, dtype=np.bool_)


def test_a_plastic_synapse_that_is_not_latched_is_refused_at_once() -> None:
    latches = np.zeros((NEURONS, NEURONS), dtype=np.bool_)
    latches[3, 8] = True
    program = replace(rolls_chip().program, plastic=PlasticArray(latches))
    engine = RollsEngine(RollsChip(program, Silicon(ROLLS_180_IDEAL)))
    addresses = np.array([3 + (8 << 8), 4 + (8 << 8), 7 + (256 << 8), 7 + (512 << 8), -1])
    assert engine.takes(addresses).tolist() == [True, False, True, False, False]
    with pytest.raises(ParameterError, match=r"^wire\.address: 5, a synapse that is not latched; set it"):
        LiveChip(Shut(), "wire").send(0.0, [5])


@pytest.mark.parametrize(
    ("times", "addresses", "told"),
    [
        ([0.001], [0], r"^ranging-chip\.times\[0\]: 0\.001 s, must not be before the chip's time, 0\.005 s$"),
        ([0.2, 0.1], [0, 1], r"times\[1\]: 0\.1 s, must not be before the one before, 0\.2 s$"),
        ([np.nan], [0], r"times\[0\]: nan s"),
        ([0.2], [2], r"address: 2, not on the chip; it has 0 to 0 \(call\), 1 to 1 \(echo\)$"),
        ([0.2], [-1], r"address: -1, not on the chip"),
        ([0.2], [0.5], r"addresses: float64 numbers, must be whole numbers$"),
        ([0.2, 0.3], [0], r"send: 2 times and 1 addresses, must be as many$"),
    ],
)
def test_a_stream_that_is_none_is_refused_and_changes_nothing(times: Any, addresses: Any, told: str) -> None:
    live = open_chip("ranging-chip", DIE)
    live.advance(5e-3)
    with pytest.raises(ParameterError, match=told):
        live.send(times, addresses)
    assert live.state.train[0].size == 0


def test_what_cannot_be_opened_or_is_not_there_says_so() -> None:
    with pytest.raises(
        UnknownNameError, match="live chip lso: unknown; known are loopback, nef-chip, ranging-chip"
    ):
        open_chip("lso")
    with pytest.raises(ParameterError, match=r"^rolls: missing 1 required.*'program'; see open_chip$"):
        open_chip("rolls")
    live = open_chip("ranging-chip", DIE)
    with pytest.raises(ParameterError, match="advance: 0 s, must be above 0"):
        live.advance(0.0)
    with pytest.raises(UnknownNameError, match="ranging-chip bias i_x"):
        live.write_bias("i_x", 1e-9)
    with pytest.raises(ParameterError, match=r"neuron\[13\]: must be 0 to 12$"):
        live.address("neuron", 13)
    with pytest.raises(ParameterError, match="degC"):
        live.warm(500.0)
    assert set(live_names()) >= {"rolls", "nef-chip", "ranging-chip", "wavefront-chip"}
