"""Closed forms of the rebound neuron: equations (1) to (17) as printed, and corrected where needed.

The print writes V_T (in (8) and (9) also V_t) for the thermal voltage k T / q, which is U_T here, and one I_0
for both polarities; here I_0n is that of the nFET and I_0p that of the pFET. The bulk of an nFET is at ground
and that of a pFET at V_dd, as (5) and (8) require. `rebound_equation_table.EQUATIONS` lists the printed form
beside the corrected one, and says what differs.

Every function takes scalars in SI units and returns one: V for voltages, to ground unless said (`v_gb` is
from gate to bulk); A for `i_*`; s for `t_*` and durations; V/s for rates. Symbols are those of
`ReboundParameters`. The corrections are ours, and each derivation stands at its function.

Source: M. Cheely, T. Horiuchi, "Analog VLSI Models of Range-Tuned Neurons in the Bat Echolocation System",
EURASIP Journal on Applied Signal Processing 2003:7.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class ReboundParameters:
    """What the closed forms need: M1 is the nFET from v_mem to V_rest, M2 the pFET follower to v_r.

    The output pFET of the excitatory synapse is taken to be of M2's size.
    Raises `ParameterError` for a value that is not finite or breaks the rule of its field.
    """

    u_t: float  # U_T = k T / q, V
    kappa_n: float  # gate coupling of the nFET, 0 to 1
    kappa_p: float  # gate coupling of the pFET, 0 to 1
    i_0n: float  # I_0 of M1, A: I_S exp(-kappa_n V_T0 / U_T)
    i_0p: float  # I_0 of M2, A
    i_sn: float  # specific current I_S of M1, A; the EKV law only
    i_sp: float  # specific current I_S of M2, A; the EKV law only
    v_dd: float  # supply, V
    v_rest: float  # resting potential, V
    i_rslope: float  # current into v_mem, A
    i_rtau: float  # current into v_r, A
    i_inh_tau: float  # current out of v_inh, A
    i_ex_tau: float  # current into v_ex, A
    v_ex_max: float  # V_ex at an echo, V; 0 to v_dd
    c_m: float  # membrane capacitance, F
    c_r: float  # rebound capacitance, F
    c_ex: float  # excitation capacitance, F
    c_inh: float  # inhibition capacitance, F
    v_inh_high: float  # V_inhH, to which a call charges v_inh, V
    v_hl: float  # switching voltage of the inverter behind v_inh, V; below v_inh_high

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            allowed = value >= 0.0 if field.name in _MAY_BE_ZERO else value > 0.0
            rule = "must be finite and >= 0" if field.name in _MAY_BE_ZERO else "must be finite and > 0"
            _require(math.isfinite(value) and allowed, field.name, value, rule)
        _require(self.kappa_n <= 1.0, "kappa_n", self.kappa_n, "must be <= 1")
        _require(self.kappa_p <= 1.0, "kappa_p", self.kappa_p, "must be <= 1")
        _require(self.v_ex_max <= self.v_dd, "v_ex_max", self.v_ex_max, f"must be <= v_dd ({self.v_dd:g} V)")
        _require(
            self.v_hl < self.v_inh_high, "v_hl", self.v_hl, f"must be < v_inh_high ({self.v_inh_high:g} V)"
        )


def specific_current(mu_cox: float, kappa: float, u_t: float, width_over_length: float) -> float:
    """Specific current `I_S = 2 mu Cox U_T^2 / kappa * W / L`, A; mu Cox in A/V^2."""
    return 2.0 * mu_cox * u_t**2 / kappa * width_over_length


def weak_inversion_prefactor(i_s: float, kappa: float, v_t0: float, u_t: float) -> float:
    """Prefactor of (1), A, for which the EKV law becomes (1): `I_0 = I_S exp(-kappa V_T0 / U_T)`."""
    return i_s * math.exp(-kappa * v_t0 / u_t)


def nfet_current(p: ReboundParameters, v_gb: float, v_sb: float, v_db: float) -> float:
    """(1), nFET, drain to source, A: `I_dn = I_0n e^(kappa_n V_GB/U_T) (e^(-V_SB/U_T) - e^(-V_DB/U_T))`.

    Printed as it is; it holds in weak inversion only, and from ground to a gate far above V_T0 it gives 1e6
    A.
    """
    return p.i_0n * _weak_inversion(p.u_t, p.kappa_n, v_gb, v_sb, v_db)


def pfet_current(p: ReboundParameters, v_bg: float, v_bs: float, v_bd: float) -> float:
    """(1), pFET, source to drain, A: `I_dp = I_0p e^(kappa_p V_BG/U_T) (e^(-V_BS/U_T) - e^(-V_BD/U_T))`."""
    return p.i_0p * _weak_inversion(p.u_t, p.kappa_p, v_bg, v_bs, v_bd)


def nfet_current_ekv(p: ReboundParameters, v_gb: float, v_sb: float, v_db: float) -> float:
    """(1) from weak to strong inversion, A: `I_dn = I_Sn [F(u_f) - F(u_r)]`, `F(u) = ln^2(1 + e^(u/2))`.

    `u_f = (kappa_n V_GB - V_SB) / U_T + ln(I_0n/I_Sn)`, u_r the same with V_DB: as
    `I_0n/I_Sn = exp(-kappa_n V_T0/U_T)`, that is `(v_p - v_s)/U_T` with `v_p = kappa_n (v_g - V_T0)`.
    """
    return _ekv(p.u_t, p.kappa_n, p.i_0n, p.i_sn, (v_gb, v_sb, v_db))


def pfet_current_ekv(p: ReboundParameters, v_bg: float, v_bs: float, v_bd: float) -> float:
    """(1) from weak to strong inversion for the pFET, source to drain, A, as `nfet_current_ekv`."""
    return _ekv(p.u_t, p.kappa_p, p.i_0p, p.i_sp, (v_bg, v_bs, v_bd))


def nfet_saturation_current(p: ReboundParameters, v_gb: float, v_sb: float) -> float:
    """(2), nFET, A: `I_dn = I_0n e^((kappa_n V_GB - V_SB)/U_T)`, the limit of (1) for a high drain."""
    return p.i_0n * math.exp((p.kappa_n * v_gb - v_sb) / p.u_t)


def pfet_saturation_current(p: ReboundParameters, v_bg: float, v_bs: float) -> float:
    """(2), pFET, A: `I_dp = I_0p e^((kappa_p V_BG - V_BS)/U_T)`, the limit of (1) for a low drain."""
    return p.i_0p * math.exp((p.kappa_p * v_bg - v_bs) / p.u_t)


def inhibition_duration_as_printed(p: ReboundParameters) -> float:
    """(3), s: `t_inh = C_inh (V_inhH - V_hl) / I_inh_tau`, from the drawn capacitor alone."""
    return inhibition_duration(p, p.c_inh)


def inhibition_duration(p: ReboundParameters, c_effective: float) -> float:
    """(3) corrected, s: `t_inh = C_eff (V_inhH - V_hl) / I_inh_tau`, `c_effective` in F.

    C_eff is all that I_inh_tau discharges: C_inh, gates and junctions at v_inh, and the node of the charging
    diode, which discharges into v_inh. Raises `ParameterError` unless it is finite and > 0.
    """
    _require(
        math.isfinite(c_effective) and c_effective > 0.0, "c_effective", c_effective, "must be finite and > 0"
    )
    return c_effective * (p.v_inh_high - p.v_hl) / p.i_inh_tau


def rebound_slow_equilibrium(p: ReboundParameters) -> float:
    """(4), V: `V_r,eq = (V_rest + U_T ln(I_rslope/I_0n)) / kappa_n`, where M1, saturated, carries I_rslope.

    Printed right. It is v_r at the peak of the rebound; it is v_r at rest only where (6) exceeds V_rest by
    several U_T.
    """
    return _slow_balance(p, p.i_rslope)


def membrane_equilibrium_from_slow(p: ReboundParameters, v_r: float) -> float:
    """(5), V: `V_mem = (V_r - U_T ln(I_rtau/I_0p)) / kappa_p + V_dd (1 - 1/kappa_p)`: M2 carries I_rtau.

    Printed right for a bulk at V_dd, from `kappa_p (V_dd - V_mem) - (V_dd - V_r) = U_T ln(I_rtau/I_0p)`.
    """
    return (v_r - p.u_t * math.log(p.i_rtau / p.i_0p)) / p.kappa_p + p.v_dd * (1.0 - 1.0 / p.kappa_p)


def membrane_equilibrium_as_printed(p: ReboundParameters) -> float:
    """(6), V: (4) in (5), each I_0 read as that of its own transistor.

    `V_mem,eq = [V_rest + U_T ln(I_rslope/I_0n)] / (kappa_n kappa_p) - U_T ln(I_rtau/I_0p) / kappa_p
    + V_dd (1 - 1/kappa_p)`. The algebra is right; M1 saturated is assumed, so a value below V_rest is not
    the rest.
    """
    product = p.kappa_n * p.kappa_p
    return (
        p.v_rest / product
        + p.u_t * math.log(p.i_rslope / p.i_0n) / product
        - p.u_t * math.log(p.i_rtau / p.i_0p) / p.kappa_p
        + p.v_dd * (1.0 - 1.0 / p.kappa_p)
    )


def membrane_rest(p: ReboundParameters) -> float:
    """(6) corrected, V: the rest of v_mem with M1 by (1) instead of (2).

    With x = (V_mem - V_rest)/U_T, d = (V_sat - V_rest)/U_T, V_sat from (6) and c = kappa_n kappa_p, M2 (5)
    moves M1's gate by kappa_p (V_mem - V_sat), hence `c (x - d) + ln(1 - e^(-x)) = 0`: x tends to d for d >>
    1 and to e^(c d) for d << -1, where v_mem sits slightly above V_rest.
    """
    c = p.kappa_n * p.kappa_p
    d = (membrane_equilibrium_as_printed(p) - p.v_rest) / p.u_t
    # The left side rises and is concave, and it is <= 0 at this start because ln(1 - e^-x) < min(0, ln x):
    # Newton's steps approach the root from the left and cannot pass it.
    x = max(d, math.exp(min(0.0, c * d) - c))
    for _ in range(_NEWTON_STEPS):
        step = (c * (x - d) + math.log(-math.expm1(-x))) / (c + math.exp(-x) / -math.expm1(-x))
        x -= step
        if abs(step) <= _NEWTON_TOLERANCE * x:
            break
    return p.v_rest + p.u_t * x


def ideal_membrane_equilibrium_as_printed(p: ReboundParameters) -> float:
    """(7), V: `V_mem,eq = V_rest + U_T ln(I_rslope/I_rtau)`, (6) for kappa = 1 and I_0n = I_0p."""
    return p.v_rest + p.u_t * math.log(p.i_rslope / p.i_rtau)


def ideal_membrane_equilibrium(p: ReboundParameters) -> float:
    """(7) corrected, V: `V_mem,eq = V_rest + U_T ln(I_rslope I_0p / (I_rtau I_0n))`, (6) for kappa = 1."""
    return p.v_rest + p.u_t * math.log(p.i_rslope * p.i_0p / (p.i_rtau * p.i_0n))


def rebound_slow_minimum(p: ReboundParameters) -> float:
    """(8), V: `V_r,min = U_T ln(I_rtau/I_0p) + V_dd (1 - kappa_p)`: M2, its gate at 0, carries I_rtau.

    Printed right, with V_t for V_T. Fragile: `dV_r,min/dkappa_p = -V_dd`, a constant kappa extrapolated over
    V_dd.
    """
    return p.u_t * math.log(p.i_rtau / p.i_0p) + p.v_dd * (1.0 - p.kappa_p)


def membrane_release_rate_as_printed(p: ReboundParameters, v_r: float, v_mem: float) -> float:
    """(9), V/s: `[I_rslope + I_0n e^(kappa_n V_r/U_T) (e^(-V_mem/U_T) - e^(-V_rest/U_T))] / C_m`."""
    return (p.i_rslope + nfet_current(p, v_r, v_mem, p.v_rest)) / p.c_m


def membrane_release_rate(p: ReboundParameters, v_r: float, v_mem: float) -> float:
    """(9) corrected, V/s: `(I_rslope + I_Sn [F(u_f) - F(u_r)]) / C_m`, M1's source at v_mem.

    Its drain is at V_rest. At the release v_mem is 0 and v_r far above V_T0, where M1 is in strong inversion.
    """
    return (p.i_rslope + nfet_current_ekv(p, v_r, v_mem, p.v_rest)) / p.c_m


def rebound_slow_rate(p: ReboundParameters) -> float:
    """(10), V/s: `dV_r/dt = I_rtau / C_r` while M2 carries nothing."""
    return p.i_rtau / p.c_r


def rebound_rise_rate(p: ReboundParameters) -> float:
    """(11), V/s: `dV_mem/dt = I_rslope / C_m` while M1 carries nothing."""
    return p.i_rslope / p.c_m


def rebound_duration(p: ReboundParameters) -> float:
    """(12), first line, s: `t_reb = C_r (V_r,eq - V_r,min) / I_rtau`; <= 0 where there is no rebound."""
    return p.c_r * (rebound_slow_equilibrium(p) - rebound_slow_minimum(p)) / p.i_rtau


def rebound_duration_expanded(p: ReboundParameters) -> float:
    """(12), second line corrected, s; (4) and (8) in the first line.

    `t_reb = C_r [V_rest + U_T ln(I_rslope/I_0n) - kappa_n U_T ln(I_rtau/I_0p) + kappa_n V_dd (kappa_p - 1)]
    / (kappa_n I_rtau)`. The two I_0 do not cancel, even where they are equal, unless kappa_n = 1.
    """
    return _expanded_duration(p, p.i_rslope)


def rebound_duration_as_printed(p: ReboundParameters) -> float:
    """(12), second line as printed, s; two terms lack kappa_n.

    `t_reb = C_r [V_rest + U_T ln(I_rslope/I_rtau) + V_dd (kappa_p - 1)] / (kappa_n I_rtau)`.
    """
    return _printed_duration(p, p.i_rslope)


def rebound_peak_as_printed(p: ReboundParameters, t_reb: float) -> float:
    """(13), V: `V_m,peak = V_rest + I_rslope t_reb / C_m`, from "rises to V_rest nearly instantaneously"."""
    return p.v_rest + p.i_rslope * t_reb / p.c_m


def rebound_peak(p: ReboundParameters, t_reb: float) -> float:
    """(13) corrected, V: `V_m,peak = V_rest + t_reb (I_rslope/C_m - kappa_n I_rtau/C_r)`.

    At the release M1 is a follower: v_mem jumps only to where M1 with its gate at V_r,min carries I_rslope,
    `kappa_n V_r,min - U_T ln(I_rslope/I_0n)`, by (4) `V_rest - kappa_n (V_r,eq - V_r,min)`, and by (12)
    `V_rest - kappa_n I_rtau t_reb / C_r`. From there it rises by (11) for t_reb.
    """
    return p.v_rest + t_reb * _lead(p, p.i_rslope)


def rebound_peak_rounded(p: ReboundParameters, t_reb: float) -> float:
    """(13) corrected, V, with M1 turning off and on over several U_T: `V_m,peak - U_T [r + ln(1 - 1/r)]`.

    r = (I_rslope/C_m) / (kappa_n I_rtau/C_r). M1's current decays as v_mem leaves the follower's level,
    which adds -U_T ln(1 - 1/r), and grows as e^((t - t_reb)/tau), tau = U_T C_r / (kappa_n I_rtau), towards
    the peak, which takes I_rslope tau / C_m = r U_T. Raises `ParameterError` where the rebound does not
    overshoot, r <= 1.
    """
    return rebound_peak(p, t_reb) - _rounding(p, p.i_rslope)


def excited_rise_rate(p: ReboundParameters, i_ex: float) -> float:
    """(14), V/s: `dV_mem/dt = (I_ex + I_rslope) / C_m` while M1 carries nothing."""
    return (i_ex + p.i_rslope) / p.c_m


def excited_rise_time_as_printed(p: ReboundParameters, i_ex: float) -> float:
    """(15), s, for a constant I_ex; two terms lack kappa_n, as in (12).

    `t_r = C_r [V_rest + U_T ln((I_ex + I_rslope)/I_rtau) + V_dd (kappa_p - 1)] / (kappa_n I_rtau)`.
    """
    return _printed_duration(p, i_ex + p.i_rslope)


def excited_rise_time(p: ReboundParameters, i_ex: float) -> float:
    """(15) corrected, s: (12) with I_ex + I_rslope for I_rslope.

    `t_r = C_r [V_rest + U_T ln((I_ex + I_rslope)/I_0n) - kappa_n U_T ln(I_rtau/I_0p) + kappa_n V_dd (kappa_p
    - 1)] / (kappa_n I_rtau)`.
    """
    return _expanded_duration(p, i_ex + p.i_rslope)


def excited_peak_as_printed(p: ReboundParameters, i_ex: float, t_r: float) -> float:
    """(16), V: `V_m,peak = V_rest + (I_ex + I_rslope) t_r / C_m`."""
    return p.v_rest + (i_ex + p.i_rslope) * t_r / p.c_m


def excited_peak(p: ReboundParameters, i_ex: float, t_r: float) -> float:
    """(16) corrected, V: `V_m,peak = V_rest + t_r ((I_ex + I_rslope)/C_m - kappa_n I_rtau/C_r)`, as (13).

    For an I_ex that is constant from the release on.
    """
    return p.v_rest + t_r * _lead(p, i_ex + p.i_rslope)


def excited_peak_rounded(p: ReboundParameters, i_ex: float, t_r: float) -> float:
    """(16) corrected, V, rounded as `rebound_peak_rounded` with I_ex + I_rslope for I_rslope."""
    return excited_peak(p, i_ex, t_r) - _rounding(p, i_ex + p.i_rslope)


def excitatory_current_as_printed(p: ReboundParameters, t: float) -> float:
    """(17), second form as printed, A: `I_max e^((-kappa_p I_ex_tau/C_ex) t)`; the exponent is a voltage."""
    return excitatory_peak_current(p) * math.exp(-p.kappa_p * p.i_ex_tau / p.c_ex * t)


def excitatory_current(p: ReboundParameters, t: float) -> float:
    """(17) corrected, A, t after the echo's pulse: `I_max e^(-t/tau)`, `tau = C_ex U_T / (kappa_p I_ex_tau)`.

    It is the first form with its missing parenthesis: `I_0p e^(kappa_p (V_dd - (V_ex,max + I_ex_tau
    t/C_ex))/U_T)`. V_ex stops at V_dd, so that from t = C_ex (V_dd - V_ex,max) / I_ex_tau on the current
    stays at I_0p.
    """
    v_ex = min(p.v_ex_max + p.i_ex_tau * t / p.c_ex, p.v_dd)
    return pfet_saturation_current(p, p.v_dd - v_ex, 0.0)


def excitatory_time_constant(p: ReboundParameters) -> float:
    """Time constant of (17) corrected, s: `tau = C_ex U_T / (kappa_p I_ex_tau)`."""
    return p.c_ex * p.u_t / (p.kappa_p * p.i_ex_tau)


def excitatory_peak_current(p: ReboundParameters) -> float:
    """(17), A: `I_max = I_0p e^(kappa_p (V_dd - V_ex,max)/U_T)`."""
    return pfet_saturation_current(p, p.v_dd - p.v_ex_max, 0.0)


def excitatory_peak_current_ekv(p: ReboundParameters) -> float:
    """I_max of (17), A, by the EKV law: `I_max = I_Sp F(kappa_p (V_dd - V_ex,max)/U_T + ln(I_0p/I_Sp))`."""
    return p.i_sp * _ekv_interpolation(p.kappa_p * (p.v_dd - p.v_ex_max) / p.u_t + math.log(p.i_0p / p.i_sp))


_MAY_BE_ZERO = frozenset({"v_rest", "v_ex_max", "v_hl"})
_UNITS = {"u": "V", "v": "V", "i": "A", "c": "F"}
_NEWTON_STEPS = 100  # a bound; it takes fewer than ten
_NEWTON_TOLERANCE = 1e-14


def _require(holds: bool, name: str, value: float, rule: str) -> None:  # noqa: FBT001 - the rule's outcome
    if not holds:
        unit = _UNITS.get(name.split("_", maxsplit=1)[0], "")
        raise ParameterError(f"rebound.{name}: {value:g}{' ' * bool(unit)}{unit}, {rule}")


def _weak_inversion(u_t: float, kappa: float, v_g: float, v_s: float, v_d: float) -> float:
    return math.exp((kappa * v_g - v_s) / u_t) - math.exp((kappa * v_g - v_d) / u_t)


def _ekv(u_t: float, kappa: float, i_0: float, i_s: float, v: tuple[float, float, float]) -> float:
    v_g, v_s, v_d = v
    pinch_off = kappa * v_g / u_t + math.log(i_0 / i_s)
    return i_s * (_ekv_interpolation(pinch_off - v_s / u_t) - _ekv_interpolation(pinch_off - v_d / u_t))


def _ekv_interpolation(u: float) -> float:
    half = 0.5 * u
    return (max(half, 0.0) + math.log1p(math.exp(-abs(half)))) ** 2  # no overflow at large u


def _slow_balance(p: ReboundParameters, current: float) -> float:
    return (p.v_rest + p.u_t * math.log(current / p.i_0n)) / p.kappa_n


def _expanded_duration(p: ReboundParameters, current: float) -> float:
    bracket = (
        p.v_rest
        + p.u_t * math.log(current / p.i_0n)
        - p.kappa_n * p.u_t * math.log(p.i_rtau / p.i_0p)
        + p.kappa_n * p.v_dd * (p.kappa_p - 1.0)
    )
    return p.c_r * bracket / (p.kappa_n * p.i_rtau)


def _printed_duration(p: ReboundParameters, current: float) -> float:
    bracket = p.v_rest + p.u_t * math.log(current / p.i_rtau) + p.v_dd * (p.kappa_p - 1.0)
    return p.c_r * bracket / (p.kappa_n * p.i_rtau)


def _lead(p: ReboundParameters, current: float) -> float:
    """Rate at which v_mem, charged by `current`, gains on the follower's level, V/s."""
    return current / p.c_m - p.kappa_n * p.i_rtau / p.c_r


def _rounding(p: ReboundParameters, current: float) -> float:
    ratio = current * p.c_r / (p.c_m * p.kappa_n * p.i_rtau)
    least = p.kappa_n * p.i_rtau * p.c_m / p.c_r
    rule = f"must with I_ex exceed kappa_n I_rtau C_m / C_r = {least:g} A; raise i_rslope or lower i_rtau"
    _require(ratio > 1.0, "i_rslope", p.i_rslope, rule)
    return p.u_t * (ratio + math.log1p(-1.0 / ratio))
