"""Closed forms of the rebound neuron against published figures, their own limits and an integration.

Sources: Cheely & Horiuchi 2003, equations (1) to (17), with C_m = C_r = 600 fF, C_ex = 400 fF, C_inh = 440
fF; the feasibility study of the transistor-level neuron for transistors, biases, and the figures marked
`STUDY_*`.
"""

import inspect
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from circuits.blocks.sonar import rebound_equations as eq
from circuits.blocks.sonar.rebound_equation_table import EQUATIONS, Equation
from circuits.blocks.sonar.rebound_equations import ReboundParameters
from circuits.errors import ParameterError

U_T = 25.85e-3  # V
V_T0_N, KAPPA_N, MU_COX_N = 0.60, 0.70, 72e-6
V_T0_P, KAPPA_P, MU_COX_P = 0.85, 0.75, 25e-6
I_SN = eq.specific_current(MU_COX_N, KAPPA_N, U_T, 3 / 6)  # M1
I_SP = eq.specific_current(MU_COX_P, KAPPA_P, U_T, 6 / 3)  # M2, and the output pFET of the excitatory synapse
I_S_INVERTER = eq.specific_current(MU_COX_N, KAPPA_N, U_T, 3 / 1.5)  # charging diode, inverter's nFET
I_LIM = 6.3e-6  # A, the inverters' limited current
CALL_LENGTH = 10e-6  # s

STUDY_T_INH = 24.89e-3  # s, (3), neuron 12
STUDY_T_INH_PARASITICS = 26.38e-3  # s, with 466 fF
STUDY_T_INH_SIMULATED = 27.37e-3  # s, explained by about 484 fF
STUDY_T_REB_FIRST_LINE = 1.86e-3  # s
STUDY_T_REB_SECOND_LINE = 1.19e-3  # s, as printed
STUDY_T_REB_SIMULATED = 1.91e-3  # s
STUDY_PEAK_PRINTED = 3.35  # V
STUDY_PEAK_CORRECTED = 2.405  # V
STUDY_PEAK_SIMULATED = 2.38  # V

# The study gives t_inh alone. 24.89 ms * 40.1 pA / 440 fF = 2.268 V, which is V_inhH - V_hl; the split into
# the two is derived by `test_difference_of_voltages_follows_from_the_transistors`.
V_INH_SWING = 2.268  # V
V_HL = 0.953  # V

NEURON_12 = ReboundParameters(
    u_t=U_T,
    kappa_n=KAPPA_N,
    kappa_p=KAPPA_P,
    i_0n=eq.weak_inversion_prefactor(I_SN, KAPPA_N, V_T0_N, U_T),
    i_0p=eq.weak_inversion_prefactor(I_SP, KAPPA_P, V_T0_P, U_T),
    i_sn=I_SN,
    i_sp=I_SP,
    v_dd=5.0,
    v_rest=1.8,
    i_rslope=500e-12,
    i_rtau=400e-12,
    i_inh_tau=40.1e-12,
    i_ex_tau=19.7e-12,
    v_ex_max=4.301,
    c_m=600e-15,
    c_r=600e-15,
    c_ex=400e-15,
    c_inh=440e-15,
    v_inh_high=V_HL + V_INH_SWING,
    v_hl=V_HL,
)

# Parasitics by the study's figures, in fF with sizes in um: gate-bulk 0.55 W L, overlap 0.2 W, junction 1.5
# W.
GATE, OVERLAP, JUNCTION = 0.55e-15, 0.2e-15, 1.5e-15


def gate(width: float, length: float) -> float:
    return GATE * width * length + 2 * OVERLAP * width


def diffusion(width: float) -> float:
    return (OVERLAP + JUNCTION) * width


AT_V_INH = gate(6, 1.5) + gate(3, 1.5) + diffusion(3) + diffusion(6)
AT_V_MEM = 2 * gate(6, 3) + 3 * diffusion(3) + 2 * diffusion(6)  # M2, MC1; MI12, M1, MA8; MR1, ME5
AT_V_R = gate(3, 6) + 2 * diffusion(6)  # M1; M2, MR2
NEURON_12_PARASITICS = replace(NEURON_12, c_m=600e-15 + AT_V_MEM, c_r=600e-15 + AT_V_R)

