"""PySpice circuits of ours, run by PySpice in ngspice, against the exported text and the solver."""

import numpy as np
import pytest
from PySpice.Spice.Netlist import Circuit as PySpiceCircuit

from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Capacitor, ControlledSource, Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import SimulatorError
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate as solve
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench
from netlists.ngspice import engine
from netlists.pyspice.write import OPTIONS, pyspice_simulator, to_pyspice

HALF_SUPPLY = 2.5  # V


def neuron() -> Testbench:
    stimuli = {"delay": 6.4e-3, "call": 1.0, "echo": 1.0, "duration": 8e-3}
    return rebound_neuron.testbench(rebound_neuron.build(), stimuli, 5.0)


def stages() -> Testbench:
    inner = Circuit(
        "stage",
        (Port("a", "analog"), Port("y", "analog", "out")),
        (
            Resistor("r", "a", "y", 1e3), Capacitor("c", "y", "0", 1e-9),
            ControlledSource("g", "y", "0", "a", "0", 1e-4), ControlledSource("h", "0", "y", "a", "0", 2e-4),
        ),
    )  # fmt: skip
    array = InstanceArray("stage", inner, (2,), {"a": "a", "y": "y"}, {"r.resistance": (1e3, 2e3)})
    circuit = Circuit("pair", (Port("a", "analog"), Port("k", "analog")), (Resistor("load", "k", "0", 1e6),),
                      (array,), (Node("y", (2,)),))  # fmt: skip
    sources = (
        Source("a", "a", PiecewiseLinear((-1e-6, 1e-6, 1.1e-6), (0.0, 1.0, 5.0))),
        Source("k", "k", Constant(1e-6), "current"),
    )
    return Testbench("pair of stages", circuit, sources, 10e-6)


@pytest.mark.usefixtures("ngspice_library")
def test_the_neuron_fires_when_the_exported_text_does() -> None:
    silicon, bench = Silicon(AMI_1500_IDEAL, die=Die("A", 9)), load_block("high-threshold-neuron").bench()
    text = engine.simulate(bench, silicon)
    analysis = to_pyspice(bench, silicon).transient()
    time, spike = np.asarray(analysis.time), np.asarray(analysis["spike"])
    found = engine.upward_crossings(time, spike, HALF_SUPPLY)
    assert found.size == text.spikes["spike"].size == 1
    assert found == pytest.approx(text.spikes["spike"], abs=1e-6)
    assert time[-1] == pytest.approx(bench.stop)


@pytest.mark.usefixtures("ngspice_library")
def test_arrays_resistors_and_controlled_sources_agree_with_the_solver() -> None:
    circuit = to_pyspice(stages(), Silicon(AMI_1500_IDEAL))
    ours = solve(stages(), Silicon(AMI_1500_IDEAL), rtol=1e-6)
    analysis = circuit.transient()
    for path in ("y[0]", "y[1]", "k"):
        theirs = np.interp(
            ours.time, np.asarray(analysis.time), np.asarray(analysis[circuit.run_names[path]])
        )
        # ngspice's step is 5 ns against time constants of 1 us: second order, 5 V (5e-3)^2
        np.testing.assert_allclose(theirs, ours[path], atol=1e-3)


def test_the_circuit_has_the_elements_of_the_text_and_plain_numbers() -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=60.0)
    circuit = to_pyspice(neuron(), silicon)
    theirs = [line.lower() for line in str(circuit).splitlines()]
    deck = format_testbench(neuron(), silicon).replace("\n+ ", " ").splitlines()
    ours = [line.lower() for line in deck if line[:1] in "bcrxg" and " " in line]
    assert len(ours) > 100
    assert set(ours) <= set(theirs)
    assert [s.name for s in circuit.subcircuits][-1] == "rebound_neuron"
    assert circuit.temperature_c == 60.0
    assert circuit["Vvdd"].dc_value == 5.0


def test_the_tolerances_are_those_of_the_text() -> None:
    deck = format_testbench(neuron(), Silicon(AMI_1500_IDEAL))
    assert all(f"{name}={value}" in deck for name, value in OPTIONS.items())


@pytest.mark.usefixtures("ngspice_library")
def test_a_start_is_handed_on() -> None:
    bench = neuron()
    circuit = to_pyspice(
        Testbench(bench.title, bench.circuit, bench.sources, bench.stop, start={"membrane.v_r": 3.1}),
        Silicon(AMI_1500_IDEAL),
    )
    assert ".nodeset v(xrebound_neuron.xmembrane.v_r)=3.1" in str(circuit.simulator()).lower()
    found = circuit.simulator().operating_point()
    assert float(np.asarray(found["v_mem"])[0]) == pytest.approx(1.802, abs=1e-3)


def divider() -> PySpiceCircuit:
    circuit = PySpiceCircuit("divider")
    circuit.V("in", "in", circuit.gnd, 5.0)
    circuit.R(1, "in", "out", 1e3)
    circuit.R(2, "out", circuit.gnd, 3e3)
    circuit.C(1, "out", circuit.gnd, 1e-9)
    return circuit


@pytest.mark.usefixtures("ngspice_library")
def test_any_circuit_of_pyspice_is_simulated() -> None:
    simulator = pyspice_simulator(divider(), 85.0, reltol=1e-6)
    assert float(np.asarray(simulator.operating_point()["out"])[0]) == pytest.approx(3.75)
    simulator.save("out")
    transient = simulator.transient(step_time=1e-6, end_time=1e-4)
    assert list(transient.nodes) == ["out"]
    sweep = pyspice_simulator(divider()).dc(Vin=slice(0, 4, 1))
    np.testing.assert_allclose(np.asarray(sweep["out"]), 0.75 * np.arange(5), rtol=1e-6)


@pytest.mark.usefixtures("ngspice_library")
def test_after_a_failure_the_next_run_works() -> None:
    bad = divider()
    bad.X("1", "missing", "in", "out")
    with pytest.raises(SimulatorError) as refused:
        pyspice_simulator(bad).operating_point()
    assert "\n" not in str(refused.value)
    assert float(np.asarray(pyspice_simulator(divider()).operating_point()["out"])[0]) == pytest.approx(3.75)
