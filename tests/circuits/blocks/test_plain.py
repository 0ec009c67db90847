"""A circuit or testbench gets what it lacks of a block by declared defaults, and is measured like any."""

import math

import numpy as np
import pytest

from circuits.blocks.arguments import Arguments, arguments_of, no_arguments
from circuits.blocks.block import Block
from circuits.blocks.plain import STOP, Made, block_of
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

PORTS = (Port("vdd", "supply"), Port("vss", "supply"), Port("v_in", "analog"), Port("v_b", "bias"))
SOURCE_FOLLOWER = Circuit(
    "source_follower",
    (*PORTS, Port("event", "event"), Port("v_out", "analog", "out")),
    (
        Transistor("m", "n", "vdd", "v_in", "v_out", "vss", 6e-6, 3e-6),
        Transistor("tail", "n", "v_out", "v_b", "vss", "vss", 6e-6, 3e-6),
        Transistor("pull", "n", "v_out", "event", "vss", "vss", 6e-6, 3e-6),
    ),
    biases=(Bias("i_b", "v_b", "gate", 10e-9, "tail"),),
)
RC = Circuit(
    "rc", (Port("v_in", "analog"),), (Resistor("r", "v_in", "v", 1e6), Capacitor("c", "v", "0", 1e-12))
)


def _block(made: Made) -> Block:
    return block_of("mine", lambda *_: made, no_arguments())


def _bench(*, step_V: float = 1.0, duration: float = 20e-6, v_dd: float = 5.0) -> Testbench:  # noqa: N803
    wave = PiecewiseLinear((0.0, 1e-6, 1.1e-6), (0.0, 0.0, step_V))
    return Testbench("rc", RC, (Source("v_in", "v_in", wave),), duration)


def test_every_input_of_a_circuit_is_driven() -> None:
    block = _block(SOURCE_FOLLOWER)
    assert [s.name for s in block.stimuli] == ["vdd", "vss", "v_in", "event", "duration"]
    bench = block.bench(v_in=2.0, event=1e-4)
    levels = {s.name: s.waveform for s in bench.sources}
    assert (levels["vdd"], levels["vss"]) == (Constant(AMI_1500.v_dd), Constant(0.0))
    assert bench.stop == STOP
    numbers = block.measured(simulate(bench))
    assert numbers["v_out_min_V"] < 0.2  # the event pulls it down
    assert numbers["v_out_last_V"] > 0.5
    assert block.bench(v_in=2.0, vdd=3.0).sources[0].waveform == Constant(3.0)


def test_an_input_that_nothing_drives_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match=r'v_in: nothing drives it.*Port\("v_in", "analog", "out"\)'):
        _block(SOURCE_FOLLOWER).bench()


def test_a_testbench_keeps_its_sources_and_its_end() -> None:
    given = _bench()
    block = _block(given)
    assert block.bench() == given
    assert block.bench(duration=5e-6).stop == 5e-6
    assert block.plotted == ("v",)
    numbers = block.measures(simulate(given))
    tau, t = 1e-6, 18.95e-6
    assert numbers["v_max_V"] == pytest.approx(1.0, abs=1e-3)
    assert numbers["v_mean_V"] == pytest.approx((t - tau) / 20e-6, abs=2e-3)


def test_knobs_of_a_function_turn_its_sources() -> None:
    block = _of_function(_bench)
    assert [s.name for s in block.stimuli] == ["step_V", "duration"]
    assert block.measures(simulate(block.bench(step_V=3.0)))["v_last_V"] == pytest.approx(3.0, abs=1e-3)


def test_sizes_reach_the_testbench() -> None:
    def bench(stretch: float = 1.0) -> Testbench:
        return Testbench("rc", RC, (Source("v_in", "v_in", Constant(stretch)),), 1e-6)

    block = _of_function(bench)
    double = type(block.sizes)(2.0)
    assert block.bench().sources[0].waveform == Constant(1.0)
    assert block.sized(double).bench().sources[0].waveform == Constant(2.0)


def test_a_knob_that_changes_the_circuit_is_refused() -> None:
    def bench(*, c_F: float = 1e-12) -> Testbench:  # noqa: N803
        devices = (RC.devices[0], Capacitor("c", "v", "0", c_F))
        return Testbench("rc", Circuit("rc", RC.ports, devices), _bench().sources, 1e-6)

    with pytest.raises(ParameterError, match=r"rc: a stimulus changes the circuit.*before the \*"):
        _of_function(bench).bench(c_F=2e-12)


def test_a_testbench_without_an_end_gets_one() -> None:
    endless = Testbench("rc", RC, _bench().sources, math.inf)
    assert _block(endless).bench().stop == STOP


def test_spikes_are_counted() -> None:
    ports = (Port("v_in", "analog"), Port("spike", "event", "out", threshold=0.5))
    circuit = Circuit("rc", ports, (Resistor("r", "v_in", "spike", 1e3), Capacitor("c", "spike", "0", 1e-12)))
    wave = PiecewiseLinear(tuple(np.arange(9) * 1e-5), (0.0, 1.0) * 4 + (0.0,))
    block = _block(Testbench("rc", circuit, (Source("v_in", "v_in", wave),), 8e-5, ("spike",)))
    result = simulate(block.bench())
    numbers = block.measures(result)
    assert numbers["spike_spikes"] == 4
    assert numbers["spike_first_s"] == pytest.approx(5e-6, rel=1e-2)
    assert numbers["spike_rate_Hz"] == pytest.approx(5e4, rel=1e-3)
    assert block.outcome(result) == "spikes"


def _of_function(function) -> Block:
    arguments: Arguments = arguments_of(function, knobs=True)
    return block_of("mine", lambda *given: function(**arguments.keywords(*given)), arguments)
