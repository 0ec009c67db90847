"""Runs leave rest states that are not stable, and begin with the voltages that are held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Instance, InstanceArray, Port
from circuits.devices import Capacitor, Resistor, Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError, UnknownNameError
from circuits.lowering.kernel import on_die, to_kernel
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver.batch import map_dies
from circuits.solver.beginning import Disturbed, beginning, disturbance
from circuits.solver.noise.transient import NoiseRun, simulate_noisy
from circuits.solver.operating_point import NUDGE, operating_point
from circuits.solver.transient import Runner, simulate
from circuits.testbench import Testbench
from tests.circuits.solver.examples import SUPPLY, TAU, V_DD, C, R, inverter, latch, low_pass, neuron
from tests.circuits.solver.oscillators import OSCILLATORS

ALL = OSCILLATORS["oscillators"]()
DIES = tuple(Die(number=k) for k in range(1000, 1004))


@pytest.mark.parametrize("k", range(len(ALL)))
def test_an_oscillator_starts_by_itself_and_says_how(k: int) -> None:
    bench = ALL[k].testbench
    result = simulate(bench, Silicon(ALL[k].process))
    assert not result.operating_point.stable
    assert result.disturbance is not None
    (node,) = result.disturbance.nodes
    assert result[node][0] - result.operating_point[node] == pytest.approx(NUDGE)
    assert node in str(result.disturbance)
    assert "10 mV" in str(result.disturbance)
    assert result.spikes["spike"].size >= 6


def test_a_neuron_with_a_constant_current_fires_on_every_die() -> None:
    neuron = ALL[0]
    machine = to_kernel(neuron.testbench, Silicon(neuron.process))
    runs = [s.value for s in map_dies(simulate, machine, DIES, workers=1)]
    assert all(run is not None and run.spikes["spike"].size >= 4 for run in runs)


def test_a_run_stays_where_it_is_at_rest_when_told_so() -> None:
    oscillator = ALL[1]
    for result in (
        simulate(oscillator.testbench, Silicon(oscillator.process), at_rest=True),
        simulate(replace(oscillator.testbench, begin="at_rest"), Silicon(oscillator.process)),
    ):
        assert result.disturbance is None
        assert result.spikes["spike"].size == 0
        assert not result.operating_point.stable


def test_every_engine_of_runs_begins_beside_the_unstable_state() -> None:
    oscillator = ALL[1]
    machine = to_kernel(oscillator.testbench, Silicon(oscillator.process))
    runner, point = Runner(machine), operating_point(machine)
    with pytest.warns(Disturbed, match="ring of 3: .* not stable: the run begins with 10 mV added at spike"):
        state = runner.begin(point)
    assert np.abs(state.voltage[0] - point.voltage).max() == pytest.approx(NUDGE)


def test_a_disturbance_is_the_same_on_any_number_of_workers() -> None:
    oscillator = ALL[2]
    machine = to_kernel(oscillator.testbench, Silicon(oscillator.process))
    alone, together = (map_dies(simulate, machine, DIES, workers=w) for w in (1, 4))
    for one, other in zip(alone, together, strict=True):
        assert one.value is not None
        assert other.value is not None
        np.testing.assert_array_equal(one.value.voltage, other.value.voltage)
        assert one.value.disturbance == other.value.disturbance


def test_each_of_several_oscillators_is_disturbed() -> None:
    inner = ALL[1].testbench.circuit
    pair = Circuit(
        "pair",
        (Port("vdd", "supply"), Port("spike", "event", "out", (2,))),
        instances=(InstanceArray("ring", inner, (2,), {"vdd": "vdd", "spike": "spike"}),),
    )
    bench = Testbench("pair", pair, ALL[1].testbench.sources, ALL[1].testbench.stop, ("spike",))
    result = simulate(bench, Silicon(ALL[1].process))
    assert result.disturbance is not None
    assert result.disturbance.nodes == ("spike[0]", "spike[1]")
    assert all(times.size >= 6 for times in result.spikes.values())
    assert "1 more" in str(result.disturbance)


def test_a_metastable_latch_is_left_and_kept_at_rest() -> None:
    bench = latch(start={"a": 2.1, "b": 2.1})
    result = simulate(bench)
    assert result.disturbance is not None
    assert abs(result["a"][-1] - result["b"][-1]) > 0.9 * V_DD
    kept = simulate(bench, at_rest=True)
    assert abs(kept["a"][-1] - kept["b"][-1]) < 1e-3


@pytest.mark.parametrize("name", block_names())
def test_a_block_rests_where_it_is_stable_and_begins_there_to_the_bit(name: str) -> None:
    block = load_block(name)
    begun = beginning(to_kernel(block.bench(), Silicon(block.process)))
    assert begun.disturbance is None
    np.testing.assert_array_equal(begun.voltage, begun.point.voltage)


def test_noise_leaves_an_unstable_state_without_a_disturbance() -> None:
    oscillator = ALL[1]
    machine = to_kernel(oscillator.testbench, Silicon(oscillator.process))
    result = simulate_noisy(machine, NoiseRun(seed=1, step=10e-12))
    assert result.disturbance is not None
    assert "noise" in str(result.disturbance)
    np.testing.assert_array_equal(result.voltage[0][1], result.operating_point[machine.names[1]])
    quiet = simulate_noisy(to_kernel(neuron(stop=1e-5)), NoiseRun())
    assert quiet.disturbance is None


def test_a_held_voltage_holds_at_the_start_and_is_let_go() -> None:
    result = simulate(replace(low_pass(Constant(0.0), 2 * TAU), initial={"y": 1.0}))
    assert result["y"][0] == 1.0
    np.testing.assert_allclose(result["y"], np.exp(-result.time / TAU), atol=1e-3)


def test_what_is_not_held_is_at_rest_with_what_is() -> None:
    """Half of the held voltage at the middle of a divider without charge."""
    devices = (Capacitor("c", "a", "0", C), Resistor("r1", "a", "m", R), Resistor("r2", "m", "0", R))
    circuit = Circuit("divider", (Port("vdd", "supply"),), (*devices, Resistor("r3", "vdd", "a", 1e9)))
    result = simulate(Testbench("divider", circuit, (SUPPLY,), TAU, initial={"a": 2.0}))
    assert result["m"][0] == pytest.approx(1.0)


def test_held_voltages_choose_the_state_of_a_latch() -> None:
    for held, high in (({"a": V_DD}, "a"), ({"b": V_DD}, "b")):
        result = simulate(replace(latch(), initial=held))
        assert result[high][-1] == pytest.approx(V_DD, abs=1e-3)
        assert result.disturbance is None


def test_held_voltages_hold_on_every_die() -> None:
    machine = to_kernel(replace(latch(), initial={"a": 1.2345}))
    assert simulate(on_die(machine, Die(number=7)))["a"][0] == 1.2345


def test_a_capacitor_begins_with_its_own_voltage() -> None:
    bench = low_pass(Constant(0.0), 2 * TAU)
    charged = replace(bench.circuit.device("c"), ic=1.0)  # type: ignore[type-var]
    circuit = replace(bench.circuit, devices=(bench.circuit.devices[0], charged))
    result = simulate(replace(bench, circuit=circuit))
    np.testing.assert_allclose(result["y"], np.exp(-result.time / TAU), atol=1e-3)


def test_a_capacitor_to_a_driven_node_holds_its_other_end() -> None:
    circuit = Circuit(
        "high", (Port("vdd", "supply"),), (Capacitor("c", "vdd", "y", C, ic=2.0), Resistor("r", "y", "0", R))
    )
    result = simulate(Testbench("high", circuit, (SUPPLY,), TAU))
    assert result["y"][0] == pytest.approx(V_DD - 2.0)


def test_without_a_rest_state_charges_decide() -> None:
    """The output begins at 0 V although it rests at 1 V, and a capacitor without charge passes a step."""
    bench = replace(low_pass(Constant(1.0), 2 * TAU), begin="uic")
    result = simulate(bench)
    np.testing.assert_allclose(result["y"], 1.0 - np.exp(-result.time / TAU), atol=1e-3)
    coupled = Circuit(
        "coupled", (Port("vdd", "supply"),), (Capacitor("c", "vdd", "y", C), Resistor("r", "y", "0", R))
    )
    assert simulate(Testbench("coupled", coupled, (SUPPLY,), TAU, begin="uic"))["y"][0] == pytest.approx(V_DD)


def test_charges_of_capacitors_in_series_share_out() -> None:
    """1 V on 1 nF beside 3 nF without charge: their common node, cut off from both ends, keeps the charge."""
    devices = (
        Capacitor("c1", "m", "0", C, ic=1.0), Capacitor("c2", "m", "0", 3 * C),
        Resistor("leak", "m", "0", 1e12), Resistor("load", "vdd", "m", 1e12),
    )  # fmt: skip
    circuit = Circuit("shared", (Port("vdd", "supply"),), devices)
    assert simulate(Testbench("shared", circuit, (SUPPLY,), TAU, begin="uic"))["m"][0] == pytest.approx(0.25)


def test_a_charge_between_two_resistors_decides_where_both_its_nodes_begin() -> None:
    """1 V, R, 0.5 V on C, R, ground: no end has a charge of its own; the current begins at 0.25 V / R."""
    devices = (
        Resistor("r1", "vdd", "a", R),
        Capacitor("c", "a", "b", C, ic=0.5),
        Resistor("r2", "b", "0", R),
    )
    circuit = Circuit("between", (Port("vdd", "supply"),), devices)
    supply = Source("vdd", "vdd", Constant(1.0))
    result = simulate(Testbench("between", circuit, (supply,), 4 * TAU, begin="uic"))
    assert (result["a"][0], result["b"][0]) == pytest.approx((0.75, 0.25), abs=1e-9)
    np.testing.assert_allclose(result["b"], 0.25 * np.exp(-result.time / (2 * TAU)), atol=1e-4)
    held = Circuit(
        "between", (Port("vdd", "supply"),), (devices[0], replace(devices[1], ic=None), devices[2])
    )
    named = Testbench("between", held, (supply,), TAU, begin="uic", initial={"a": 0.3})
    assert simulate(named)["b"][0] == pytest.approx(0.35, abs=1e-9)


def test_contradictions_are_refused() -> None:
    bench = low_pass(Constant(0.0), TAU)
    with pytest.raises(ParameterError, match=r"a: initial 1 V, but a source holds it at 0 V"):
        simulate(replace(bench, initial={"a": 1.0}))
    assert simulate(replace(bench, initial={"a": 0.0})).outcome
    with pytest.raises(UnknownNameError, match="nowhere"):
        simulate(replace(bench, initial={"nowhere": 1.0}))
    with pytest.raises(ParameterError, match="must be finite"):
        replace(bench, initial={"y": float("nan")})
    with pytest.raises(ParameterError, match="must be one of disturbed, at_rest, uic"):
        replace(bench, begin="somewhere")  # type: ignore[arg-type]
    floating = Circuit(
        "floating", (Port("vdd", "supply"),),
        (Capacitor("c", "a", "b", C, ic=1.0), *inverter("i", "a", "b"), *inverter("j", "b", "a")),
    )  # fmt: skip
    held = Testbench("floating", floating, (SUPPLY,), TAU)
    with pytest.raises(ParameterError, match=r"c\.ic: 1 V between two nodes that nothing holds"):
        simulate(held)
    assert simulate(replace(held, initial={"a": 3.0}))["b"][0] == pytest.approx(2.0)
    with pytest.raises(ParameterError, match=r"c\.ic: 1 V, but its ends are held 2 V apart"):
        simulate(replace(held, initial={"a": 3.0, "b": 1.0}))


def test_the_disturbed_node_does_not_hang_on_rounding() -> None:
    """All nodes of a ring are alike: the first one in the circuit's order is taken."""
    oscillator = ALL[2]
    point = operating_point(oscillator.testbench, Silicon(oscillator.process))
    assert disturbance(point).nodes == ("spike",)


