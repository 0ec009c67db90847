"""Currents by name obey Kirchhoff's law, at rest, over a sweep and over a run."""

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import UnknownNameError
from circuits.measure.scope import device_currents
from circuits.solver.operating_point import operating_point
from circuits.solver.power import delivered_energy, drain_current
from circuits.solver.sweep import dc_sweep
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

PORTS = (Port("vdd", "supply"), Port("v_g", "analog"), Port("i", "analog"))
AMPLIFIER = Circuit(
    "amplifier",
    PORTS,
    (
        Transistor("m", "n", "v", "v_g", "0", "0", 6e-6, 3e-6),
        Resistor("r", "vdd", "v", 1e6),
        Capacitor("c", "v", "0", 1e-12),
        Resistor("load", "i", "0", 1e5),
    ),
)


def _bench(gate: float | PiecewiseLinear) -> Testbench:
    wave = Constant(gate) if isinstance(gate, float) else gate
    sources = (
        Source("supply", "vdd", Constant(5.0)),
        Source("gate", "v_g", wave),
        Source("into", "i", Constant(2e-6), "current"),
    )
    return Testbench("amplifier", AMPLIFIER, sources, 20e-6)


def test_at_rest_the_supply_gives_what_the_devices_take() -> None:
    found = {name: float(i[0]) for name, i in device_currents(operating_point(_bench(0.9))).items()}
    assert list(found) == ["m", "r", "load", "c", "supply", "gate", "into"]
    assert found["r"] == pytest.approx(found["m"], rel=1e-3)  # the rest is the junction's leakage
    assert found["supply"] == pytest.approx(-found["r"], rel=1e-9)
    assert found["load"] == pytest.approx(2e-6, rel=1e-9)
    assert found["into"] == 2e-6
    assert found["c"] == 0.0


def test_over_a_sweep_a_swept_current_is_its_own() -> None:
    sweep = dc_sweep(_bench(0.9), "into", [0.0, 1e-6, 3e-6])
    found = device_currents(sweep, ["load", "i(into)", "m"])
    assert list(found) == ["load", "i(into)", "m"]
    np.testing.assert_allclose(found["load"], [0.0, 1e-6, 3e-6], rtol=1e-9)
    np.testing.assert_array_equal(found["i(into)"], [0.0, 1e-6, 3e-6])
    np.testing.assert_array_equal(found["m"], drain_current(sweep, "m"))


def test_over_a_run_charge_is_counted() -> None:
    ramp = PiecewiseLinear((0.0, 5e-6, 15e-6), (0.0, 0.0, 0.9))
    result = simulate(_bench(ramp))
    found = device_currents(result)
    node = found["r"] - found["m"] - found["c"]
    assert np.abs(found["c"]).max() > 1e-7  # it discharges
    # central differences, and the gate's charge that flows into the drain besides
    assert np.abs(np.trapezoid(node, result.time)) < 0.05 * np.trapezoid(np.abs(found["c"]), result.time)
    np.testing.assert_allclose(found["supply"], -found["r"], rtol=1e-9, atol=1e-18)


def test_a_name_without_a_current_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="amplifier current m1: unknown; did you mean m"):
        device_currents(operating_point(_bench(0.9)), ["m1"])


def test_a_supply_gives_what_a_source_of_current_draws_from_its_node() -> None:
    circuit = Circuit("r", (Port("vdd", "supply"),), (Resistor("r", "vdd", "0", 1e3),))
    ramp = PiecewiseLinear((0.0, 1e-6), (0.0, 1e-3))
    sources = (Source("v", "vdd", Constant(2.0)), Source("i", "vdd", ramp, "current"))
    bench = Testbench("t", circuit, sources, 1e-6)
    result = simulate(bench)
    for found in (device_currents(result), device_currents(result, ["v"])):
        np.testing.assert_allclose(found["v"], result.time * 1e3 - 2e-3, rtol=1e-12)
    assert delivered_energy(result)["v"] == pytest.approx(2.0 * (2e-3 - 0.5e-3) * 1e-6, rel=1e-12)