voltage = st.floats(0.0, 5.0)
kappa = st.floats(0.5, 1.0)
current = st.floats(1e-12, 5e-9)
scale = st.floats(1e-20, 1e-13)


@st.composite
def parameters(draw: st.DrawFn) -> ReboundParameters:
    return replace(
        NEURON_12,
        u_t=draw(st.floats(0.02, 0.035)),
        kappa_n=draw(kappa),
        kappa_p=draw(kappa),
        i_0n=draw(scale),
        i_0p=draw(scale),
        v_rest=draw(st.floats(0.5, 3.0)),
        i_rslope=draw(current),
        i_rtau=draw(current),
    )


# Published figures. Tolerances of these are half a unit of the last digit that the source prints.


def test_inhibition_duration_is_the_published_one() -> None:
    assert eq.inhibition_duration_as_printed(NEURON_12) == pytest.approx(STUDY_T_INH, abs=0.005e-3)


def test_difference_of_voltages_follows_from_the_transistors() -> None:
    # The diode with its gate and drain at V_dd charges C_inh for the call's length. In weak inversion
    # C dV/dt = I_S e^((v_p - V)/U_T), so V = v_p + U_T ln(I_S t / (C U_T)).
    pinch_off = KAPPA_N * (NEURON_12.v_dd - V_T0_N)
    v_inh_high = pinch_off + U_T * math.log(I_S_INVERTER * CALL_LENGTH / ((440e-15 + AT_V_INH) * U_T))
    # The inverter switches where its nFET carries the limited current: I_lim = I_S ln^2(1 + e^(v_p/2U_T)).
    v_hl = V_T0_N + 2 * U_T / KAPPA_N * math.log(math.expm1(math.sqrt(I_LIM / I_S_INVERTER)))
    assert v_hl == pytest.approx(NEURON_12.v_hl, abs=0.5e-3)
    assert v_inh_high - v_hl == pytest.approx(V_INH_SWING, abs=1e-3)


def test_parasitics_explain_the_inhibition_duration() -> None:
    assert pytest.approx(466e-15, abs=0.5e-15) == 440e-15 + AT_V_INH
    with_parasitics = eq.inhibition_duration(NEURON_12, 440e-15 + AT_V_INH)
    assert with_parasitics == pytest.approx(STUDY_T_INH_PARASITICS, abs=0.01e-3)
    # "about 484 fF": half a unit of it is 0.1 %, 0.03 ms.
    assert eq.inhibition_duration(NEURON_12, 484e-15) == pytest.approx(STUDY_T_INH_SIMULATED, abs=0.03e-3)


def test_rebound_durations_are_the_published_ones() -> None:
    assert eq.rebound_duration(NEURON_12) == pytest.approx(STUDY_T_REB_FIRST_LINE, abs=0.005e-3)
    assert eq.rebound_duration_as_printed(NEURON_12) == pytest.approx(STUDY_T_REB_SECOND_LINE, abs=0.005e-3)


def test_printed_peak_is_the_published_one() -> None:
    peak = eq.rebound_peak_as_printed(NEURON_12, eq.rebound_duration(NEURON_12))
    assert peak == pytest.approx(STUDY_PEAK_PRINTED, abs=0.005)


def test_corrected_peak_needs_the_parasitics() -> None:
    """The study's 2.405 V is not what the corrected (13) gives for the paper's capacitors, 2.483 V.

    With the study's own parasitics at v_mem and v_r it is 2.415 V, 10 mV above; the study does not say which
    it used.
    """
    drawn = eq.rebound_peak(NEURON_12, eq.rebound_duration(NEURON_12))
    whole = eq.rebound_peak(NEURON_12_PARASITICS, eq.rebound_duration(NEURON_12_PARASITICS))
    assert drawn == pytest.approx(2.483, abs=0.5e-3)
    assert whole == pytest.approx(2.415, abs=0.5e-3)
    assert whole == pytest.approx(STUDY_PEAK_CORRECTED, abs=0.015)


