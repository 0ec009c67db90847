"""Chips in the event loop say what their whole-run kernels say, to the bit."""

from __future__ import annotations

import math
import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from chips.aer import IDLE, Bus, send, send_on
from chips.latency.chip import LatencyChip
from chips.latency.errors import usual_design
from chips.latency.part import LatencyPart
from chips.nef.build import build
from chips.nef.chip import NefChip
from chips.nef.network.network import Connection, Ensemble, Network, Node, Probe
from chips.nef.part import NefPart
from chips.nef.simulation import Simulation
from chips.noise import SiliconNoise
from chips.part import Event, Output, Part, port_index, quiet
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.part import RollsPart
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from chips.wavefront.chip import ChipCells, WavefrontChip
from chips.wavefront.part import WavefrontPart
from circuits.devices.source import Polyline
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.loop import AnalogWire, EventWire, Loop


@dataclass(frozen=True, slots=True)
class Script:
    """Sends events at set times; a line of its own is on its analog port."""

    events: tuple[Event, ...]
    line: Polyline = (np.zeros(1), np.zeros(1))
    analog: tuple[str, ...] = ("line",)

    def begin(self, time: float = 0.0) -> float:
        return time - 1e-12  # so that events of the first moment are sent

    def next_time(self, state: float) -> float:
        return min((t for _, t in self.events if t > state), default=math.inf)

    def advance(
        self,
        state: float,
        until: float,
        events: Sequence[Event] = (),
        analog: Mapping[str, Polyline] | None = None,
    ) -> tuple[float, float, Output]:
        reached = min(until, self.next_time(state))
        found = tuple(e for e in self.events if state < e[1] <= reached)
        inside = self.line[0][(self.line[0] > state) & (self.line[0] < reached)]
        times = np.array([state, *inside, max(reached, np.nextafter(state, np.inf))])
        return reached, reached, Output(found, times, np.interp(times, *self.line)[:, None])


def looped(
    part: Part[Any], events: Sequence[Event], until: float, horizon: float = 1e-3
) -> tuple[list[Event], Any]:
    """What a part says to events in the loop, and its last state, through a pickle at every round."""
    wires = [EventWire("script", port, "part", port) for port in {port for port, _ in events}]
    loop = Loop({"script": Script(tuple(events)), "part": part}, wires, [], horizon=horizon)
    said: list[Event] = []
    while loop.time < until:
        done = loop.step(until)
        said += [(port, time) for name, port, time in done.events if name == "part"]
        loop.states["part"] = pickle.loads(pickle.dumps(loop.states["part"]))
    return said, loop.states["part"]


def test_a_wave_in_the_loop_is_the_plan_s() -> None:
    cells = ChipCells(Silicon(die=Die(number=3)), noise=SiliconNoise(seed=1))
    chip = WavefrontChip(6, 5, cells=cells)
    program = chip.program(np.random.default_rng(1).integers(1, 9, (6, 5)))
    part = WavefrontPart(chip, program, goal=(5, 4))
    said, state = looped(part, [("start[7]", 1e-5), ("start[0]", 2e-3)], 4e-3)
    expected: list[Event] = []
    for number, (start, time) in enumerate((((1, 2), 1e-5), ((0, 0), 2e-3))):
        spikes = chip.plan(program, start, (5, 4), time=time, number=number).events()
        each = zip(spikes.times.tolist(), spikes.addresses.tolist(), strict=True)
        expected += [(f"fired[{k}]", time + t) for t, k in each]
    assert len(expected) > 20
    assert said == expected
    assert (state.waves, state.due) == (2, ())


def test_a_wave_starts_at_a_cell_of_the_chip() -> None:
    chip = WavefrontChip(2, 2)
    part = WavefrontPart(chip, chip.program(np.ones((2, 2), np.int64)))
    for port in ("start[4]", "goal[0]", "start[-1]", "start"):
        with pytest.raises(UnknownNameError, match=r"wavefront_chip event port .*known are start\[0\]"):
            part.advance(part.begin(), 1e-3, [(port, 0.0)])


@pytest.mark.parametrize("noise", [None, SiliconNoise(seed=2)])
def test_a_ping_in_the_loop_is_the_chip_s(noise: SiliconNoise | None) -> None:
    chip = LatencyChip(usual_design(), silicon=Silicon(die=Die(number=5)), noise=noise)
    first = [("onset", 0.1), ("goal[16]", 0.105), ("direction[2]", 0.11)]
    heard = ((14, 0.108), (15, 0.109), (16, 0.107), (17, 0.109), (18, 0.108))
    first += [(f"memory[{p}]", t) for p, t in heard]
    events = [*first, ("onset", 0.8), ("reset", 1.5), ("onset", 1.55)]
    said, state = looped(LatencyPart(chip), events, 2.3, horizon=0.05)
    a, memory = chip.addresses, chip.new_memory()
    chip.reset(memory, 0.0)
    words = [a.onset, a.goal + 16, a.direction + 2, 14, 15, 16, 17, 18]
    expected: list[Event] = []
    for start in (0.1, 0.8, 1.55):
        if start > 1.5:
            chip.reset(memory, 1.5)
        times = np.array([t - 0.1 for _, t in first]) if start == 0.1 else np.zeros(1)
        found = chip.ping(memory, start, times, np.array(words[: times.size]))
        each = zip(found.times.tolist(), found.paths.tolist(), strict=True)
        expected += sorted(((f"winner[{p}]", start + t) for t, p in each), key=lambda e: e[1])
    assert len(expected) >= 3  # one a ping
    assert said == expected
    np.testing.assert_array_equal(LatencyPart(chip).said(state).integrating, found.integrating)


