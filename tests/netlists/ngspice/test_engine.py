"""ngspice as an engine: results in the solver's form, names, spikes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Capacitor, Diode, Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import SimulatorError
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Voltage
from circuits.lowering.kernel import to_kernel
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, DiodeVariation
from circuits.silicon.silicon import Silicon
from circuits.solver import operating_point as native
from circuits.solver.outcome import Outcome
from circuits.solver.transient import simulate as solve
from circuits.testbench import Testbench
from netlists.ngspice import engine

pytestmark = pytest.mark.usefixtures("ngspice_library")
SILICON = Silicon(AMI_1500_IDEAL)
RC = 1e-6  # s


def low_pass(port: str = "a", node: str = "y") -> Circuit:
    devices = (Resistor("r", port, node, 1e3), Capacitor("c", node, "0", 1e-9))
    return Circuit("low_pass", (Port(port, "analog"), Port(node, "event", "out")), devices)


def step(circuit: Circuit, stop: float = 10e-6) -> Testbench:
    drive = Source("drive", circuit.ports[0].name, PiecewiseLinear((1e-6, 1.001e-6), (0.0, 5.0)))
    return Testbench("step", circuit, (drive,), stop, watch=(circuit.ports[1].name,))


def test_a_step_follows_the_closed_form() -> None:
    result = engine.simulate(step(low_pass()), SILICON)
    assert result.outcome is Outcome.DONE
    assert result.nodes == ("0", "a", "y")
    assert result.steps.accepted == result.time.size - 1
    assert (np.diff(result.time) > 0.0).all()
    expected = 5.0 * -np.expm1(-np.maximum(result.time - 1.0005e-6, 0.0) / RC)
    # half the edge, 0.5 ns, against RC: 2.5 mV; outside the edge itself 1e-4 of 5 V
    np.testing.assert_allclose(result["y"], expected, atol=3e-3)
    assert result.spikes["y"] == pytest.approx([1.0005e-6 + RC * np.log(2.0)], abs=1e-9)
    assert result.operating_point["y"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["time", "temper", "limit", "v", "i", "all", "params", "dc", "x1", "E5"])
def test_nodes_may_be_called_like_words_of_spice(name: str) -> None:
    ours = solve(step(low_pass(name, "y")), SILICON, rtol=1e-6)
    result = engine.simulate(step(low_pass(name, "y")), SILICON)
    assert result.nodes == ours.nodes
    assert result["y"][-1] == pytest.approx(ours["y"][-1], abs=1e-3)
    assert result[name][-1] == pytest.approx(5.0)
    inner = engine.simulate(step(low_pass("a", name)), SILICON)
    assert inner[name][-1] == pytest.approx(ours["y"][-1], abs=1e-3)


def test_nodes_of_arrays_come_back_under_our_paths() -> None:
    cell = Circuit(
        "cell",
        (Port("a", "analog"), Port("y", "analog", "out")),
        (
            Resistor("r", "a", "tap[0]", 1e3),
            Resistor("s", "tap[0]", "tap[1]", 1e3),
            Resistor("t", "tap[1]", "y", 1e3),
            Resistor("u", "y", "0", 1e3),
        ),
        nodes=(Node("tap", (2,)),),
    )
    values = np.array([1e3, 3e3, 5e3])
    bank = InstanceArray("cell", cell, (3,), {"a": "a", "y": "y"}, {"r.resistance": values})
    circuit = Circuit("bank", (Port("a", "analog"), Port("y", "analog", "out", (3,))), (), (bank,))
    testbench = Testbench("bank", circuit, (Source("a", "a", Constant(4.0)),), 1e-3)
    found = engine.operating_point(testbench, SILICON)
    expected = native.operating_point(testbench, SILICON).voltages()
    assert found == pytest.approx({name: expected[name] for name in found}, abs=1e-6)
    assert found["cell[2].tap[1]"] == pytest.approx(4.0 * 2.0 / 8.0, abs=1e-6)
    assert found["y[0]"] == pytest.approx(1.0, abs=1e-6)


def test_a_block_s_measures_work_on_the_result() -> None:
    block = load_block("rebound-neuron")
    stimuli = block.defaults | {"echo": None, "duration": 2e-3}
    testbench = block.testbench(block.build(), stimuli, 5.0)
    result = engine.simulate(testbench, SILICON, reltol=1e-4)
    ours = solve(testbench, SILICON)
    assert result.nodes == ours.nodes
    assert block.outcome(result) == block.outcome(ours) == "none"
    measured, expected = block.measured(result), block.measured(ours)
    assert measured["t_inh_s"] is None
    # a loose run of 0.2 s of CPU: the energy of two edges and of the rest to a percent
    assert measured["supply_power_W"] == pytest.approx(expected["supply_power_W"], rel=1e-2)
    assert result.operating_point.stable


def test_the_start_chooses_among_rest_states() -> None:
    block = load_block("first-target-isolation")
    stimuli = block.defaults
    testbench = block.testbench(block.build(), stimuli, 5.0)
    assert testbench.start
    ours = native.operating_point(testbench, SILICON)
    found = engine.operating_point(testbench, SILICON)
    assert max(abs(found[n] - v) for n, v in ours.voltages().items()) < 1e-4


@pytest.mark.parametrize(
    ("voltage", "expected"),
    [
        ([0.0, 1.0, 2.0, 3.0], [2.5]),
        ([0.0, 5.0, 2.2, 5.0], [0.5]),  # 2.2 V is above 0.8 of the threshold: not armed again
        ([0.0, 5.0, 1.9, 5.0], [0.5, 2.0 + 0.6 / 3.1]),
        ([5.0, 4.0, 3.0, 4.0], []),
        ([5.0, 2.4, 5.0, 5.0], [1.0 + 0.1 / 2.6]),
        ([0.0, 2.5, 2.5, 5.0], [1.0]),
    ],
)
def test_spikes_are_upward_crossings(voltage: list[float], expected: list[float]) -> None:
    time = np.arange(4.0)
    np.testing.assert_allclose(engine.upward_crossings(time, np.array(voltage), 2.5), expected)
    np.testing.assert_allclose(engine.upward_crossings(time, np.array(voltage), 2.5, 2.0), expected)


def test_a_deadline_halts_the_run() -> None:
    with pytest.raises(SimulatorError, match=r"not done after 0.05 s"):
        engine.simulate(step(low_pass(), 10.0), SILICON, tmax=1e-7, deadline_s=0.05)


def test_a_current_flows_into_the_node() -> None:
    circuit = Circuit("c", (Port("x", "analog"),), (Resistor("r", "x", "0", 1e6),))
    testbench = Testbench("c", circuit, (Source("k", "x", Constant(2e-6), "current"),), 1e-3)
    assert engine.operating_point(testbench, SILICON)["x"] == pytest.approx(2.0, rel=1e-6)
    ramp = replace(
        testbench, sources=(Source("k", "x", PiecewiseLinear((0.0, 1e-3), (0.0, 2e-6)), "current"),)
    )
    result = engine.simulate(ramp, SILICON)
    assert result["x"][-1] == pytest.approx(2.0, rel=1e-6)
    assert result.operating_point.voltage[result.machine.kernel.unknowns] == pytest.approx(0.0)


def test_diodes_of_a_die_and_their_gradient_are_those_of_ngspice() -> None:
    devices = (
        Diode("d", "a", "o", area=4.0, saturation_current=1e-15),
        Diode("e", "o", "0", saturation_current=1e-15),
        Resistor("r", "o", "0", 1e6),
    )
    circuit = Circuit("chain", (Port("a", "supply"), Port("o", "analog", "out")), devices)
    bench = Testbench("chain", circuit, (Source("v", "a", Constant(1.2)),), 1e-6)
    silicon = Silicon(replace(AMI_1500_IDEAL, diodes=DiodeVariation(0.1, 0.1)), die=Die(number=1003))
    ours, theirs = native.operating_point(bench, silicon)["o"], engine.operating_point(bench, silicon)["o"]
    assert theirs == pytest.approx(ours, abs=1e-7)
    assert abs(ours - native.operating_point(bench, replace(silicon, die=Die()))["o"]) > 1e-4
    found = gradients_of(to_kernel(bench, silicon), (Voltage("o"),))
    shift = 0.2
    for name, area in (("d", 4.0), ("e", 1.0)):
        label = f"chain.{name}.saturation_current"
        # by_hand sets the diode's own part, beside what all of the die share
        dies = [silicon.die.with_(f"chain.{name}", "saturation_current", s) for s in (shift, -shift)]
        points = [engine.operating_point(bench, replace(silicon, die=die)) for die in dies]
        sides = [to_kernel(bench, replace(silicon, die=die)).kernel.diodes.saturation for die in dies]
        k = 0 if name == "d" else 1
        by_log = (points[0]["o"] - points[1]["o"]) / np.log(sides[0][k] / sides[1][k])
        at = to_kernel(bench, silicon).kernel.diodes.saturation[k] / area
        assert found.by[0, found.labels.index(label)] * at == pytest.approx(by_log, rel=2e-3)