def test_rebound_with_parasitics_is_near_the_transistor_simulation() -> None:
    """Within 3 % and 20 mV: capacitances lumped to ground, comparator and inverter left out."""
    duration = eq.rebound_duration(NEURON_12_PARASITICS)
    assert duration == pytest.approx(STUDY_T_REB_SIMULATED, rel=0.03)
    assert eq.rebound_peak_rounded(NEURON_12_PARASITICS, duration) == pytest.approx(
        STUDY_PEAK_SIMULATED, abs=0.02
    )


def test_release_current_of_the_print_is_absurd() -> None:
    v_r = eq.rebound_slow_minimum(NEURON_12)
    printed = eq.membrane_release_rate_as_printed(NEURON_12, v_r, 0.0) * NEURON_12.c_m
    corrected = eq.membrane_release_rate(NEURON_12, v_r, 0.0) * NEURON_12.c_m
    assert math.floor(math.log10(printed)) == 6
    assert corrected == pytest.approx(17e-6, abs=0.5e-6)  # the figure that the table of equations states


def test_largest_excitatory_current() -> None:
    assert eq.excitatory_peak_current_ekv(NEURON_12) == pytest.approx(1e-9, rel=0.005)  # the study's 1 nA
    ratio = eq.excitatory_peak_current(NEURON_12) / eq.excitatory_peak_current_ekv(NEURON_12)
    assert ratio == pytest.approx(1.11, abs=0.005)


# Limits and algebra. Tolerances are rounding errors unless said.


@given(parameters(), voltage, voltage)
def test_saturation_is_the_limit_of_the_drain_current(p: ReboundParameters, v_g: float, v_s: float) -> None:
    # e^-40 = 4e-18 is below rounding.
    full = eq.nfet_current(p, v_g, v_s, v_s + 40 * p.u_t)
    assert eq.nfet_saturation_current(p, v_g, v_s) == pytest.approx(full, rel=1e-12)
    full = eq.pfet_current(p, v_g, v_s, v_s + 40 * p.u_t)
    assert eq.pfet_saturation_current(p, v_g, v_s) == pytest.approx(full, rel=1e-12)


@pytest.mark.parametrize("law", [eq.nfet_current, eq.pfet_current, eq.nfet_current_ekv, eq.pfet_current_ekv])
@given(v_g=voltage, v_s=voltage, v_d=voltage)
def test_source_and_drain_are_symmetric(
    law: Callable[[ReboundParameters, float, float, float], float], v_g: float, v_s: float, v_d: float
) -> None:
    assert law(NEURON_12, v_g, v_s, v_d) == -law(NEURON_12, v_g, v_d, v_s)
    assert law(NEURON_12, v_g, v_s, v_s) == 0.0


@given(st.floats(0.0, 1.0), st.floats(0.3, 5.0), st.floats(0.05, 1.0))
def test_ekv_reduces_to_weak_inversion(v_g: float, v_s: float, v_ds: float) -> None:
    # u_f <= (0.7 * (1 - 0.6) - 0.3) / U_T < 0; ln^2(1 + e^(u/2)) = e^u (1 - e^(u/2) + ...) bounds the
    # difference.
    u_f = (KAPPA_N * (v_g - V_T0_N) - v_s) / U_T
    weak = eq.nfet_current(NEURON_12, v_g, v_s, v_s + v_ds)
    ekv = eq.nfet_current_ekv(NEURON_12, v_g, v_s, v_s + v_ds)
    # The difference of the squares gains at most a factor 1 / (1 - e^(-v_ds/U_T)) <= 1.17.
    assert weak * (1 - 1.2 * math.exp(u_f / 2) - 1e-9) <= ekv <= weak * (1 + 1e-9)


def test_ekv_is_a_square_law_in_strong_inversion() -> None:
    v_g, v_s = 4.0, 0.0
    pinch_off = KAPPA_N * (v_g - V_T0_N)
    square = I_SN * ((pinch_off - v_s) / (2 * U_T)) ** 2
    # ln(1 + e^(u/2)) - u/2 = e^(-46) there; the drain, 1.6 V above the pinch-off voltage, carries e^-62.
    assert eq.nfet_current_ekv(NEURON_12, v_g, v_s, 4.0) == pytest.approx(square, rel=1e-12)


