"""Operating points: Kirchhoff's law, several rest states and their stability, temperatures, failure."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import BiasKind, Circuit, Port
from circuits.devices import Capacitor, Diode, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import SolverError, UnknownNameError
from circuits.lowering.kernel import to_kernel
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.batch import rest_near
from circuits.solver.modes import natural_rates
from circuits.solver.newton import allocate, evaluate, fill_jacobian, set_base
from circuits.solver.operating_point import (
    OperatingPoint,
    operating_point,
    solve_dense,
    write_dense,
)
from circuits.solver.sweep import dc_sweep
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from tests.circuits.solver.examples import SUPPLY, TAU, C, R, inverter, latch, low_pass, neuron


def remaining_update(point: OperatingPoint) -> float:
    """Largest Newton update that Kirchhoff's current law still asks for at a point, V."""
    k, w = point.machine.kernel, allocate(point.machine.kernel)
    set_base(k, 0.0, w)
    evaluate(k, point.voltage, w)
    fill_jacobian(k, w)
    matrix = np.zeros((k.unknowns, k.unknowns))
    write_dense(k, w, matrix)
    scale = np.abs(matrix).max(axis=1)
    return float(np.abs(np.linalg.solve(matrix / scale[:, None], w.residual / scale)).max())


@pytest.mark.parametrize("temperature_c", [-40.0, 0.0, 27.0, 85.0, 125.0])
def test_the_neuron_rests_at_every_temperature_from_a_cold_start(temperature_c: float) -> None:
    point = operating_point(neuron(), Silicon(AMI_1500_IDEAL, temperature_c=temperature_c))
    assert point.stable
    assert point.others == ()
    assert remaining_update(point) < 1e-9  # V, the solver's own tolerance
    assert point["v_mem"] == pytest.approx(1.8, abs=0.02)  # V_rest
    assert point["spike"] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
@pytest.mark.parametrize("temperature_c", [-40.0, 125.0])
def test_kirchhoff_holds_whatever_the_biases(kind: BiasKind, temperature_c: float) -> None:
    bench = neuron()
    circuit = rebias(bench.circuit, {"i_inh_tau": 40.1e-12, "i_ex_tau": 19.7e-12}, kind)
    point = operating_point(
        replace(bench, circuit=circuit), Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    )
    assert remaining_update(point) < 1e-9
    assert point.stable


def test_divider() -> None:
    ports = (Port("a", "analog"), Port("y", "analog", "out"))
    circuit = Circuit("divider", ports, (Resistor("r", "a", "y", 1e3), Resistor("s", "y", "0", 3e3)))
    point = operating_point(Testbench("t", circuit, (Source("a", "a", Constant(4.0)),), 1.0))
    assert point["y"] == pytest.approx(3.0, rel=1e-12)
    assert point["0"] == 0.0
    assert point.voltages() == {"0": 0.0, "a": 4.0, "y": point["y"]}


def test_a_current_flows_into_its_node() -> None:
    circuit = Circuit("r", (Port("a", "analog"),), (Resistor("r", "a", "0", 1e3),))
    point = operating_point(Testbench("t", circuit, (Source("i", "a", Constant(2e-3), "current"),), 1.0))
    assert point["a"] == pytest.approx(2.0, rel=1e-12)


def test_sources_are_taken_at_the_time_given() -> None:
    bench = low_pass(PiecewiseLinear((0.0, 1.0), (0.0, 4.0)), 1.0)
    assert operating_point(bench, time=0.25)["y"] == pytest.approx(1.0, rel=1e-9)


def test_a_direct_value_is_that_of_what_has_no_time_and_the_waveform_that_of_a_run() -> None:
    bench = low_pass(PiecewiseLinear((0.0, 1.0), (0.0, 4.0)), 1.0)
    bench = replace(bench, sources=(replace(bench.sources[0], direct=3.0),))
    machine = to_kernel(bench)
    assert operating_point(machine)["y"] == pytest.approx(3.0, rel=1e-9)
    assert operating_point(machine, time=0.0)["y"] == pytest.approx(0.0, abs=1e-9)
    assert simulate(machine)["y"][0] == pytest.approx(0.0, abs=1e-9)
    assert rest_near(machine, operating_point(machine))["y"] == pytest.approx(0.0, abs=1e-9)
    found = dc_sweep(machine, bench.sources[0].name, [1.0, 2.0])
    assert found["y"] == pytest.approx([1.0, 2.0], rel=1e-9)


