"""The process against the rebound neuron's feasibility study, and the temperature laws over their range."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from circuits.silicon.process import (
    AMI_1500_IDEAL,
    HIGHEST_C,
    LOWEST_C,
    PROCESSES,
    at_temperature,
    check_temperature,
    kelvin,
    thermal_voltage,
)
from circuits.silicon.silicon import Silicon

TEMPERATURES = st.floats(min_value=LOWEST_C, max_value=HIGHEST_C)


def test_values_of_the_facts() -> None:
    n, p = AMI_1500_IDEAL.n, AMI_1500_IDEAL.p
    assert (n.v_t0, n.kappa, n.mu_cox) == (0.60, 0.70, 72e-6)
    assert (p.v_t0, p.kappa, p.mu_cox) == (0.85, 0.75, 25e-6)
    for model in (n, p):
        assert model.oxide_capacitance == pytest.approx(1.1e-15 / 1e-12)
        assert model.gate_bulk_fraction == 0.5
        assert model.overlap_capacitance == pytest.approx(0.2e-15 / 1e-6)
        assert model.junction_capacitance == pytest.approx(1.5e-15 / 1e-6)
        assert model.v_t0_drift == -1e-3
        assert (model.early_field, model.junction_leakage, model.law) == (0.0, 0.0, "ekv")
    assert AMI_1500_IDEAL.v_dd == 5.0
    assert AMI_1500_IDEAL.pair_a_vt == pytest.approx(28e-3 * 1e-6)
    assert AMI_1500_IDEAL.pair_a_beta == pytest.approx(0.02 * 1e-6)
    assert PROCESSES["ami-1500"].ideal() == AMI_1500_IDEAL
    assert AMI_1500_IDEAL.model("n") is n
    assert AMI_1500_IDEAL.model("p") is p


def test_thermal_voltage_of_the_facts() -> None:
    # 25.85 mV is 26.8 degC; at 27 degC it is 25.865 mV
    assert thermal_voltage(27.0) == pytest.approx(25.85e-3, rel=1e-3)
    assert Silicon(AMI_1500_IDEAL, temperature_c=27.0).thermal_voltage == thermal_voltage(27.0)
    assert kelvin(27.0) == 300.15


def test_specific_current_at_the_nominal_temperature() -> None:
    law = at_temperature(AMI_1500_IDEAL.n, AMI_1500_IDEAL, 27.0)
    expected = 2.0 * 72e-6 * thermal_voltage(27.0) ** 2 / 0.70
    assert law.square_current == pytest.approx(expected, rel=1e-14)
    assert (law.v_t0, law.kappa, law.gamma) == (0.60, 0.70, 0.0)


@given(TEMPERATURES)
def test_temperature_laws(temperature_c: float) -> None:
    model = replace(AMI_1500_IDEAL.n, junction_leakage=1e-6)
    law = at_temperature(model, AMI_1500_IDEAL, temperature_c)
    ratio = (temperature_c + 273.15) / 300.15
    assert law.u_t == pytest.approx(thermal_voltage(27.0) * ratio, rel=1e-12)
    assert law.v_t0 == pytest.approx(0.60 - 1e-3 * (temperature_c - 27.0), rel=1e-12)
    # I_S goes as mobility T^-1.5 times U_T^2
    nominal = at_temperature(model, AMI_1500_IDEAL, 27.0)
    assert law.square_current == pytest.approx(nominal.square_current * ratio**0.5, rel=1e-12)
    assert math.log2(law.junction_leakage / 1e-6) == pytest.approx((temperature_c - 27.0) / 9.0, abs=1e-9)
    assert (law.kappa, law.early_field) == (nominal.kappa, nominal.early_field)


@pytest.mark.parametrize("temperature_c", [LOWEST_C - 0.01, HIGHEST_C + 0.01, math.nan, -273.15, math.inf])
def test_outside_the_laws_is_refused(temperature_c: float) -> None:
    text = "must be within -40 to 125 degC"
    with pytest.raises(ParameterError, match=text):
        check_temperature(temperature_c)
    with pytest.raises(ParameterError, match=text):
        Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    with pytest.raises(ParameterError, match=text):
        at_temperature(AMI_1500_IDEAL.n, AMI_1500_IDEAL, temperature_c)


@pytest.mark.parametrize("temperature_c", [LOWEST_C, HIGHEST_C])
def test_the_ends_of_the_range_are_inside(temperature_c: float) -> None:
    assert Silicon(AMI_1500_IDEAL, temperature_c=temperature_c).temperature_c == temperature_c


def test_gamma_gives_kappa_at_pinch_off_zero() -> None:
    model = replace(AMI_1500_IDEAL.n, law="ekv-gamma")
    law = at_temperature(model, AMI_1500_IDEAL, 27.0)
    slope = 1.0 / (1.0 + law.gamma / (2.0 * math.sqrt(law.surface_potential)))
    assert slope == pytest.approx(model.kappa, rel=1e-12)