def test_ekv_does_not_overflow() -> None:
    assert math.isfinite(eq.nfet_current_ekv(replace(NEURON_12, u_t=1e-4), 5.0, 0.0, 5.0))


@given(parameters())
def test_equilibria_balance_the_currents(p: ReboundParameters) -> None:
    v_r = eq.rebound_slow_equilibrium(p)
    # Exponents reach 300, so rounding grows to 1e-13.
    assert eq.nfet_saturation_current(p, v_r, p.v_rest) == pytest.approx(p.i_rslope, rel=1e-10)
    v_mem = eq.membrane_equilibrium_from_slow(p, v_r)
    assert eq.pfet_saturation_current(p, p.v_dd - v_mem, p.v_dd - v_r) == pytest.approx(p.i_rtau, rel=1e-10)
    assert eq.membrane_equilibrium_as_printed(p) == pytest.approx(v_mem, rel=1e-12, abs=1e-12)
    v_min = eq.rebound_slow_minimum(p)
    assert eq.pfet_saturation_current(p, p.v_dd, p.v_dd - v_min) == pytest.approx(p.i_rtau, rel=1e-10)


@given(parameters())
def test_kappa_one_makes_the_equilibrium_ideal(p: ReboundParameters) -> None:
    ideal = replace(p, kappa_n=1.0, kappa_p=1.0)
    full = eq.membrane_equilibrium_as_printed(ideal)
    assert eq.ideal_membrane_equilibrium(ideal) == pytest.approx(full, abs=1e-12)
    matched = replace(ideal, i_0p=ideal.i_0n)
    full = eq.membrane_equilibrium_as_printed(matched)
    assert eq.ideal_membrane_equilibrium_as_printed(matched) == pytest.approx(full, abs=1e-12)


def test_printed_ideal_equilibrium_cancels_two_different_prefactors() -> None:
    ideal = replace(NEURON_12, kappa_n=1.0, kappa_p=1.0)
    difference = eq.membrane_equilibrium_as_printed(ideal) - eq.ideal_membrane_equilibrium_as_printed(ideal)
    assert difference == pytest.approx(U_T * math.log(ideal.i_0p / ideal.i_0n), abs=1e-12)
    assert abs(difference) > 8 * U_T


@given(parameters())
def test_rest_balances_both_transistors(p: ReboundParameters) -> None:
    v_mem = eq.membrane_rest(p)
    v_r = p.u_t * math.log(p.i_rtau / p.i_0p) + p.v_dd - p.kappa_p * (p.v_dd - v_mem)
    gate_term = math.log(p.i_0n / p.i_rslope) + (p.kappa_n * v_r - p.v_rest) / p.u_t
    x = (v_mem - p.v_rest) / p.u_t
    if x > 1e-6:  # below it V_mem - V_rest is lost in the digits of V_rest
        # V_mem carries 1e-16 V / U_T of rounding, which 1 / x magnifies.
        assert gate_term + math.log(-math.expm1(-x)) == pytest.approx(0.0, abs=1e-12 + 1e-13 / x)
    assert v_mem >= max(p.v_rest, eq.membrane_equilibrium_as_printed(p)) - 1e-12


def test_rest_is_the_saturated_one_where_that_is_far_above() -> None:
    high = replace(NEURON_12, i_rslope=50e-9, i_rtau=1e-12)
    assert eq.membrane_equilibrium_as_printed(high) - high.v_rest > 10 * U_T
    assert eq.membrane_rest(high) == pytest.approx(eq.membrane_equilibrium_as_printed(high), abs=0.01 * U_T)