def test_the_start_decides_between_rest_states() -> None:
    for high, low in (("a", "b"), ("b", "a")):
        point = operating_point(latch(), start={high: 5.0})
        assert point.stable
        assert point[high] > 4.99
        assert point[low] < 0.01
        # what is met without a start: the metastable middle, and the opposite state if it settles there
        assert [other.stable for other in point.others if 1.0 < other[high] < 4.0] == [False]
        assert all(other[high] < 4.0 for other in point.others)


def test_the_start_may_stand_in_the_testbench() -> None:
    assert operating_point(latch({"a": 5.0}))["a"] > 4.99
    assert operating_point(latch({"a": 5.0}), start={"b": 5.0})["b"] > 4.99


@pytest.mark.parametrize("width", [6.0, 20.0])
def test_the_metastable_middle_of_a_latch_is_told_unstable(width: float) -> None:
    point = operating_point(latch(width=width))
    assert point.stable
    assert sorted((round(point["a"]), round(point["b"]))) == [0, 5]
    (middle,) = point.others
    assert not middle.stable
    assert remaining_update(middle) < 1e-9
    assert 1.0 < middle["a"] < 4.0
    assert 1.0 < middle["b"] < 4.0


def test_a_start_that_leads_to_the_same_state_has_no_others() -> None:
    point = operating_point(neuron(), start={"v_mem": 2.5})
    assert point.others == ()


def test_an_unknown_start_node_is_named() -> None:
    with pytest.raises(UnknownNameError, match="latch node c: unknown"):
        operating_point(latch(), start={"c": 1.0})


def test_no_answer_is_an_error_with_a_remedy() -> None:
    circuit = Circuit("d", (Port("a", "analog"),), (Diode("d", "0", "a", saturation_current=1e-14),))
    bench = Testbench("bench", circuit, (Source("i", "a", Constant(1.0), "current"),), 1.0)  # no way out
    with pytest.raises(SolverError, match=r"^bench: no operating point; give start voltages"):
        operating_point(bench)
    with pytest.raises(SolverError, match=r"^bench: no operating point"):
        operating_point(bench, start={"a": 1.0})


@pytest.mark.parametrize("start", [None, {"a": 1.0}])
@pytest.mark.parametrize("volts", [50.0, 1e3, 1e4])
def test_a_node_may_stand_at_a_high_voltage(volts: float, start: dict[str, float] | None) -> None:
    circuit = Circuit("r", (Port("a", "analog"),), (Resistor("r", "a", "0", 1e5),))
    bench = Testbench("bench", circuit, (Source("i", "a", Constant(volts / 1e5), "current"),), 1.0)
    assert operating_point(bench, start=start)["a"] == pytest.approx(volts, rel=1e-12)


@pytest.mark.parametrize("supply", [90.0, 325.0])
def test_a_diode_breaks_down_and_another_conducts_far_above_a_chip_s_supply(supply: float) -> None:
    zener = Diode("z", "0", "z", saturation_current=1e-14, breakdown_voltage=60.0, breakdown_current=1e-3)
    devices = (
        Resistor("r", "a", "z", 1e4),
        zener,
        Diode("d", "a", "y", saturation_current=1e-12),
        Resistor("s", "y", "0", 5e3),
    )
    circuit = Circuit("clamp", (Port("a", "analog"),), devices)
    point = operating_point(Testbench("t", circuit, (Source("v", "a", Constant(supply)),), 1.0))
    u_t = 8.617333262e-5 * 300.15
    current = (supply - point["z"]) / 1e4
    assert point["z"] == pytest.approx(60.0 + u_t * np.log(current / 1e-3), abs=1e-6)
    assert supply - point["y"] == pytest.approx(u_t * np.log1p(point["y"] / 5e3 / 1e-12), abs=1e-6)


def amplified(name: str, *devices: Device) -> Testbench:
    """Devices with the output y, on the supply."""
    ports = (Port("vdd", "supply"), Port("y", "analog", "out"))
    return Testbench(name, Circuit(name, ports, devices), (SUPPLY,), 1.0)


def test_an_amplifier_with_positive_feedback_has_two_rails() -> None:
    bench = amplified(
        "schmitt",
        OperationalAmplifier("x", "p", "half", "y", "vdd"),
        Resistor("f", "y", "p", 1e4),
        Resistor("g", "p", "half", 1e4),
        *(Resistor(f"h{k}", "half", k, 1e3) for k in ("vdd", "0")),
        Capacitor("c", "p", "0", 1e-12),
    )
    for level in (0.0, 5.0):
        point = operating_point(bench, start={"y": level, "p": level, "half": 2.5})
        assert point.stable
        assert point["y"] == pytest.approx(level, abs=0.1)  # 100 ohm into 10 kohm
    middle = operating_point(bench, start={"y": 2.5, "p": 2.5, "half": 2.5})
    assert middle["y"] == pytest.approx(2.5, abs=1e-3)
    assert not middle.stable


