"""Equations (1) to (17) of Cheely & Horiuchi (2003), each as printed and as corrected."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from circuits.blocks.sonar import rebound_equations as eq


@dataclass(frozen=True, slots=True)
class Equation:
    """One equation of the paper, as printed and as corrected.

    printed, corrected: functions that take `ReboundParameters` first; `corrected` is None where the print
    holds under its own assumptions. printed_form, corrected_form: their texts. difference: what differs.
    """

    number: int
    name: str
    printed: Callable[..., float]
    printed_form: str
    difference: str
    corrected: Callable[..., float] | None = None
    corrected_form: str | None = None


EQUATIONS: tuple[Equation, ...] = (
    Equation(
        1,
        "nFET drain current",
        eq.nfet_current,
        "I_dn = I_0 e^(kappa_n V_GB/V_T) (e^(-V_SB/V_T) - e^(-V_DB/V_T))",
        "Weak inversion only, where the EKV law reduces to it. V_T is U_T, I_0 that of the device.",
        eq.nfet_current_ekv,
        "I_dn = I_Sn [F(u_f) - F(u_r)], F(u) = ln^2(1 + e^(u/2))",
    ),
    Equation(
        1,
        "pFET drain current",
        eq.pfet_current,
        "I_dp = I_0 e^(kappa_p V_BG/V_T) (e^(-V_BS/V_T) - e^(-V_BD/V_T))",
        "As for the nFET, whose I_0 it does not share; the bulk is at V_dd, which (5) and (8) require.",
        eq.pfet_current_ekv,
        "I_dp = I_Sp [F(u_f) - F(u_r)], F(u) = ln^2(1 + e^(u/2))",
    ),
    Equation(
        2,
        "nFET saturation current",
        eq.nfet_saturation_current,
        "I_dn = I_0 e^((kappa_n V_GB - V_SB)/V_T)",
        "Nothing: the limit of (1) for a high drain.",
    ),
    Equation(
        2,
        "pFET saturation current",
        eq.pfet_saturation_current,
        "I_dp = I_0 e^((kappa_p V_BG - V_BS)/V_T)",
        "Nothing: the limit of (1) for a low drain.",
    ),
    Equation(
        3,
        "duration of inhibition",
        eq.inhibition_duration_as_printed,
        "t_inh = C_inh (V_inhH - V_hl) / I_inh_tau",
        "C_inh is not all that I_inh_tau discharges: gates, junctions and the diode's node add about 10 %.",
        eq.inhibition_duration,
        "t_inh = C_eff (V_inhH - V_hl) / I_inh_tau",
    ),
    Equation(
        4,
        "equilibrium of v_r",
        eq.rebound_slow_equilibrium,
        "V_r,eq = (V_rest + V_T ln(I_rslope/I_0)) / kappa_n",
        "I_0 is the nFET's. Holds at the peak of the rebound; at rest only while M1 is saturated.",
    ),
    Equation(
        5,
        "equilibrium of v_mem from v_r",
        eq.membrane_equilibrium_from_slow,
        "V_mem,eq = (V_r,eq - V_T ln(I_rtau/I_0)) / kappa_p + V_dd (1 - 1/kappa_p)",
        "I_0 is the pFET's, its bulk at V_dd. V_r,eq is not v_r at rest where M1 is not saturated.",
    ),
    Equation(
        6,
        "equilibrium of v_mem",
        eq.membrane_equilibrium_as_printed,
        "V_mem,eq = V_rest/(kappa_n kappa_p) + V_T ln(I_rslope/I_0)/(kappa_n kappa_p)"
        " - V_T ln(I_rtau/I_0)/kappa_p + V_dd (1 - 1/kappa_p)",
        "Two different I_0, nFET's then pFET's. Where it is below V_rest M1 is not saturated and v_mem rests"
        " just above V_rest, even for I_rslope > I_rtau.",
        eq.membrane_rest,
        "kappa_n kappa_p (V_mem - V_mem,eq)/U_T + ln(1 - e^((V_rest - V_mem)/U_T)) = 0, V_mem,eq from (6)",
    ),
    Equation(
        7,
        "equilibrium of v_mem for kappa 1",
        eq.ideal_membrane_equilibrium_as_printed,
        "V_mem,eq = V_rest + V_T ln(I_rslope/I_rtau)",
        "Cancels the nFET's I_0 against the pFET's.",
        eq.ideal_membrane_equilibrium,
        "V_mem,eq = V_rest + U_T ln(I_rslope I_0p / (I_rtau I_0n))",
    ),
    Equation(
        8,
        "minimum of v_r",
        eq.rebound_slow_minimum,
        "V_r,min = V_t ln(I_rtau/I_0) + V_dd (1 - kappa_p)",
        "V_t is V_T, that is U_T; I_0 is the pFET's, its bulk at V_dd. Fragile: extrapolates a constant"
        " kappa_p over V_dd, so that 0.01 of kappa_p moves it by V_dd / 100.",
    ),
    Equation(
        9,
        "rate of v_mem at the release",
        eq.membrane_release_rate_as_printed,
        "dV_mem/dt = [I_rslope + I_0 e^(kappa_n V_r/V_T) (e^(-V_mem/V_t) - e^(-V_rest/V_t))] / C_m",
        "V_t is V_T, that is U_T. M1 is in strong inversion at the release: the print implies about 1e6 A,"
        " the EKV law 17 uA.",
        eq.membrane_release_rate,
        "dV_mem/dt = (I_rslope + I_Sn [F(u_f) - F(u_r)]) / C_m",
    ),
    Equation(
        10,
        "rate of v_r",
        eq.rebound_slow_rate,
        "dV_r/dt = I_rtau / C_r",
        "Nothing while M2 carries no current.",
    ),
    Equation(
        11,
        "rate of v_mem in the rebound",
        eq.rebound_rise_rate,
        "dV_mem/dt = I_rslope / C_m",
        "Nothing while M1 carries no current; that is so once v_mem is several U_T above the follower's"
        " level, which is below V_rest.",
    ),
    Equation(
        12,
        "duration of the rebound, first line",
        eq.rebound_duration,
        "t_reb = C_r (V_r,eq - V_r,min) / I_rtau",
        "Nothing.",
    ),
    Equation(
        12,
        "duration of the rebound, second line",
        eq.rebound_duration_as_printed,
        "t_reb = C_r (V_rest + V_T ln(I_rslope/I_rtau) + V_dd (kappa_p - 1)) / (kappa_n I_rtau)",
        "kappa_n is missing at the terms of I_rtau and V_dd; the I_0 cancel only for kappa_n = 1 and"
        " I_0n = I_0p.",
        eq.rebound_duration_expanded,
        "t_reb = C_r (V_rest + U_T ln(I_rslope/I_0n) - kappa_n U_T ln(I_rtau/I_0p)"
        " + kappa_n V_dd (kappa_p - 1)) / (kappa_n I_rtau)",
    ),
    Equation(
        13,
        "peak of the rebound",
        eq.rebound_peak_as_printed,
        "V_m,peak = V_rest + I_rslope t_reb / C_m",
        "v_mem does not rise to V_rest at once: V_r,min < V_r,eq holds it kappa_n (V_r,eq - V_r,min) lower."
        " An overshoot needs I_rslope/C_m > kappa_n I_rtau/C_r.",
        eq.rebound_peak,
        "V_m,peak = V_rest + t_reb (I_rslope/C_m - kappa_n I_rtau/C_r)",
    ),
    Equation(
        14,
        "rate of v_mem with excitation",
        eq.excited_rise_rate,
        "dV_mem/dt = (I_ex + I_rslope) / C_m",
        "Nothing while M1 carries no current.",
    ),
    Equation(
        15,
        "rise time with excitation",
        eq.excited_rise_time_as_printed,
        "t_r = C_r (V_rest + V_T ln((I_ex + I_rslope)/I_rtau) + V_dd (kappa_p - 1)) / (kappa_n I_rtau)",
        "As (12), second line.",
        eq.excited_rise_time,
        "t_r = C_r (V_rest + U_T ln((I_ex + I_rslope)/I_0n) - kappa_n U_T ln(I_rtau/I_0p)"
        " + kappa_n V_dd (kappa_p - 1)) / (kappa_n I_rtau)",
    ),
    Equation(
        16,
        "peak with excitation",
        eq.excited_peak_as_printed,
        "V_m,peak = V_rest + (I_ex + I_rslope) t_r / C_m",
        "As (13).",
        eq.excited_peak,
        "V_m,peak = V_rest + t_r ((I_ex + I_rslope)/C_m - kappa_n I_rtau/C_r)",
    ),
    Equation(
        17,
        "excitatory current",
        eq.excitatory_current_as_printed,
        "I_ex(t) = I_0 e^(kappa_p(V_dd/V_T - (V_ex,max/V_T + (I_ex_tau/V_T C_ex) t))"
        " = I_max e^((-kappa_p I_ex_tau/C_ex) t)",
        "The second form lacks V_T, so that its exponent is a voltage; the first lacks a parenthesis.",
        eq.excitatory_current,
        "I_ex(t) = I_max e^(-kappa_p I_ex_tau t / (C_ex U_T)), until V_ex reaches V_dd",
    ),
    Equation(
        17,
        "largest excitatory current",
        eq.excitatory_peak_current,
        "I_max = I_0 e^(kappa_p (V_dd - V_ex,max)/V_T)",
        "Weak inversion only: 11 % above the EKV law at 1 nA in a device of 6 um by 3 um.",
        eq.excitatory_peak_current_ekv,
        "I_max = I_Sp F(kappa_p (V_dd - V_ex,max)/U_T + ln(I_0p/I_Sp))",
    ),
)