def test_rest_by_an_independent_root() -> None:
    def excess(v_mem: float) -> float:
        v_r = brentq(
            lambda v: eq.pfet_saturation_current(NEURON_12, 5.0 - v_mem, 5.0 - v) - 400e-12, 2.0, 4.0
        )
        return eq.nfet_current(NEURON_12, v_r, NEURON_12.v_rest, v_mem) - 500e-12

    # The inner root is good to 2e-12 V by brentq's default.
    assert eq.membrane_rest(NEURON_12) == pytest.approx(brentq(excess, 1.8, 1.9), abs=1e-10)


def test_published_biases_leave_saturation_although_rslope_exceeds_rtau() -> None:
    assert NEURON_12.i_rslope > NEURON_12.i_rtau
    assert eq.membrane_equilibrium_as_printed(NEURON_12) < NEURON_12.v_rest - 5 * U_T
    assert 0.0 < eq.membrane_rest(NEURON_12) - NEURON_12.v_rest < 0.1 * U_T


def test_slow_minimum_moves_with_kappa_by_the_supply() -> None:
    # Linear in kappa_p when I_0 is held, so the central difference is exact up to rounding.
    h = 1e-3
    low, high = (eq.rebound_slow_minimum(replace(NEURON_12, kappa_p=KAPPA_P + s * h)) for s in (-1, 1))
    assert (high - low) / (2 * h) == pytest.approx(-NEURON_12.v_dd, rel=1e-10)


@given(parameters())
def test_second_line_of_the_duration_equals_the_first(p: ReboundParameters) -> None:
    # 1e-12 of V_dd C_r / I_rtau, since the bracket's terms may cancel.
    rounding = 1e-12 * p.v_dd * p.c_r / p.i_rtau
    assert eq.rebound_duration_expanded(p) == pytest.approx(eq.rebound_duration(p), abs=rounding)
    assert eq.excited_rise_time(p, 0.0) == eq.rebound_duration_expanded(p)
    assert eq.excited_rise_time_as_printed(p, 0.0) == eq.rebound_duration_as_printed(p)


@given(parameters())
def test_printed_second_line_is_right_for_kappa_one_and_equal_prefactors(p: ReboundParameters) -> None:
    ideal = replace(p, kappa_n=1.0, i_0n=p.i_0p)
    rounding = 1e-12 * p.v_dd * p.c_r / p.i_rtau
    assert eq.rebound_duration_as_printed(ideal) == pytest.approx(eq.rebound_duration(ideal), abs=rounding)


@given(parameters(), current)
def test_excitation_lengthens_and_raises_the_rebound(p: ReboundParameters, i_ex: float) -> None:
    gain = eq.excited_rise_time(p, i_ex) - eq.rebound_duration(p)
    expected = p.c_r * p.u_t / (p.kappa_n * p.i_rtau) * math.log1p(i_ex / p.i_rslope)
    assert gain == pytest.approx(expected, abs=1e-12 * p.v_dd * p.c_r / p.i_rtau)
    assert eq.excited_rise_rate(p, i_ex) > eq.rebound_rise_rate(p)


def test_corrected_peak_starts_at_the_follower_level() -> None:
    t_reb = eq.rebound_duration(NEURON_12)
    start = KAPPA_N * eq.rebound_slow_minimum(NEURON_12) - U_T * math.log(NEURON_12.i_rslope / NEURON_12.i_0n)
    assert eq.nfet_saturation_current(NEURON_12, eq.rebound_slow_minimum(NEURON_12), start) == pytest.approx(
        500e-12
    )
    peak = start + eq.rebound_rise_rate(NEURON_12) * t_reb
    assert eq.rebound_peak(NEURON_12, t_reb) == pytest.approx(peak, abs=1e-12)
    assert eq.excited_peak(NEURON_12, 0.0, t_reb) == eq.rebound_peak(NEURON_12, t_reb)
    assert eq.excited_peak_as_printed(NEURON_12, 0.0, t_reb) == eq.rebound_peak_as_printed(NEURON_12, t_reb)


def test_overshoot_starts_where_the_condition_says() -> None:
    least = KAPPA_N * NEURON_12.i_rtau * NEURON_12.c_m / NEURON_12.c_r
    above, below = (replace(NEURON_12, i_rslope=least * factor) for factor in (1.01, 0.99))
    assert eq.rebound_peak(above, 1e-3) > NEURON_12.v_rest > eq.rebound_peak(below, 1e-3)
    with pytest.raises(ParameterError, match=r"rebound\.i_rslope: .* A, must with I_ex exceed"):
        eq.rebound_peak_rounded(below, 1e-3)


