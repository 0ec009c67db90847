"""Sweeps of any kind: their order, hysteresis, currents, measures, and what is refused."""

import math

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Diode, Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import thermal_voltage
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.sweep.sweep import sweep
from circuits.testbench import Testbench
from tests.circuits.solver.examples import SUPPLY, inverter, low_pass

GATE = Port("a", "analog")


def ladder(r: float = 1e3) -> Testbench:
    """A divider of r and 3 kOhm from `a`, with a current into `y`."""
    ports = (GATE, Port("y", "analog", "out"))
    circuit = Circuit("ladder", ports, (Resistor("r", "a", "y", r), Resistor("s", "y", "0", 3e3)))
    sources = (Source("a", "a", Constant(0.0)), Source("i", "y", Constant(0.0), "current"))
    return Testbench("ladder", circuit, sources, 1.0)


def schmitt() -> Testbench:
    """Two inverters, the second with a resistor back to the input of the first."""
    devices = (
        Resistor("front", "a", "x", 1e6), Resistor("back", "y", "x", 2e6), *inverter("i", "x", "m"),
        *inverter("j", "m", "y"), Capacitor("c", "y", "0", 1e-12),
    )  # fmt: skip
    circuit = Circuit("schmitt", (Port("vdd", "supply"), GATE, Port("y", "analog", "out")), devices)
    return Testbench("schmitt", circuit, (SUPPLY, Source("a", "a", Constant(0.0))), 1e-3)


def test_nested_sources_are_dimensions_in_the_order_of_their_names() -> None:
    volts, amperes = [0.0, 1.0, 2.0], [0.0, 1e-3]
    found = sweep(ladder(), {"a": volts, "i": amperes})
    assert found.voltage.dims == ("a", "i", "node")
    expected = 0.75 * np.array(volts)[:, None] + 750.0 * np.array(amperes)
    np.testing.assert_allclose(found.voltage.sel(node="y"), expected, atol=1e-12)
    np.testing.assert_allclose(found.current.sel(device="s"), expected / 3e3, atol=1e-15)
    np.testing.assert_allclose(found.current.sel(device="i"), [amperes] * 3)
    into_a = -found.current.sel(device="r")  # what leaves the source is what it gives
    np.testing.assert_allclose(found.current.sel(device="a"), into_a, atol=1e-15)
    assert (found.a.attrs["units"], found.i.attrs["units"]) == ("V", "A")
    assert bool(found.stable.all())


def test_a_parameter_of_a_function_is_swept() -> None:
    found = sweep(ladder, {"r": [1e3, 3e3], "a": [0.0, 4.0]})
    np.testing.assert_allclose(found.voltage.sel(node="y", a=4.0), [3.0, 2.0], atol=1e-12)
    other_way = sweep(ladder, {"a": [0.0, 4.0], "r": [1e3, 3e3]})
    np.testing.assert_allclose(other_way.voltage.sel(node="y", a=4.0), [3.0, 2.0], atol=1e-12)


def test_hysteresis_shows_by_direction() -> None:
    found = sweep(schmitt(), {"a": np.linspace(0.0, 5.0, 101)}, way="both", measures=["v = cross(y, 2.5V)"])
    up, down = (found.voltage.sel(node="y", direction=way).to_numpy() for way in ("up", "down"))
    assert [up[0], up[-1]] == pytest.approx([down[0], down[-1]], abs=0.01)
    up_at, down_at = found.v.sel(direction="up").item(), found.v.sel(direction="down").item()
    # the loop is R_in / R_back of the swing of 5 V wide, less what the output gives to the resistor
    assert up_at - down_at == pytest.approx(2.5, abs=0.2)
    middle = found.a.to_numpy() == 2.5
    assert (up[middle].item() < 1.0, down[middle].item() > 4.0) == (True, True)
    alone = sweep(schmitt(), {"a": np.linspace(0.0, 5.0, 101)}, way="down")
    np.testing.assert_allclose(alone.voltage.sel(node="y"), down, atol=1e-6)


@pytest.mark.parametrize("points", [6, 501])
def test_the_switch_is_where_it_is_whatever_the_step(points: int) -> None:
    found = sweep(schmitt(), {"a": np.linspace(0.0, 5.0, points)})
    y = found.voltage.sel(node="y").to_numpy()
    k = int(np.argmax(y > 2.5))
    assert found.a[k - 1] <= 3.295 <= found.a[k]


def test_points_are_operating_points_of_their_silicon() -> None:
    bench = schmitt()
    found = sweep(bench, {"die": [1000, 1001], "temperature": [-20.0, 85.0], "corner": ["ss", "random"]})
    assert found.voltage.dims == ("die", "temperature", "corner", "node")
    for die, celsius, corner in [(1001, -20.0, "random"), (1000, 85.0, "ss")]:
        alone = operating_point(bench, Silicon(temperature_c=celsius, die=Die(number=die, corner=corner)))
        at = found.voltage.sel(die=die, temperature=celsius, corner=corner)
        np.testing.assert_allclose(at, [alone[n] for n in alone.machine.names], atol=1e-9)


