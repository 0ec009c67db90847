"""The transistor's law against equation (1) of Cheely & Horiuchi (2003), its symmetries and derivatives."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.arrays import F64
from circuits.devices.transistor import (
    Transistor,
    TransistorWork,
    capacitances,
    drain_current,
    drain_currents,
    transistor_arrays,
    transistor_work,
)
from circuits.errors import ParameterError
from circuits.silicon.process import (
    AMI_1500,
    AMI_1500_IDEAL,
    ROLLS_180,
    Polarity,
    TransistorAtTemperature,
    TransistorModel,
    at_temperature,
)

UM = 1e-6
LAWS = {
    "ekv": AMI_1500_IDEAL.n,
    "ekv-gamma": replace(AMI_1500_IDEAL.n, law="ekv-gamma"),
    "early": replace(AMI_1500_IDEAL.n, early_field=1.0 / (0.03 * 3 * UM)),
    "everything": replace(AMI_1500_IDEAL.n, law="ekv-gamma", early_field=10e6, junction_leakage=1e-6),
    "full 1.5 um": AMI_1500.n,
    "full 0.18 um": ROLLS_180.n,
    "strongly reduced": replace(
        ROLLS_180.n, early_field=0.5e6, early_rise=1.0, mobility_reduction=5.0, junction_leakage=1e-6,
        gate_induced_leakage=1e-5, gate_induced_slope=0.5,
    ),
}  # fmt: skip
VOLTS = st.floats(min_value=0.0, max_value=5.0)


def at(model: TransistorModel, temperature_c: float = 27.0) -> TransistorAtTemperature:
    return at_temperature(model, AMI_1500_IDEAL, temperature_c)


def current(law: TransistorAtTemperature, d: float, g: float, s: float, b: float = 0.0) -> float:
    return float(drain_current(law, "n", 6 * UM, 3 * UM, d, g, s, b)[0])


def solve(model: TransistorModel, polarity: Polarity, v: F64) -> TransistorWork:
    law = at(model)
    one = np.ones(1)
    arrays = transistor_arrays(
        np.arange(4, dtype=np.int32)[:, None], polarity, law, 6 * UM * one, 3 * UM * one, one
    )
    work = transistor_work(1)
    drain_currents(arrays, v, work)
    return work


@given(
    st.floats(min_value=0.0, max_value=0.5),
    st.floats(min_value=0.0, max_value=0.3),
    st.floats(min_value=0.0, max_value=5.0),
)
def test_weak_inversion_is_equation_1(v_g: float, v_s: float, v_ds: float) -> None:
    law = at(AMI_1500_IDEAL.n)
    u_t, kappa = law.u_t, law.kappa
    v_ds += 1e-3
    i_0 = law.square_current * math.exp(-kappa * law.v_t0 / u_t)
    weak = i_0 * 2.0 * math.exp((kappa * v_g - v_s) / u_t) * (1.0 - math.exp(-v_ds / u_t))
    # ln^2(1 + y) = y^2 (1 - y + ...): the two terms' difference is off by at most 3/2 y, y = e^(u_f / 2)
    bound = 1.5 * math.exp((kappa * (v_g - law.v_t0) - v_s) / (2.0 * u_t))
    ours = current(law, v_s + v_ds, v_g, v_s)
    assert abs(ours / weak - 1.0) <= bound + 1e-11  # rounding: 1e-14 over v_ds / 2 U_T >= 0.02


def test_strong_inversion_is_the_square_law() -> None:
    law = at(AMI_1500_IDEAL.n)
    overdrive = law.kappa * (5.0 - law.v_t0)
    square = law.square_current * 2.0 * (overdrive / (2.0 * law.u_t)) ** 2
    assert current(law, 5.0, 5.0, 0.0) == pytest.approx(square, rel=1e-12)  # e^-60 is left out
    beta = 2.0 * AMI_1500_IDEAL.n.mu_cox
    assert square == pytest.approx(0.5 * beta * overdrive**2 / law.kappa, rel=1e-12)


@pytest.mark.parametrize("name", LAWS)
@given(v=st.tuples(VOLTS, VOLTS, VOLTS, VOLTS))
def test_a_mirrored_pfet_carries_the_opposite_current(
    name: str, v: tuple[float, float, float, float]
) -> None:
    n, p = solve(LAWS[name], "n", np.array(v)), solve(LAWS[name], "p", -np.array(v))
    assert p.current[0] == -n.current[0]
    np.testing.assert_array_equal(p.junction, -n.junction)
    np.testing.assert_array_equal(p.conductance, n.conductance)
    np.testing.assert_array_equal(p.junction_conductance, n.junction_conductance)


@pytest.mark.parametrize("name", ["ekv", "ekv-gamma", "early"])
@given(d=VOLTS, g=VOLTS, s=VOLTS)
def test_drain_and_source_are_exchangeable(name: str, d: float, g: float, s: float) -> None:
    law = at(LAWS[name])
    scale = law.square_current * 1e-13  # rounding of the two terms' difference, which may cancel
    assert current(law, d, g, s) == pytest.approx(-current(law, s, g, d), rel=1e-13, abs=scale)


@pytest.mark.parametrize("polarity", ["n", "p"])
@pytest.mark.parametrize("name", LAWS)
def test_derivatives_are_exact(name: str, polarity: Polarity) -> None:
    # Richardson's differences with h = 1 mV: the error is (h / 2 U_T)^4 / 5, about 3e-8 of the largest slope
    rng = np.random.default_rng(3)
    h, tolerance = 1e-3, 2e-7
    for _ in range(200):
        v = rng.uniform(-0.4, 3.0, 4)
        edge = np.abs(v[3] - v[[0, 2]] - 20.0 * at(LAWS[name]).u_t).min()
        if min(abs(v[0] - v[2]), edge) < 4 * h:  # where the Early effect and the junctions' law bend
            continue
        sign = 1.0 if polarity == "n" else -1.0
        work = solve(LAWS[name], polarity, sign * v)
        exact = np.array([*work.conductance[:, 0], -work.conductance[:, 0].sum()])
        junction = work.junction_conductance[:, 0].copy()
        numeric, numeric_junction = np.zeros(4), np.zeros((2, 4))
        for j in range(4):
            for step, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
                moved = sign * v
                moved[j] += step * h
                shifted = solve(LAWS[name], polarity, moved)
                numeric[j] += weight * shifted.current[0] / (12 * h)
                numeric_junction[:, j] += weight * shifted.junction[:, 0] / (12 * h)
        assert np.abs(numeric - exact).max() <= tolerance * np.abs(exact).max() + 1e-22
        (d, s), (dg, sg) = junction[:2], junction[2:]
        expected = [[d, dg, 0, -d - dg], [0, sg, s, -s - sg]]
        assert np.abs(numeric_junction - expected).max() <= 1e-5 * junction.max() + 1e-16


def test_law_with_body_effect_equals_the_other_at_pinch_off_zero() -> None:
    plain, body = LAWS["ekv"], LAWS["ekv-gamma"]
    v = np.array([2.0, plain.v_t0, 0.0, 0.0])
    a, b = solve(plain, "n", v), solve(body, "n", v)
    assert b.kappa[0] == pytest.approx(plain.kappa, rel=1e-12)
    assert b.current[0] == pytest.approx(a.current[0], rel=1e-10)


def test_kappa_moves_by_15_percent_over_the_source_voltage() -> None:
    model = LAWS["ekv-gamma"]
    law = at(model)

    def kappa_at(v_p: float) -> float:
        root = math.sqrt(v_p + law.surface_potential) + law.gamma / 2.0
        v_g = root**2 - law.gamma**2 / 4.0
        v_g += law.v_t0 - law.surface_potential - law.gamma * math.sqrt(law.surface_potential)
        return float(solve(model, "n", np.array([5.0, v_g, v_p, 0.0])).kappa[0])

    assert kappa_at(1.8) / kappa_at(0.0) - 1.0 == pytest.approx(0.15, abs=0.02)  # stated as "about 15 %"


def test_width_length_and_multiplicity_scale_the_current() -> None:
    law, one = at(AMI_1500_IDEAL.n), np.ones(1)
    v = np.array([2.0, 0.8, 0.1, 0.0])

    def scaled(width: float, length: float, multiplicity: float) -> float:
        terminal = np.arange(4, dtype=np.int32)[:, None]
        arrays = transistor_arrays(terminal, "n", law, width * one, length * one, multiplicity * one)
        work = transistor_work(1)
        drain_currents(arrays, v, work)
        return float(work.current[0])

    base = scaled(3 * UM, 1.5 * UM, 1.0)
    assert scaled(6 * UM, 1.5 * UM, 1.0) == pytest.approx(2.0 * base, rel=1e-14)
    assert scaled(3 * UM, 6.0 * UM, 1.0) == pytest.approx(0.25 * base, rel=1e-14)
    assert scaled(3 * UM, 1.5 * UM, 5.0) == pytest.approx(5.0 * base, rel=1e-14)


def test_mismatch_shifts_threshold_and_scales_current() -> None:
    law, one = at(AMI_1500_IDEAL.n), np.ones(1)
    v = np.array([2.0, 0.4, 0.0, 0.0])

    def with_mismatch(delta_v_t: float, relative_beta: float, shift: float) -> float:
        terminal = np.arange(4, dtype=np.int32)[:, None]
        arrays = transistor_arrays(terminal, "n", law, UM * one, UM * one, one, delta_v_t, relative_beta)
        work = transistor_work(1)
        drain_currents(arrays, v + np.array([0, shift, 0, 0]), work)
        return float(work.current[0])

    base = with_mismatch(0.0, 0.0, 0.0)
    assert with_mismatch(0.01, 0.0, 0.01) == pytest.approx(base, rel=1e-12)
    assert with_mismatch(0.0, 0.03, 0.0) == pytest.approx(1.03 * base, rel=1e-12)


def test_early_effect_is_off_by_default_and_proportional_to_the_drain_voltage() -> None:
    law, early = at(AMI_1500_IDEAL.n), at(LAWS["early"])
    assert current(law, 4.0, 0.7, 0.0) == pytest.approx(current(law, 2.0, 0.7, 0.0), rel=1e-14)
    ratio = current(early, 4.0, 0.7, 0.0) / current(law, 4.0, 0.7, 0.0)
    assert ratio == pytest.approx(1.0 + 0.03 * 4.0, rel=1e-12)


def test_off_current() -> None:
    # v_g = v_s = 0: I_S e^(-kappa V_T0 / U_T), about 1e-14 A; F(u) is 1 - e^(u/2) of e^u
    law = at(AMI_1500_IDEAL.n)
    expected = 2.0 * law.square_current * math.exp(-law.kappa * law.v_t0 / law.u_t)
    assert current(law, 5.0, 0.0, 0.0) == pytest.approx(expected, rel=1e-3)


def test_junction_leaks_to_the_bulk_and_doubles_every_9_kelvin() -> None:
    model = replace(AMI_1500_IDEAL.n, junction_leakage=1e-6)
    cold, warm, hot = at(model), at(model, 36.0), at(model, 45.0)
    assert warm.junction_leakage / cold.junction_leakage == pytest.approx(2.0, rel=1e-12)
    assert hot.junction_leakage / cold.junction_leakage == pytest.approx(4.0, rel=1e-12)
    work = solve(model, "n", np.array([5.0, 0.0, 0.0, 0.0]))
    assert work.junction[0, 0] == pytest.approx(1e-6 * 6 * UM, rel=1e-12)  # 5 V are 193 U_T
    assert work.junction[1, 0] == 0.0
    assert solve(AMI_1500_IDEAL.n, "n", np.array([5.0, 0.0, 0.0, 0.0])).junction[0, 0] == 0.0


def test_forward_junction_continues_smoothly_beyond_20_thermal_voltages() -> None:
    model = replace(AMI_1500_IDEAL.n, junction_leakage=1e-6)
    edge = 20.0 * at(model).u_t
    below = solve(model, "n", np.array([0.0, 0.0, 0.0, edge - 1e-9]))
    above = solve(model, "n", np.array([0.0, 0.0, 0.0, edge + 1e-9]))
    # a tangent: 2 nV are 8e-8 U_T, so that current and slope agree to 1e-7
    assert above.junction[0, 0] == pytest.approx(below.junction[0, 0], rel=1e-6)
    assert above.junction_conductance[0, 0] == pytest.approx(below.junction_conductance[0, 0], rel=1e-6)
    far = solve(model, "n", np.array([0.0, 0.0, 0.0, 50.0]))
    assert math.isfinite(far.junction[0, 0])


def test_current_of_the_function_includes_the_drain_junction() -> None:
    model = replace(AMI_1500_IDEAL.n, junction_leakage=1e-6)
    work = solve(model, "n", np.array([3.0, 0.5, 0.0, 0.0]))
    total = drain_current(at(model), "n", 6 * UM, 3 * UM, np.array([3.0]), 0.5, 0.0)
    assert total[0] == work.current[0] + work.junction[0, 0]


def test_capacitances_of_the_facts() -> None:
    # gate-bulk 0.5 * 1.1 fF/um^2, overlap 0.2 fF/um, junction 1.5 fF/um; 6 um by 3 um, twice
    found = capacitances(AMI_1500_IDEAL.n, np.array([6 * UM]), np.array([3 * UM]), np.array([2.0]))
    expected = {
        (1, 3): 2 * 9.9e-15,
        (1, 0): 2 * 1.2e-15,
        (1, 2): 2 * 1.2e-15,
        (0, 3): 2 * 9e-15,
        (2, 3): 2 * 9e-15,
    }
    assert {pair: float(c[0]) for pair, c in found.items()} == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("attribute", ["width", "length", "multiplicity"])
@pytest.mark.parametrize("value", [0.0, -1e-6, math.nan, math.inf])
def test_sizes_must_be_positive(attribute: str, value: float) -> None:
    good = Transistor("m1", "n", "d", "g", "s", "0", 1e-6, 1e-6)
    good.check()
    bad = {attribute: value}
    with pytest.raises(ParameterError, match=rf"m1\.{attribute}: .* must be > 0"):
        replace(good, **bad).check()  # type: ignore[arg-type]


def test_area_and_square_are_those_of_all_devices() -> None:
    device = Transistor("m", "n", "d", "g", "s", "b", 6 * UM, 3 * UM, 2.0)
    assert device.gate_area == pytest.approx(36 * UM**2, rel=1e-15)
    assert device.square == pytest.approx(4.0, rel=1e-15)