# Excitatory current.


def decay_rate(law: Callable[[ReboundParameters, float], float], t: float) -> float:
    h = 1e-6  # s, against a time constant of 0.7 ms; an exponential's logarithm is linear, so h may be large
    return (math.log(law(NEURON_12, t - h)) - math.log(law(NEURON_12, t + h))) / (2 * h)


@pytest.mark.parametrize("t", [0.1e-3, 1e-3, 5e-3])
def test_decay_rate_of_the_excitatory_current(t: float) -> None:
    # Rounding of the two logarithms, 4e-15 each, over 2e-6 s is 4e-9 / s; the slower, printed rate is 37 / s.
    rate = decay_rate(eq.excitatory_current, t)
    assert rate == pytest.approx(1 / eq.excitatory_time_constant(NEURON_12), rel=1e-6)
    # The print is slower by U_T in volts.
    assert decay_rate(eq.excitatory_current_as_printed, t) == pytest.approx(rate * U_T, rel=1e-5)


def test_excitatory_current_starts_at_the_largest_and_ends_at_the_prefactor() -> None:
    p = NEURON_12
    recovered = p.c_ex * (p.v_dd - p.v_ex_max) / p.i_ex_tau
    assert eq.excitatory_current(p, 0.0) == eq.excitatory_peak_current(p)
    for t in (recovered, 2 * recovered):
        assert eq.excitatory_current(p, t) == pytest.approx(p.i_0p, rel=1e-12)


# The two-node circuit, integrated with the EKV law: M1, M2, C_m, C_r from the release on.


def integrate(p: ReboundParameters, i_ex: float) -> tuple[float, float]:
    """Time (s) and height (V) of the first peak of v_mem, started at v_mem = 0 and v_r = V_r,min."""

    def rates(_: float, y: np.ndarray) -> tuple[float, float]:
        v_mem, v_r = y
        m2 = eq.pfet_current_ekv(p, p.v_dd - v_mem, p.v_dd - v_r, p.v_dd)
        return eq.membrane_release_rate(p, v_r, v_mem) + i_ex / p.c_m, (p.i_rtau - m2) / p.c_r

    def peak(t: float, y: np.ndarray) -> float:
        return rates(t, y)[0]

    peak.terminal, peak.direction = True, -1.0  # type: ignore[attr-defined]
    start = [0.0, eq.rebound_slow_minimum(p)]
    end = 3 * eq.rebound_duration(p)
    run = solve_ivp(rates, (0.0, end), start, method="Radau", rtol=1e-8, atol=1e-10, events=peak)
    assert run.t_events[0].size == 1
    return float(run.t_events[0][0]), float(run.y_events[0][0][0])


@pytest.mark.parametrize("i_ex", [0.0, 100e-12, 500e-12])
@pytest.mark.parametrize("p", [NEURON_12, NEURON_12_PARASITICS], ids=["drawn", "parasitics"])
def test_corrected_forms_agree_with_the_integration(p: ReboundParameters, i_ex: float) -> None:
    time, height = integrate(p, i_ex)
    t_r = eq.excited_rise_time(p, i_ex)
    # The EKV law asks for e^(u/2) U_T / kappa_n more of v_r than (2), with u = ln(I/I_Sn) <= -4.2 that of M1
    # at the peak: 4.5 mV, 0.4 % of v_r's rise of 1.2 V.
    assert time == pytest.approx(t_r, rel=0.005)
    # (16) leaves out the rounding of both ends, below r U_T with r <= 3.6 here. The rounded form leaves
    # out the EKV law at both ends: each is below e^(u/2) r U_T = 11 mV, of opposite signs; 3.1 mV remain.
    assert eq.excited_peak(p, i_ex, t_r) == pytest.approx(height, abs=3.6 * U_T)
    assert eq.excited_peak_rounded(p, i_ex, t_r) == pytest.approx(height, abs=0.004)
    assert eq.excited_peak_as_printed(p, i_ex, t_r) - height > 30 * U_T
    assert abs(eq.excited_rise_time_as_printed(p, i_ex) / time - 1) > 0.3