def test_unpowered_amplifier() -> None:
    bench = amplified(
        "follower",
        OperationalAmplifier("x", "vdd", "y", "y", "rail"),
        Resistor("s", "vdd", "rail", 10.0),
        Resistor("l", "y", "0", 1e4),
    )
    assert operating_point(bench)["y"] == pytest.approx(5.0, abs=0.1)  # the rail starts at 0 V


def test_natural_rate_of_a_low_pass_filter() -> None:
    machine = to_kernel(low_pass(Constant(0.0), 1.0))
    assert machine.kernel.unknowns == 1
    assert natural_rates(np.array([[1.0 / R]]), np.array([[C]])).real == pytest.approx(
        [-1.0 / TAU], rel=1e-12
    )


def test_natural_rates_leave_out_nodes_without_charge() -> None:
    # C at one end of two resistors in series, the middle without charge: 1 / (2 R C)
    g = 1.0 / R
    conductance = np.array([[g, -g], [-g, 2.0 * g]])
    rates = natural_rates(conductance, np.diag([C, 0.0]))
    assert rates.real == pytest.approx([-1.0 / (2.0 * TAU)], rel=1e-12)


def test_natural_rates_of_a_floating_capacitor() -> None:
    # both nodes have capacitance, their sum has none: R to ground at each end gives 1 / (2 R C)
    g = 1.0 / R
    rates = natural_rates(np.diag([g, g]), C * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    assert rates.real == pytest.approx([-1.0 / (2.0 * TAU)], rel=1e-9)


def test_dense_solver_pivots_and_reports_a_singular_matrix() -> None:
    a = np.array([[0.0, 2.0], [3.0, 1.0]])
    b = np.array([4.0, 5.0])
    assert solve_dense(a.copy(), b)
    assert b == pytest.approx([1.0, 2.0])
    assert not solve_dense(np.array([[1.0, 1.0], [1.0, 1.0]]), np.ones(2))


def test_inverter_threshold_is_between_the_rails() -> None:
    circuit = Circuit("inverter", (Port("vdd", "supply"), Port("a", "analog")), inverter("i", "a", "y"))
    bench = Testbench("t", circuit, (SUPPLY, Source("a", "a", Constant(0.0))), 1.0)
    assert operating_point(bench)["y"] == pytest.approx(5.0, abs=1e-6)


def test_biases_of_the_neuron_sit_where_its_block_says() -> None:
    point = operating_point(neuron())
    for bias in rebound_neuron.BIASES:
        if bias.kind == "voltage":
            assert point[bias.port] == bias.value


def test_a_die_on_which_a_cold_start_fails_is_reached_from_the_nominal_one() -> None:
    block = load_block("onset-neuron")
    circuit = block.build()
    testbench = block.testbench(circuit, block.defaults, 5.0)
    point = operating_point(testbench, Silicon(AMI_1500_IDEAL, die=Die(number=1002)))
    assert point.stable
    assert point["spike"] == pytest.approx(0.0, abs=1e-3)


def test_nodes_that_hang_on_leakage_alone_and_on_each_other_by_resistors_rest() -> None:
    # 1e-17 S to the sources, 4e-5 S among themselves: a circuit drawn at random, reduced
    rows = """m1 p n0 n3 n2 28.09 25.04, m3 n n0 0 0 1.64 21.2, m4 n n0 vin vin 1.842 1.933,
        m5 p n2 vdd vin 26.64 3.102, m6 p vin vdd n1 3.697 2.231, m7 n n0 0 vin 6.466 21.29,
        m8 n n2 0 n1 7.552 5.362, m10 n n1 n3 n2 2.041 30.98"""
    devices: list[Device] = [Resistor("r2", "n2", "n3", 24.42e3), Resistor("r11", "n2", "n1", 458.8e6)]
    for name, polarity, d, g, s, *size in map(str.split, rows.split(",")):
        w, length = (1e-6 * float(text) for text in size)
        bulk = "0" if polarity == "n" else "vdd"
        devices.append(Transistor(name, polarity, d, g, s, bulk, w, length))  # type: ignore[arg-type]
    ports = (Port("vdd", "supply"), Port("vin", "analog"))
    sources = (Source("vdd", "vdd", Constant(5.0)), Source("vin", "vin", Constant(3.1826659438958553)))
    bench = Testbench("leaking", Circuit("leaking", ports, tuple(devices)), sources, 1e-3)
    # ngspice's own point; rounding leaves the voltage that they share to 1 mV
    assert operating_point(bench, Silicon())["n2"] == pytest.approx(4.988535, abs=1e-3)
