"""Direct-current sweeps: linear and EKV answers, an inverter's curve, hysteresis, what is refused."""

import math

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Diode, Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError, SolverError, UnknownNameError
from circuits.silicon.process import AMI_1500_IDEAL, at_temperature
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.power import drain_current as swept_current
from circuits.solver.sweep import dc_sweep
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from tests.circuits.solver.examples import SUPPLY, UM, inverter, latch

IN, OUT = Port("a", "analog"), Port("y", "analog", "out")
DRIVE = Source("a", "a", Constant(0.0))
DIVIDER = Testbench(
    "divider",
    Circuit("divider", (IN, OUT), (Resistor("r", "a", "y", 1e3), Resistor("s", "y", "0", 3e3))),
    (DRIVE,),
    1.0,
)
INVERTER = Testbench(
    "inverter",
    Circuit("inverter", (Port("vdd", "supply"), IN, OUT), inverter("i", "a", "y")),
    (SUPPLY, DRIVE),
    1.0,
)


def test_resistive_divider() -> None:
    values = [0.0, 4.0, -2.0]
    sweep = dc_sweep(DIVIDER, "a", values)
    assert (sweep.source, sweep.values.tolist()) == ("a", values)
    np.testing.assert_allclose(sweep["y"], 0.75 * np.array(values), atol=1e-12)
    np.testing.assert_array_equal(sweep["a"], values)
    assert sweep.stable.all()


@pytest.mark.parametrize("temperature_c", [-40.0, 27.0, 125.0])
def test_transfer_curve_of_an_inverter_falls(temperature_c: float) -> None:
    values = np.linspace(0.0, 5.0, 101)
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    sweep = dc_sweep(INVERTER, "a", values, silicon)
    y = sweep["y"]
    # two transistors in weak inversion leave e^(-kappa ...) of the rail; rounding of 5 V is 1e-15
    assert (np.diff(y) <= 1e-9).all()
    assert y[0] == pytest.approx(5.0, abs=1e-4)
    assert y[-1] == pytest.approx(0.0, abs=1e-4)
    assert (np.diff(y).min()) < -0.5  # gain at the threshold
    down = dc_sweep(INVERTER, "a", values[::-1], silicon)["y"][::-1]
    np.testing.assert_allclose(down, y, atol=1e-6)


def test_transistor_on_a_resistor_follows_the_law() -> None:
    devices = (
        Resistor("r", "vdd", "y", 1e6),
        Transistor("m", "n", "y", "a", "0", "0", 6 * UM, 3 * UM),
    )
    ports = (Port("vdd", "supply"), IN, OUT)
    bench = Testbench("load", Circuit("load", ports, devices), (SUPPLY, DRIVE), 1.0)
    sweep = dc_sweep(bench, "a", np.linspace(0.0, 3.0, 31), Silicon(AMI_1500_IDEAL))
    law = at_temperature(AMI_1500_IDEAL.n, AMI_1500_IDEAL, 27.0)
    current = drain_current(law, "n", 6 * UM, 3 * UM, sweep["y"], sweep["a"], 0.0)
    # an update below 1e-9 V of 1 Mohm is 1e-15 A
    np.testing.assert_allclose((5.0 - sweep["y"]) / 1e6, current, rtol=1e-9, atol=2e-15)
    assert current[0] < 1e-12
    assert current[-1] > 4e-6


def test_each_point_starts_from_the_one_before() -> None:
    # a latch with one supply swept: the state it started in is kept all the way
    values = np.linspace(5.0, 2.0, 31)
    for high, low in (("a", "b"), ("b", "a")):
        sweep = dc_sweep(latch(), "vdd", values, start={high: 5.0})
        np.testing.assert_allclose(sweep[high], values, atol=1e-3)
        assert sweep[low].max() < 1e-3
        assert sweep.stable.all()


def test_a_bias_can_be_swept_by_its_port() -> None:
    assert dc_sweep(DIVIDER, "a", [1.0]).voltage.shape == (1, 3)


def test_points_are_operating_points() -> None:
    sweep = dc_sweep(INVERTER, "a", [1.0, 2.0])
    bench = Testbench("t", INVERTER.circuit, (SUPPLY, Source("a", "a", Constant(2.0))), 1.0)
    assert sweep["y"][1] == pytest.approx(operating_point(bench)["y"], abs=1e-9)


def test_a_point_without_an_answer_is_named() -> None:
    circuit = Circuit("d", (IN,), (Diode("d", "0", "a", saturation_current=1e-14),))
    bench = Testbench("bench", circuit, (Source("i", "a", Constant(0.0), "current"),), 1.0)
    with pytest.raises(SolverError, match=r"^bench\.i: 1 A, no operating point; give start voltages"):
        dc_sweep(bench, "i", [0.0, 1e-15, 1.0])
    with pytest.raises(SolverError, match=r"^bench\.i: 2 A, no operating point"):
        dc_sweep(bench, "i", [2.0, 0.0])


def test_what_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="divider source b: unknown; known are a"):
        dc_sweep(DIVIDER, "b", [1.0])
    for bad in ([], [math.nan], [0.0, math.inf]):
        with pytest.raises(ParameterError, match="a: values of a sweep must be numbers"):
            dc_sweep(DIVIDER, "a", bad)
    with pytest.raises(UnknownNameError, match="node z: unknown"):
        _ = dc_sweep(DIVIDER, "a", [1.0])["z"]


def test_current_of_a_transistor_over_a_sweep_follows_the_law() -> None:
    ports = (Port("d", "analog"), Port("g", "analog"))
    single = Circuit("single", ports, (Transistor("m", "n", "d", "g", "0", "0", 6 * UM, 3 * UM),))
    sources = (Source("d", "d", Constant(1.0)), Source("g", "g", Constant(0.0)))
    gates = np.linspace(0.2, 2.0, 37)
    for silicon in (Silicon(AMI_1500_IDEAL), Silicon(AMI_1500_IDEAL, temperature_c=60.0)):
        sweep = dc_sweep(Testbench("single", single, sources, 1.0), "g", gates, silicon)
        law = silicon.law("n")
        expected = drain_current(law, "n", 6 * UM, 3 * UM, 1.0, gates, 0.0)
        np.testing.assert_allclose(swept_current(sweep, "m"), expected, rtol=1e-12)
    with pytest.raises(UnknownNameError, match="mm"):
        swept_current(sweep, "mm")


def test_current_needs_every_node_of_a_run() -> None:
    run = simulate(INVERTER, record=("y",))
    with pytest.raises(ParameterError, match="drain current: the run must record every node"):
        swept_current(run, "ip")