def test_rounded_peaks_agree_without_excitation() -> None:
    t_reb = eq.rebound_duration(NEURON_12)
    time, height = integrate(NEURON_12, 0.0)
    assert eq.rebound_peak_rounded(NEURON_12, t_reb) == pytest.approx(height, abs=1e-3)
    assert eq.excited_peak_rounded(NEURON_12, 0.0, t_reb) == eq.rebound_peak_rounded(NEURON_12, t_reb)
    # v_r at the peak is V_r,eq, plus what the EKV law asks for beyond (2), to a fifth of that.
    v_r = eq.rebound_slow_minimum(NEURON_12) + eq.rebound_slow_rate(NEURON_12) * time
    more = U_T / KAPPA_N * math.sqrt(NEURON_12.i_rslope / I_SN)
    assert v_r - eq.rebound_slow_equilibrium(NEURON_12) == pytest.approx(more, rel=0.2)


# Parameters and the table.


@pytest.mark.parametrize(
    ("field", "value", "text"),
    [
        ("u_t", 0.0, "rebound.u_t: 0 V, must be finite and > 0"),
        ("i_rtau", -1e-12, "rebound.i_rtau: -1e-12 A, must be finite and > 0"),
        ("i_ex_tau", 0.0, "rebound.i_ex_tau: 0 A, must be finite and > 0"),
        ("c_m", math.nan, "rebound.c_m: nan F, must be finite and > 0"),
        ("v_rest", -1.0, "rebound.v_rest: -1 V, must be finite and >= 0"),
        ("kappa_p", 1.2, "rebound.kappa_p: 1.2, must be <= 1"),
        ("v_ex_max", 6.0, "rebound.v_ex_max: 6 V, must be <= v_dd (5 V)"),
        ("v_hl", 4.0, "rebound.v_hl: 4 V, must be < v_inh_high (3.221 V)"),
    ],
)
def test_parameters_are_checked(field: str, value: float, text: str) -> None:
    with pytest.raises(ParameterError) as raised:
        replace(NEURON_12, **{field: value})
    assert str(raised.value) == text


def test_effective_capacitance_is_checked() -> None:
    with pytest.raises(ParameterError, match=r"^rebound\.c_effective: -1 F, must be finite and > 0$"):
        eq.inhibition_duration(NEURON_12, -1.0)


def test_table_has_every_equation_in_order() -> None:
    numbers = [each.number for each in EQUATIONS]
    assert sorted(set(numbers)) == list(range(1, 18))
    assert numbers == sorted(numbers)
    assert len({each.name for each in EQUATIONS}) == len(EQUATIONS)


ARGUMENTS = {
    "p": NEURON_12,
    "v_gb": 2.0,
    "v_sb": 1.0,
    "v_db": 3.0,
    "v_bg": 2.0,
    "v_bs": 1.0,
    "v_bd": 3.0,
    "v_r": 2.0,
    "v_mem": 0.5,
    "t": 1e-3,
    "t_reb": 1.86e-3,
    "t_r": 2e-3,
    "i_ex": 1e-10,
    "c_effective": 484e-15,
}


@pytest.mark.parametrize("equation", EQUATIONS, ids=lambda each: f"{each.number}-{each.name}")
def test_table_entry_can_be_shown(equation: Equation) -> None:
    assert equation.difference.endswith(".")
    assert (equation.corrected is None) == (equation.corrected_form is None)
    functions = [equation.printed] if equation.corrected is None else [equation.printed, equation.corrected]
    values = []
    for function in functions:
        assert f"({equation.number})" in (function.__doc__ or "")
        names = list(inspect.signature(function).parameters)
        assert names[0] == "p"
        values.append(function(*(ARGUMENTS[name] for name in names)))
    assert all(math.isfinite(value) for value in values)
    assert len(set(values)) == len(values)  # a correction that changes nothing is none
