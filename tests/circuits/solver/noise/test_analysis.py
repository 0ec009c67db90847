"""Noise about a rest state: k T / C, a common source by hand, shares, integrals, every device type."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import DEVICE_TYPES, Capacitor, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.noise import WHITE_ONLY, NoiseModel, noise_model
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL, BOLTZMANN, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import integrate_power, noise, noise_of, noise_sources
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.small_signal import ac, frequency_grid, linearise, transistors_at
from circuits.testbench import Testbench
from tests.circuits.solver.examples import SUPPLY, UM, C, R, low_pass

OUT = Port("y", "analog", "out")


def switch(gate: float, temperature_c: float = 27.0) -> OperatingPoint:
    """An nFET from `y` to ground, and 1 pF."""
    devices = (Transistor("m", "n", "y", "g", "0", "0", 3 * UM, 1.5 * UM), Capacitor("c", "y", "0", 1e-12))
    circuit = Circuit("switch", (Port("g", "bias"), OUT), devices)
    bench = Testbench("switch", circuit, (Source("g", "g", Constant(gate)),), 1.0)
    return operating_point(bench, Silicon(AMI_1500_IDEAL, temperature_c=temperature_c))


def common_source() -> OperatingPoint:
    """An nFET in weak inversion on 10 MOhm."""
    devices = (Transistor("m", "n", "y", "g", "0", "0", 3 * UM, 3 * UM), Resistor("r", "vdd", "y", 1e7))
    circuit = Circuit("stage", (Port("vdd", "supply"), Port("g", "bias"), OUT), devices)
    return operating_point(Testbench("stage", circuit, (SUPPLY, Source("g", "g", Constant(0.55))), 1.0))


@pytest.mark.parametrize("temperature_c", [-40.0, 27.0, 125.0])
def test_a_resistor_leaves_k_t_over_c(temperature_c: float) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    corner = 1.0 / (2.0 * np.pi * R * C)
    grid = frequency_grid(1e-4 * corner, 1e4 * corner, 20)
    found = noise(operating_point(low_pass(Constant(0.0), 1.0), silicon), "y", grid)
    # the two ends beyond the grid hold 2 / pi * 1e-4 each
    assert found.variance == pytest.approx(BOLTZMANN * kelvin(temperature_c) / C, rel=1e-3)


@pytest.mark.parametrize("gate", [0.4, 0.7, 1.0, 5.0])
def test_a_switch_leaves_k_t_over_c_whatever_its_inversion(gate: float) -> None:
    point = switch(gate)
    conductance, capacitance = transistors_at(point).conductance[0, 0], linearise(point).charge[0, 0]
    corner = conductance / (2.0 * np.pi * capacitance)
    grid = frequency_grid(1e-4 * corner, 1e4 * corner, 20)
    found = noise(point, "y", grid, model=WHITE_ONLY)
    # as above
    assert found.variance == pytest.approx(BOLTZMANN * kelvin(27.0) / capacitance, rel=1e-3)


def test_a_common_source_by_hand() -> None:
    point, f = common_source(), np.array([0.01])
    model = noise_model(AMI_1500_IDEAL)
    found = noise(point, "y", f, "g")
    transconductance = transistors_at(point).conductance[1, 0]
    flicker = model.flicker_n / (9e-12 * AMI_1500_IDEAL.n.oxide_capacitance * 0.01)
    load = 1.0 / (1.0 / 1e7 + transistors_at(point).conductance[0, 0])
    channel, resistor = noise_sources(point).white[[1, 0]] * load**2
    # at 0.01 Hz the load's pole is nine decades away
    assert dict(zip(found.devices, found.white[0], strict=True)) == pytest.approx(
        {"m": channel, "r": resistor}
    )
    assert found.flicker[0].sum() == pytest.approx(flicker * (transconductance * load) ** 2)
    assert found.output[0] == pytest.approx(channel + resistor + found.flicker[0].sum())
    gain = abs(ac(point, "g", f, ["y"]).transfer[0, 0])
    assert found.referred is not None
    assert found.referred[0] == pytest.approx(found.output[0] / gain**2)
    assert found.unit == "V^2/Hz"


def test_flicker_has_its_exponent_and_can_be_left_out() -> None:
    point, f = common_source(), np.array([1.0, 100.0])
    steep = noise(point, "y", f, model=NoiseModel(1e-24, 0.0, 1.25))
    assert steep.flicker.sum(axis=1)[0] / steep.flicker.sum(axis=1)[1] == pytest.approx(100.0**1.25)
    plain = noise(point, "y", f, model=WHITE_ONLY)
    assert not plain.flicker.any()
    assert plain.referred is None


def test_shares_are_in_order_and_add_up() -> None:
    found = noise(common_source(), "y", frequency_grid(1.0, 1e5, 10))
    shares = list(found.shares().values())
    assert shares == sorted(shares, key=sum, reverse=True)
    # integrals of parts and of the sum interpolate different powers between two points
    assert sum(map(sum, shares)) == pytest.approx(found.variance, rel=1e-3)


def test_junctions_make_noise_where_they_leak() -> None:
    leaky = replace(AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, junction_leakage=1e-9))
    bench = switch(0.5).machine.testbench
    found = noise_sources(operating_point(bench, Silicon(leaky)))
    assert found.kind == ("channel", "junction", "junction")
    assert found.device == ("m",) * 3
    assert (found.white > 0.0).all()


@pytest.mark.parametrize("kind", DEVICE_TYPES)
def test_every_device_type_says_what_noise_it_makes(kind: type[Device]) -> None:
    assert noise_of.dispatch(kind) is not noise_of.dispatch(object)


@pytest.mark.parametrize("power", [-2.0, -1.0, 0.0, 0.5])
def test_powers_are_integrated_exactly(power: float) -> None:
    f = frequency_grid(1.0, 1e4, 3)
    exact = np.log(1e4) if power == -1.0 else (1e4 ** (power + 1.0) - 1.0) / (power + 1.0)
    assert integrate_power(f, f**power) == pytest.approx(exact, rel=1e-9)
    assert integrate_power(f[:1], f[:1]) == 0.0
    assert integrate_power(f, np.zeros_like(f)) == 0.0


def test_a_fixed_node_has_no_noise() -> None:
    with pytest.raises(ParameterError, match="a: fixed by a source"):
        noise(operating_point(low_pass(Constant(0.0), 1.0)), "a", np.array([1.0]))


def test_noise_between_two_nodes_leaves_out_what_they_share() -> None:
    ports = (Port("a", "analog"), OUT, Port("z", "analog", "out"))
    devices = (Resistor("r", "a", "m", 1e3), Resistor("s", "m", "y", 2e3), Resistor("t", "m", "z", 3e3))
    ends = (Resistor("u", "y", "0", 1e12), Resistor("v", "z", "0", 1e12))
    circuit = Circuit("fork", ports, (*devices, *ends))
    point = operating_point(Testbench("fork", circuit, (Source("a", "a", Constant(0.0)),), 1.0))
    f, white = np.array([1.0]), 4.0 * BOLTZMANN * kelvin(27.0)
    assert noise(point, "y", f).output[0] == pytest.approx(white * 3e3, rel=1e-6)
    between = noise(point, "y", f, "a", reference="z")
    assert between.node == "v(y,z)"
    assert between.output[0] == pytest.approx(white * 5e3, rel=1e-6)
    assert noise(point, "y", f, "a", reference="a").gain == pytest.approx([0.0], abs=1e-8)
    assert noise(point, "a", f, reference="y").output[0] == pytest.approx(white * 3e3, rel=1e-6)
    with pytest.raises(ParameterError, match="a: fixed by a source"):
        noise(point, "a", f, reference="a")
    with pytest.raises(ParameterError, match="y: against y, which is the same node"):
        noise(point, "y", f, reference="y")
