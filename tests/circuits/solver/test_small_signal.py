"""Small signals: networks with known answers, and slopes of the solver's own sweeps."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.small_signal import ac, frequency_grid, linearise
from circuits.solver.sweep import dc_sweep
from circuits.testbench import Testbench
from tests.circuits.solver.examples import SUPPLY, TAU, UM, C, R, inverter, low_pass

IN, OUT = Port("a", "analog"), Port("y", "analog", "out")
GRID = frequency_grid(1.0, 1e9, 3)


def test_a_low_pass_has_its_textbook_transfer() -> None:
    found = ac(operating_point(low_pass(Constant(0.0), 1.0)), "a", GRID)
    assert (found.source, found.unit, found.nodes) == ("a", "V/V", ("a", "y"))
    np.testing.assert_array_equal(found.transfer[:, 0], 1.0)
    np.testing.assert_allclose(found.transfer[:, 1], 1.0 / (1.0 + 2j * np.pi * GRID * TAU), rtol=1e-12)


def test_a_current_source_sees_the_impedance() -> None:
    circuit = Circuit("load", (OUT,), (Resistor("r", "y", "0", R), Capacitor("c", "y", "0", C)))
    bench = Testbench("load", circuit, (Source("i", "y", Constant(1e-6), "current"),), 1.0)
    found = ac(operating_point(bench), "i", GRID, ["y"])
    assert found.unit == "V/A"
    np.testing.assert_allclose(found.transfer[:, 0], R / (1.0 + 2j * np.pi * GRID * TAU), rtol=1e-12)


def test_an_amplifier_and_a_transconductance() -> None:
    devices = (
        OperationalAmplifier("x", "a", "m", "m", "vdd", gain=1e4, output_resistance=100.0),
        Capacitor("c", "m", "0", 1e-9),
        ControlledSource("g", "0", "y", "m", "0", 1e-3),
        Resistor("r", "y", "0", 5e3),
    )
    circuit = Circuit("chain", (Port("vdd", "supply"), IN, OUT), devices)
    bench = Testbench("chain", circuit, (SUPPLY, Source("a", "a", Constant(2.5))), 1.0)
    found = ac(operating_point(bench), "a", GRID, ["m", "y"])
    gain = 1e4  # less by the slope of the tanh at 2.5 V of 5 V: none, the output stands at mid supply
    follower = gain / (1.0 + gain + 2j * np.pi * GRID * 100.0 * 1e-9)
    # the offset that the follower needs, 0.5 nV of 2.5 V, bends the tanh by 1e-8
    np.testing.assert_allclose(found.transfer[:, 0], follower, rtol=1e-7)
    np.testing.assert_allclose(found.transfer[:, 1], 5.0 * follower, rtol=1e-7)


@pytest.mark.parametrize("temperature_c", [-40.0, 27.0, 125.0])
def test_at_low_frequency_it_is_the_slope_of_a_sweep(temperature_c: float) -> None:
    circuit = Circuit("inverter", (Port("vdd", "supply"), IN, OUT), inverter("i", "a", "y"))
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    for v in (1.0, 2.1, 3.0):
        bench = Testbench("inverter", circuit, (SUPPLY, Source("a", "a", Constant(v))), 1.0)
        found = ac(operating_point(bench, silicon), "a", np.array([1e-6]), ["y"])
        sweep = dc_sweep(bench, "a", [v - 1e-5, v + 1e-5], silicon)
        slope = (sweep["y"][1] - sweep["y"][0]) / 2e-5
        # the solver leaves 1e-9 V of an operating point, over 20 uV; the curve's bend is of the order of 1e-6
        assert found.transfer[0, 0].real == pytest.approx(slope, rel=1e-4, abs=2e-4)


def test_at_high_frequency_capacitances_divide() -> None:
    devices = (
        Transistor("m", "n", "y", "a", "0", "0", 3 * UM, 1.5 * UM),
        Resistor("r", "y", "0", 1e9),
    )
    circuit = Circuit("coupled", (IN, OUT), devices)
    point = operating_point(Testbench("coupled", circuit, (Source("a", "a", Constant(0.0)),), 1.0))
    overlap, junction = 0.2e-9 * 3e-6, 1.5e-9 * 3e-6  # F, of the drain
    found = ac(point, "a", np.array([1e12]), ["y"]).transfer[0, 0]
    # 1 GOhm carries 3e-8 of what 5.1 fF do at 1 THz
    assert found == pytest.approx(overlap / (overlap + junction), rel=1e-6)


def test_junction_leakage_conducts() -> None:
    leaky = replace(AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, junction_leakage=1e-6))
    circuit = Circuit("leak", (IN, OUT), (
        Transistor("m", "n", "y", "0", "0", "0", 3 * UM, 1.5 * UM), Resistor("r", "a", "y", 1e9),
    ))  # fmt: skip
    silicon = Silicon(leaky)
    bench = Testbench("leak", circuit, (Source("a", "a", Constant(0.02)),), 1.0)
    found = ac(operating_point(bench, silicon), "a", np.array([1e-6]), ["y"]).transfer[0, 0].real
    sweep = dc_sweep(bench, "a", [0.02 - 1e-5, 0.02 + 1e-5], silicon)["y"]
    # as above
    assert found == pytest.approx((sweep[1] - sweep[0]) / 2e-5, rel=1e-4)


def test_the_matrices_keep_charge_and_current() -> None:
    """Moving every node and source together changes nothing: rows add up to zero."""
    circuit = Circuit("inverter", (Port("vdd", "supply"), IN, OUT), inverter("i", "a", "y"))
    bench = Testbench("inverter", circuit, (SUPPLY, Source("a", "a", Constant(2.0))), 1.0)
    linear = linearise(operating_point(bench))
    for matrix in (linear.conductance, linear.charge):
        dense = matrix.toarray()
        np.testing.assert_allclose(dense.sum(axis=1), 0.0, atol=1e-12 * np.abs(dense).max())


def test_wrong_names_and_grids_are_refused() -> None:
    point = operating_point(low_pass(Constant(0.0), 1.0))
    with pytest.raises(UnknownNameError, match="source b"):
        ac(point, "b", GRID)
    with pytest.raises(UnknownNameError, match="node z"):
        ac(point, "a", GRID, ["z"])
    for wrong in ((0.0, 1.0, 3), (2.0, 1.0, 3), (1.0, np.inf, 3), (1.0, 2.0, 0), (1.0, 1e9, 10**6)):
        with pytest.raises(ParameterError):
            frequency_grid(*wrong)
    assert frequency_grid(1.0, 1e3, 2).size == 7
    assert frequency_grid(5.0, 5.0, 20).tolist() == [5.0]