def test_what_comes_before_an_onset_is_counted_and_a_memory_must_be_there() -> None:
    part = LatencyPart(LatencyChip(usual_design()))
    state, _, _ = part.advance(part.begin(), 1e-3, [("memory[3]", 0.0)])
    assert state.unheard == 1
    with pytest.raises(UnknownNameError, match=r"latency_chip event port memory\[99\]"):
        part.advance(part.begin(), 1e-3, [("onset", 0.0), ("memory[99]", 1e-4)])


def test_units_of_transistors_have_no_place_in_the_loop() -> None:
    chip = LatencyChip(usual_design())
    chip.units[0, 0] = None  # type: ignore[assignment]
    with pytest.raises(ParameterError, match=r"latency_chip\.units: 1, must be none in a loop"):
        LatencyPart(chip)


def network(noise: SiliconNoise | None = None) -> Any:
    """A value and its square, on a die of the NEF chip."""
    net = Network(
        (Ensemble("x", 40), Ensemble("square", 40)),
        (Node("in", 2), Node("clock", 1, output=lambda t, _: [t])),
        (Connection("in", "x", transform=[[1.0, 0.5]]), Connection("x", "square", np.square)),
        (Probe("x?", "x", synapse=0.02), Probe("square?", "square", synapse=0.02)),
    )
    return build(net, NefChip(noise=noise).at(27.0), 1)


@pytest.mark.parametrize("noise", [None, SiliconNoise(seed=4)])
def test_a_network_in_the_loop_is_the_simulation(noise: SiliconNoise | None) -> None:
    built = network(noise)
    line = np.array([0.0, 0.1]), np.array([-0.8, 0.9])
    part = NefPart(built, ("x?", "square?"), interval=2e-3)
    parts: dict[str, Part[Any]] = {"script": Script((), line), "part": part}
    loop = Loop(parts, [], [AnalogWire("script", "line", "part", "in[1]", tolerance=0.0)], horizon=3.3e-3)
    run, shown = Simulation(built, 2e-3), []
    while loop.time < 0.1:
        shown += list(loop.step(0.1).outputs["part"].voltage[1:])
        loop.states["part"] = pickle.loads(pickle.dumps(loop.states["part"]))
    for k in range(50):
        run.set("in", [0.0, np.interp(2e-3 * k, *line)])
        run.advance(2e-3)
    state = loop.states["part"]
    assert state.intervals == 50
    np.testing.assert_array_equal(state.simulation.base.spikes, run.state.spikes)
    assert run.spikes > 100
    np.testing.assert_array_equal(shown[-1], [*run.read("x?"), *run.read("square?")])
    assert part.analog == ("x?[0]", "square?[0]")


def test_a_network_knows_its_nodes_and_probes() -> None:
    built = network()
    with pytest.raises(UnknownNameError, match="nef_chip probe y"):
        NefPart(built, ("y",))
    part = NefPart(built, ("x?",))
    line = np.zeros(1), np.zeros(1)
    with pytest.raises(UnknownNameError, match="nef_chip node out: unknown; known are clock, in"):
        part.advance(part.begin(), 1e-3, (), {"out[0]": line})
    with pytest.raises(UnknownNameError, match="nef_chip event port spike"):
        part.advance(part.begin(), 1e-3, [("spike", 0.0)])


def test_a_rolls_chip_in_the_loop_is_its_run() -> None:
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    levels[:40, 7], levels[40:50, :30] = 2, 1
    biases = default_biases().with_code("IF_DC_P", 5, 150)
    # a bus on which events wait for each other across steps
    silicon = Silicon(ROLLS_180, 27.0, Die(number=1003))
    chip = RollsChip(Program(levels, biases), silicon, bus=Bus(service=20e-6, depth=40))
    times = np.sort(np.random.default_rng(3).uniform(1e-3, 20e-3, 400))
    neurons = np.arange(400) % 40
    columns = np.full(400, 256 + 7)
    whole, after = chip.run(chip.at_rest(), 24e-3, Inputs(times, neurons, columns))
    words = neurons + (columns << 8)
    events = [(f"in[{w}]", t) for w, t in zip(words.tolist(), times.tolist(), strict=True)]
    said, state = looped(RollsPart(chip), events, 24.001e-3, horizon=0.7e-3)
    each = zip(whole.times.tolist(), whole.neurons.tolist(), strict=True)
    # on their way out when the run ends are the last ones
    assert [*said, *state.due] == [(f"out[{k}]", t) for t, k in each]
    assert len(said) > 100
    assert whole.lost_out > 0
    assert (state.lost_in, state.lost_out) == (whole.lost_in, whole.lost_out)
    np.testing.assert_array_equal(state.chip.values[:, :5], after.values[:, :5])


def test_a_bus_that_is_sent_on_twice_is_one_bus() -> None:
    draw = np.random.default_rng(0)
    times, addresses = np.sort(draw.uniform(0.0, 1e-3, 300)), draw.integers(0, 9, 300)
    bus = Bus(service=5e-6, depth=20)
    whole = send(bus, times, addresses)
    line, found = IDLE, []
    for part in np.array_split(np.arange(300), 17):
        events, line = send_on(bus, line, times[part], addresses[part])
        found.append(events)
    np.testing.assert_array_equal(np.concatenate([e.times for e in found]), whole.times)
    np.testing.assert_array_equal(np.concatenate([e.addresses for e in found]), whole.addresses)
    assert sum(e.dropped for e in found) == whole.dropped > 0


def test_an_element_of_a_port_is_its_number() -> None:
    assert port_index("spike[12]", "spike", 13, "chip") == 12
    with pytest.raises(UnknownNameError, match=r"chip event port spike\[13\]"):
        port_index("spike[13]", "spike", 13, "chip")
    assert replace(quiet(1.0), events=(("a", 1.0),)).events
