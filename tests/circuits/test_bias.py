"""Biases: gate voltages invert the law, generators are proportional to absolute temperature."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.bias import (
    bias_voltages,
    closed_current,
    die_current,
    gate_voltage,
    rebias,
    saturation_current,
)
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Bias, BiasKind, Circuit, Port
from circuits.devices import Resistor, Transistor
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError, TopologyError, UnknownNameError
from circuits.registry import BLOCKS, load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, PROCESSES, Effects, Law, Polarity, at_temperature
from circuits.silicon.silicon import Silicon

UM = 1e-6
CURRENTS = st.floats(min_value=-13.0, max_value=-4.0).map(lambda x: 10.0**x)  # 0.1 pA to 100 uA
TEMPERATURES = st.floats(min_value=-40.0, max_value=125.0)


def mirror(polarity: Polarity = "n", multiplicity: float = 1.0) -> Transistor:
    bulk = "0" if polarity == "n" else "vdd"
    return Transistor("m1", polarity, "out", "gate", bulk, bulk, 6 * UM, 6 * UM, multiplicity)


def cell(kind: BiasKind, value: float | tuple[float, ...], polarity: Polarity = "n", **port: Any) -> Circuit:
    ports = (Port("vdd", "supply"), Port("out", "analog"), Port("gate", "bias", **port))
    device = mirror(polarity)
    if "shape" in port:
        device = replace(device, gate="gate[0]")
    name = None if kind == "voltage" else "m1"
    return Circuit("cell", ports, (device,), biases=(Bias("i_b", "gate", kind, value, name),))


@given(
    CURRENTS,
    TEMPERATURES,
    st.sampled_from(["n", "p"]),
    st.sampled_from(["ekv", "ekv-gamma"]),
    st.floats(1.0, 9.0),
)
def test_gate_voltage_inverts_the_law(
    current: float, temperature_c: float, polarity: Polarity, law_name: Law, multiplicity: float
) -> None:
    model = replace(AMI_1500_IDEAL.model(polarity), law=law_name)
    law = at_temperature(model, AMI_1500_IDEAL, temperature_c)
    device = mirror(polarity, multiplicity)
    v_g = gate_voltage(law, device, current)
    sign = 1.0 if polarity == "n" else -1.0
    # drain far in saturation (I_r < e^-1000), so that only the inversion's rounding is left: 1e-16 V_G / U_T
    i = sign * drain_current(law, polarity, 6 * UM, 6 * UM, sign * 60.0, sign * v_g, 0.0)[0]
    assert i * multiplicity == pytest.approx(current, rel=1e-11)


@pytest.mark.parametrize("current", [0.0, -1e-9, float("nan"), float("inf")])
def test_a_current_must_be_positive(current: float) -> None:
    law = at_temperature(AMI_1500_IDEAL.n, AMI_1500_IDEAL, 27.0)
    with pytest.raises(ParameterError, match=r"m1: bias current .* must be > 0"):
        gate_voltage(law, mirror(), current)


def test_a_current_below_that_at_flat_band_is_refused() -> None:
    law = at_temperature(replace(AMI_1500_IDEAL.n, law="ekv-gamma"), AMI_1500_IDEAL, 27.0)
    with pytest.raises(ParameterError, match="current at flat band"):
        gate_voltage(law, mirror(), 1e-21)


def test_a_gate_bias_stays_where_it_is_and_its_current_drifts() -> None:
    circuit = cell("gate", 200e-12)
    cold, hot = (
        bias_voltages(circuit, circuit.biases[0], Silicon(AMI_1500_IDEAL, temperature_c=t))
        for t in (0.0, 60.0)
    )
    assert cold == hot
    drift = [
        drain_current(
            at_temperature(AMI_1500_IDEAL.n, AMI_1500_IDEAL, t), "n", 6 * UM, 6 * UM, 2.0, float(cold), 0.0
        ).item()
        for t in (0.0, 27.0, 60.0)
    ]
    assert drift[1] == pytest.approx(200e-12, rel=1e-9)
    # from the delays of the design: 137, 27 and 5.5 ms; 20 % covers what else moves with temperature
    assert drift[1] / drift[0] == pytest.approx(137.0 / 27.0, rel=0.2)
    assert drift[2] / drift[1] == pytest.approx(27.0 / 5.5, rel=0.2)


@given(TEMPERATURES, st.sampled_from(["n", "p"]))
def test_a_generator_is_proportional_to_absolute_temperature(
    temperature_c: float, polarity: Polarity
) -> None:
    circuit = cell("ideal", 200e-12, polarity)
    v_gate = float(
        bias_voltages(circuit, circuit.biases[0], Silicon(AMI_1500_IDEAL, temperature_c=temperature_c))
    )
    law = at_temperature(AMI_1500_IDEAL.model(polarity), AMI_1500_IDEAL, temperature_c)
    source = 0.0 if polarity == "n" else AMI_1500_IDEAL.v_dd
    drain = AMI_1500_IDEAL.v_dd - source
    current = drain_current(law, polarity, 6 * UM, 6 * UM, drain, v_gate, source, source)
    expected = 200e-12 * (temperature_c + 273.15) / 300.15
    # 5 V are 145 U_T at 125 degC, so that only rounding is left
    assert abs(current[0]) == pytest.approx(expected, rel=1e-11)


def test_a_voltage_is_passed_on() -> None:
    circuit = cell("voltage", 1.8)
    assert (
        float(bias_voltages(circuit, circuit.biases[0], Silicon(AMI_1500_IDEAL, temperature_c=-40.0))) == 1.8
    )


def test_an_array_takes_one_value_or_one_an_element() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    one = bias_voltages(*_array((100e-12,) * 3), silicon)
    shared = bias_voltages(*_array(100e-12), silicon)
    assert one.shape == shared.shape == (3,)
    np.testing.assert_array_equal(one, shared)
    rising = bias_voltages(*_array((1e-12, 1e-11, 1e-10)), silicon)
    # weak inversion: a decade of current is U_T ln(10) / kappa of gate voltage, up to e^(u_f / 2) = 2 %
    decade = silicon.thermal_voltage * np.log(10.0) / 0.70
    np.testing.assert_allclose(np.diff(rising), decade, rtol=0.02)


def test_a_wrong_number_of_values_is_named() -> None:
    with pytest.raises(TopologyError, match=r"cell\.gate: values of shape \(2,\) for a port of shape \(3,\)"):
        bias_voltages(*_array((1e-12, 1e-11)), Silicon(AMI_1500_IDEAL))


def test_a_current_bias_needs_a_transistor() -> None:
    circuit = cell("gate", 1e-9)
    circuit = replace(circuit, devices=(*circuit.devices, Resistor("r1", "gate", "0", 1e6)))
    wrong = replace(circuit.biases[0], device="r1")
    with pytest.raises(TopologyError, match="r1 is no transistor"):
        bias_voltages(circuit, wrong, Silicon(AMI_1500_IDEAL))


def test_a_bias_needs_a_bias_port_and_a_known_device() -> None:
    circuit = cell("gate", 1e-9)
    with pytest.raises(TopologyError, match=r"cell\.out: a bias on a port of kind analog"):
        replace(circuit, biases=(Bias("b", "out", "voltage", 1.0),))
    with pytest.raises(TopologyError, match=r"cell\.gate: a gate bias must name the device"):
        replace(circuit, biases=(Bias("b", "gate", "gate", 1.0),))
    with pytest.raises(UnknownNameError, match="cell device m9: unknown; known are m1"):
        replace(circuit, biases=(Bias("b", "gate", "gate", 1.0, "m9"),))
    with pytest.raises(UnknownNameError, match="cell port nowhere"):
        replace(circuit, biases=(Bias("b", "nowhere", "voltage", 1.0),))


def test_rebias_sets_values_and_kind() -> None:
    circuit = cell("gate", 1e-9)
    changed = rebias(circuit, {"i_b": 2e-9}, "ideal")
    assert changed.bias("i_b") == Bias("i_b", "gate", "ideal", 2e-9, "m1")
    assert circuit.bias("i_b").value == 1e-9
    assert rebias(cell("voltage", 1.0), kind="ideal").bias("i_b").kind == "voltage"
    assert rebias(circuit) == circuit
    with pytest.raises(UnknownNameError, match=r"cell bias i_x: unknown; .*known are i_b"):
        rebias(circuit, {"i_x": 1.0})


def _array(value: float | tuple[float, ...]) -> tuple[Circuit, Bias]:
    circuit = cell("gate", value, shape=(3,))
    return circuit, circuit.biases[0]


def test_a_current_that_no_gate_within_the_supply_gives_is_refused() -> None:
    circuit = rebias(rebound_neuron.build(), {"i_inh_tau": 0.2})
    with pytest.raises(ParameterError, match=r"i_inh_tau: 0\.2 A needs .* V on the gate of mi5, beyond"):
        bias_voltages(circuit, circuit.bias("i_inh_tau"), Silicon(AMI_1500_IDEAL))


def test_the_current_on_a_die_is_that_of_its_own_device() -> None:
    neuron = rebound_neuron.build()
    bias = neuron.bias("i_rtau")
    assert die_current(neuron, bias, Silicon(AMI_1500_IDEAL)) == pytest.approx(400e-12, rel=1e-9)
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1003))
    mr2 = neuron.device("membrane.mr2")
    assert isinstance(mr2, Transistor)
    v_t0, beta = silicon.deviation(neuron.name, (("membrane", ()), ("mr2", ())), mr2.width * mr2.length)
    shift = silicon.law("p").v_t0 - Silicon(AMI_1500_IDEAL).law("p").v_t0 + float(np.ravel(v_t0)[0])
    scale = (
        silicon.law("p").square_current
        / Silicon(AMI_1500_IDEAL).law("p").square_current
        * (1 + float(np.ravel(beta)[0]))
    )
    # in weak inversion the current falls e-fold in U_T / kappa of the threshold; at 400 pA, a hundredth of
    # I_S, the EKV law is a tenth below that
    law = silicon.law("p")
    expected = 400e-12 * scale * math.exp(-law.kappa * shift / law.u_t)
    assert die_current(neuron, bias, silicon) == pytest.approx(expected, rel=0.1)
    with pytest.raises(TopologyError, match="no current bias"):
        die_current(neuron, neuron.bias("v_th"), silicon)


def test_a_gate_is_found_where_rounding_moves_the_last_digits() -> None:
    law = at_temperature(PROCESSES["rolls-180"].p, PROCESSES["rolls-180"], 85.0)
    width, length, current = 2.5294458853666325e-06, 8.246183089148465e-06, 2.3226759925730285e-07
    device = Transistor("m", "p", "d", "g", "s", "b", width, length)
    gate, near = (gate_voltage(law, device, i) for i in (current, current * (1.0 + 1e-6)))
    assert 0.0 < near - gate < 1e-6


@pytest.mark.parametrize("law", ["ideal", "full"])
def test_a_current_of_arrays_is_that_of_the_kernel(law: Effects) -> None:
    compared = []
    for block in map(load_block, BLOCKS):
        circuit = block.build()
        for bias in circuit.biases:
            if bias.kind != "voltage" and circuit.port(bias.port).shape == ():
                for celsius in (0.0, 27.0, 85.0):
                    silicon = Silicon(block.process.under(law), celsius)
                    found = closed_current(circuit, bias, silicon)
                    compared.append((found, float(saturation_current(circuit, bias, silicon))))
    found, kernel = np.transpose(compared)
    assert found.size > 300
    np.testing.assert_allclose(found, kernel, rtol=1e-13)