def test_a_die_does_not_depend_on_those_before_it() -> None:
    many = sweep(schmitt(), {"a": [2.0, 3.0], "die": [1000, 1001, 1002]})
    one = sweep(schmitt(), {"a": [2.0, 3.0], "die": [1002]})
    np.testing.assert_array_equal(many.voltage.sel(die=1002), one.voltage.sel(die=1002))


def test_measures_of_transients() -> None:
    def rc(c: float) -> Testbench:
        step = PiecewiseLinear((0.0, 1e-12), (0.0, 1.0))
        ports = (GATE, Port("y", "analog", "out"))
        circuit = Circuit("rc", ports, (Resistor("r", "a", "y", 1e3), Capacitor("c", "y", "0", c)))
        return Testbench("rc", circuit, (Source("a", "a", step),), 2e-6)

    texts = ["t = cross(y, 0.5)"]
    found = sweep(rc, {"c": [1e-9, 2e-9, 8e-9]}, measures=texts, analysis="tran")
    expected = 1e3 * np.array([1e-9, 2e-9]) * np.log(2.0)
    np.testing.assert_allclose(found.t[:2], expected, rtol=1e-4)
    assert np.isnan(found.t[2])
    assert found.reason.values.tolist() == ["", "", "t: y does not pass through 500mV"]
    assert found.t.attrs == {"units": "s", "expression": "t = cross(y, 0.5)"}


def test_a_curve_is_measured_along_its_source() -> None:
    found = sweep(
        ladder(), {"a": np.linspace(0.0, 4.0, 5), "i": [0.0, 1e-3]},
        measures=["v = cross(y, 1.5)", "g = slope(y, at=1V)", "r = 1 / slope(i(r), at=1V)"],
    )  # fmt: skip
    np.testing.assert_allclose(found.v, [2.0, 1.0])
    np.testing.assert_allclose(found.g, [0.75, 0.75])
    np.testing.assert_allclose(found.r, [4e3, 4e3])
    assert [found[name].attrs["units"] for name in "vgr"] == ["V", "", "Ohm"]


def held_back() -> Testbench:
    """A diode in reverse, which takes 5 mA at most: `I = I_S (1 - e^(-v / U_T))`."""
    circuit = Circuit("r", (GATE,), (Diode("d", "0", "a", saturation_current=5e-3),))
    return Testbench("bench", circuit, (Source("i", "a", Constant(0.0), "current"),), 1.0)


def height(current: float) -> float:
    """Where `held_back` stands at a current, V."""
    return -thermal_voltage(27.0) * math.log1p(-current / 5e-3)


def test_points_without_a_solution_are_told() -> None:
    found = sweep(held_back(), {"i": [0.0, 1e-3, 1.0]})
    np.testing.assert_allclose(found.voltage.sel(node="a")[:2], [0.0, height(1e-3)], rtol=1e-6, atol=1e-12)
    assert np.isnan(found.voltage.sel(node="a")[2])
    assert found.attrs["failures"][0].startswith("bench.i: 1 A: give start voltages")


def test_what_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"ladder: swept b: unknown.* known are .*a, .*temperature"):
        sweep(ladder(), {"b": [1.0]})
    refused: list[tuple[dict[str, list[object]], str]] = [
        ({}, "over: nothing"), ({"a": []}, "a has no values"), ({"a": [1.0, float("nan")]}, "a: nan"),
        ({"a": [1.0, 1.0]}, "a has a value twice"), ({"die": [-1]}, "die: -1"),
        ({"corner": ["xx"]}, "corner: xx"), ({"temperature": [500.0]}, "temperature"),
    ]  # fmt: skip
    for over, text in refused:
        with pytest.raises(ParameterError, match=text):
            sweep(ladder(), over)
    with pytest.raises(ParameterError, match="over die there is no curve"):
        sweep(ladder(), {"die": [1, 2]}, measures=["max(y)"])
    with pytest.raises(ParameterError, match="at least one of a transient"):
        sweep(low_pass(Constant(1.0), 1e-6), {"a": [1.0]}, analysis="tran")
    with pytest.raises(ParameterError, match="way: both"):
        sweep(low_pass(Constant(1.0), 1e-6), {"a": [1.0]}, analysis="tran", measures=["max(y)"], way="both")


def test_points_beyond_one_without_a_solution_are_found() -> None:
    found = sweep(held_back(), {"i": [1.0, 1e-3, 2.0, 2e-3]})
    stands = [np.nan, height(1e-3), np.nan, height(2e-3)]
    np.testing.assert_allclose(found.voltage.sel(node="a"), stands, rtol=1e-6)
    np.testing.assert_allclose(found.current.sel(device="d"), [np.nan, -1e-3, np.nan, -2e-3], rtol=1e-6)
    assert found.stable.values.tolist() == [False, True, False, True]
    assert found.attrs["failures"][0].startswith("bench.i: 1 A and 1 more: ")