def test_optional_fields_leave_texts_of_circuits_as_they_were() -> None:
    """Keys of records are hashes of these texts."""
    assert repr(Capacitor("c", "a", "0", 1e-12)) == "Capacitor(name='c', a='a', b='0', capacitance=1e-12)"
    assert repr(Port("a", "analog")) == "Port(name='a', kind='analog', direction='in', shape=())"
    assert "ic=1.0" in repr(Capacitor("c", "a", "0", 1e-12, ic=1.0))
    assert "threshold=0.9" in repr(Port("a", "event", "out", threshold=0.9))
    assert "initial" not in repr(latch())
    assert "initial={'a': 1.0}" in repr(replace(latch(), initial={"a": 1.0}))


def test_an_instance_is_held_by_its_path() -> None:
    inner = latch().circuit
    outer = Circuit("outer", (Port("vdd", "supply"),), instances=(Instance("l", inner, {"vdd": "vdd"}),))
    result = simulate(Testbench("outer", outer, (SUPPLY,), 1e-6, initial={"l.a": V_DD}))
    assert result["l.a"][-1] == pytest.approx(V_DD, abs=1e-3)


def test_a_source_of_current_keeps_its_value_beside_held_voltages() -> None:
    circuit = Circuit(
        "load", (Port("y", "analog"),), (Resistor("r", "y", "0", R), Capacitor("c", "y", "0", C))
    )
    drive = Source("i", "y", Constant(1e-3), "current")
    result = simulate(Testbench("load", circuit, (drive,), 20 * TAU, initial={"y": 0.0}))
    assert result["y"][0] == 0.0
    assert result["y"][-1] == pytest.approx(1.0, abs=1e-4)
