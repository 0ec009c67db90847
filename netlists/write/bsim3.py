"""BSIM3 3.3 cards made from a process's figures, and the layout rule of M elements.

BSIM3 has what our law has, under other names; what our law lacks is switched off. With n = 1 / kappa and all
figures at the netlist's temperature T (`tnom` is T, so that nothing is scaled twice):

    parameter         from                                             rule
    vth0              V_T0(T)                                          signed: a pFET's is negative
    tox               oxide_capacitance                                eps_ox / C_ox
    u0                mu_Cox(T)                                        mu_Cox / C_ox, with ua = ub = uc = 0
    nch, k1, k2, a0,  kappa                                            see below
    nfactor, cit
    voff              kappa                                            -n U_T ln(2 n^2 / (n - 1))
    vsat, a2, pclm    early_field                                      see below
    ua, mobmod = 2    mobility_reduction                               theta kappa tox
    cgdo, cgso        overlap_capacitance                              as they are; cgbo = cf = 0
    cj, js            junction_capacitance, junction_leakage(T)        divided by the diffusion's length
    kt1, ute          v_t0_drift, mobility_exponent                    dV_T/dT T, m: for a run at another T

Kappa. The doping N gives the slope factor: `n = 1 + C_d / C_ox`, `C_d = sqrt(q eps_si N / 2 phi)`,
`phi = 2 U_T ln(N / n_i)`, solved by Newton's method. For `ekv-gamma` that is all: `nfactor = a0 = 1`,
`k2 = 0`, `k1 = sqrt(2 q eps_si N) / C_ox`, and n follows the source-bulk voltage. The `ekv` law has one kappa
and a threshold that rises by n - 1 with it: `nfactor = 0`, `cit = (n - 1) C_ox`, a hundredth of k1,
`k2 = 0.99 (n - 1)`, and `a0 = 100`, so that the bulk-charge factor A_bulk is n at the source as before.

Current. `voff` makes the weak-inversion current in saturation ours, with `x = (v_gs - V_th) / n U_T`:
BSIM3's is `mu W/L U_T^2 C_d / A_bulk e^(x - V_off / n U_T)`, ours `2 n mu C_ox U_T^2 W/L e^x`.

Early effect. BSIM3's Early voltage is `V_Asat + 1 / (1 / V_ACLM + 1 / V_ADIBL)`, where `V_Asat = (E_sat L +
V_dsat) / (2 / a2 - 1)` and `E_sat = 2 vsat / mu`. With a large pclm the second term vanishes, and a small a2
lets E_sat be so large that the velocity does not saturate: `vsat = mu V_E (2 / a2 - 1) / 2` gives V_E L. It
rises with inversion only as the mobility falls.

What differs all the same: moderate inversion, where the two interpolate differently; A_bulk falls with the
source-bulk voltage; the channel's charges are BSIM3's own in the place of our constant gate-bulk capacitance;
the drain saturates by BSIM3's smoothing; BSIM3 has no leakage that a gate induces, so that it is left out.
Deviations are exact: `delvto` adds to the signed threshold, `mulu0` multiplies the mobility.

Measured in ngspice 39, both polarities, 6 um by 6 um, drain at 5 V, -20 to 85 degC, 1e-13 A to strong
inversion, BSIM3's current by ours: with the source at the bulk 0.89 to 1.17, slope in weak inversion 0.98 to
0.99 of ours, 0.94 at threshold; at V_SB = 1.8 V 1.06 to 1.39. Under `ekv-gamma` 0.54 to 1.15, at 1.8 V 0.67
to 2.36, since that law's kappa follows the gate too. The nominal rebound neuron's inhibition lasts 2.9 %
longer, its spike comes 3.8 % later.

Layout rule (ours): drain and source are one rectangle each, as wide as the gate and 2.5 features of 1.5 um
long (a contact with its margins), so `ad = as = W d`, `pd = ps = 2 (W + d)` of one of the M parallel devices.
Sources: BSIM3v3.3 Manual, UC Berkeley (2005), chapters 2 and 3 and appendix B; constants of its appendix.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.silicon.process import (
    BOLTZMANN,
    ELEMENTARY_CHARGE,
    POLARITIES,
    Law,
    Polarity,
    TransistorAtTemperature,
    at_temperature,
    kelvin,
)
from circuits.silicon.silicon import NO_DEVIATION, Deviation, Silicon
from netlists.naming import Naming
from netlists.write.traversal import Design

_DIFFUSION = 3.75e-6  # m, length of drain and source

_EPS_OX, _EPS_SI = 3.453133e-11, 1.03594e-10  # F/m, the model's own
_OFF = 1e-12
_SHARE = 0.01  # of k1, where the body effect is linear
_STEPS = 50
_SATURATION = 0.02  # a2; 0.01 is the least that the model takes
_NO_CLM = 1e6  # of pclm, at which its own Early voltage is negligible


def card(silicon: Silicon, polarity: Polarity, deviation: Deviation | None = None) -> dict[str, float]:
    """Parameters of a BSIM3 card at the silicon's temperature, in the model's units (nch in cm^-3).

    The nominal die's, or, for a simulator without `delvto` and `mulu0`, with what is theirs folded in.
    """
    model, t = silicon.process.model(polarity), kelvin(silicon.temperature_c)
    refuse_sizes(silicon, "BSIM3 cards")
    law = at_temperature(model, silicon.process, silicon.temperature_c)
    u_t, sign = law.u_t, 1.0 if polarity == "n" else -1.0
    n, c_ox = 1.0 / law.kappa, model.oxide_capacitance
    mobility = law.square_current * law.kappa / (2.0 * u_t**2 * c_ox)
    shift, factor = (
        (0.0, 1.0) if deviation is None else (sign * float(deviation.v_t0), 1.0 + float(deviation.beta))
    )
    return {
        "vth0": sign * law.v_t0 + shift,
        "tox": _EPS_OX / c_ox,
        "u0": 1e4 * mobility * factor,
        "ua": law.mobility_reduction * law.kappa * _EPS_OX / c_ox,
        **({"mobmod": 2.0} if law.mobility_reduction > 0.0 else {}),
        "ub": 0.0,
        "uc": 0.0,
        **_slope_factor(model.law, n, c_ox, t),
        "voff": -n * u_t * math.log(2.0 * n**2 / (n - 1.0)),
        "cgdo": model.overlap_capacitance,
        "cgso": model.overlap_capacitance,
        "cj": model.junction_capacitance / _DIFFUSION,
        "js": law.junction_leakage / _DIFFUSION,
        "kt1": model.v_t0_drift * t,
        "ute": model.mobility_exponent,
        "tnom": silicon.temperature_c,
        **_SWITCHED_OFF,
        **_early_effect(law, mobility * factor),
    }


def refuse_sizes(silicon: Silicon, form: str) -> None:
    """Raise `ParameterError` where numbers of transistors follow their size, which `form` cannot say."""
    if any(silicon.process.model(polarity).size is not None for polarity in POLARITIES):
        raise ParameterError(
            f"process: {silicon.process.name}, whose transistors follow their size, as {form} do not; write"
            " ngspice, xyce, hspice or spectre with the models ekv"
        )


def total_deviation(silicon: Silicon, polarity: Polarity, local: Deviation) -> Deviation:
    """What the die shares and what a place adds, together: V_T0 (V, of the magnitude) and relative beta."""
    shared = _shared_deviation(silicon, polarity)
    factor = (1.0 + shared.beta) * (1.0 + local.beta)
    return Deviation(float(shared.v_t0 + local.v_t0), float(factor - 1.0))


@functools.lru_cache(8)
def _shared_deviation(silicon: Silicon, polarity: Polarity) -> Deviation:
    nominal = at_temperature(silicon.process.model(polarity), silicon.process, silicon.temperature_c)
    shared = silicon.law(polarity)
    beta = float(shared.square_current / nominal.square_current) - 1.0
    return Deviation(float(shared.v_t0 - nominal.v_t0), beta)


def size(device: Transistor) -> dict[str, float]:
    """Parameters of an M element: size, parallel devices, areas and perimeters by the layout rule."""
    width = float(device.width)
    area, perimeter = width * _DIFFUSION, 2.0 * (width + _DIFFUSION)
    return {
        "w": width,
        "l": float(device.length),
        "m": float(device.multiplicity),
        "ad": area,
        "as": area,
        "pd": perimeter,
        "ps": perimeter,
    }


def deviating(polarity: Polarity, deviation: Deviation) -> dict[str, float]:
    """Instance parameters of a deviation, none where there is none."""
    if not deviation.v_t0 and not deviation.beta:
        return {}
    sign = 1.0 if polarity == "n" else -1.0
    return {"delvto": sign * float(deviation.v_t0), "mulu0": 1.0 + float(deviation.beta)}


@dataclass(frozen=True, slots=True)
class Form:
    """How a dialect writes BSIM3.

    naming: how names of nodes and devices are written. card: gives the lines of a model card from its name,
    its polarity and its parameters. element: gives the lines of a transistor from its name, its nodes, the
    card that it names and its parameters. instance: whether a transistor takes the deviations `delvto` and
    `mulu0` itself; where it does not, one that deviates has a card of its own before it.
    """

    naming: Naming
    card: Callable[[str, Polarity, Sequence[str]], list[str]]
    element: Callable[[str, Sequence[str], str, Sequence[str]], list[str]]
    instance: bool


def make_transistors(form: Form) -> Callable[[Transistor, Silicon, Deviation], list[str]]:
    """Make the formatter of transistors."""

    def transistor(device: Transistor, silicon: Silicon, local: Deviation = NO_DEVIATION) -> list[str]:
        polarity, name = device.polarity, form.naming.plain(device.name)
        deviation = total_deviation(silicon, polarity, local)
        changes, model, own = deviating(polarity, deviation), _model_name(polarity), []
        if changes and not form.instance:
            changes, model = {}, f"bsim3_{name}"
            own = form.card(model, polarity, _words(card(silicon, polarity, deviation)))
        nodes = [form.naming.node(t) for t in device.terminals()]
        return [*own, *form.element(f"m{name}", nodes, model, _words(size(device) | changes))]

    return transistor


def make_cards(form: Form) -> Callable[[Silicon, Design], list[str]]:
    """Make the writer of the cards of the polarities that a design has."""

    def cards(silicon: Silicon, design: Design) -> list[str]:
        devices = (device for definition in design.definitions for device, _ in definition.devices)
        used = {device.polarity for device in devices if isinstance(device, Transistor)}
        parameters = {p: _words(card(silicon, p)) for p in POLARITIES if p in used}
        return [line for p, words in parameters.items() for line in form.card(_model_name(p), p, words)]

    return cards


def _model_name(polarity: Polarity) -> str:
    """Name of a polarity's card."""
    return f"bsim3_{polarity}"


def _words(parameters: Mapping[str, float]) -> list[str]:
    return [f"{name}={float(value)!r}" for name, value in parameters.items()]


# Short and narrow channels, velocity saturation, series resistance, DIBL, impact and gate depletion; the
# model refuses a zero where a tiny number stands. vbm: the body effect is not cut at 3 V.
_SWITCHED_OFF = {
    "ags": 0.0, "b0": 0.0, "keta": 0.0, "vsat": 1e9, "rdsw": 0.0, "delta": 1e-3, "xj": 1e-9,
    "dvt0": 0.0, "dvt0w": 0.0, "k3": 0.0, "k3b": 0.0, "nlx": 0.0, "eta0": 0.0, "etab": 0.0, "cdsc": 0.0,
    "cdscb": 0.0, "cdscd": 0.0, "pclm": 1e-6, "pdiblc1": 0.0, "pscbe1": 1e9, "pscbe2": _OFF,
    "alpha0": 0.0, "ngate": 0.0, "lint": 0.0, "wint": 0.0, "kt1l": 0.0, "kt2": 0.0, "ua1": 0.0, "ub1": 0.0,
    "uc1": 0.0, "vbm": -40.0, "capmod": 2.0, "xpart": 0.5, "cgbo": 0.0, "cf": 0.0, "cgsl": 0.0, "cgdl": 0.0,
    "mj": 0.0, "cjsw": 0.0, "mjsw": 0.0, "cjswg": 0.0, "mjswg": 0.0,
}  # fmt: skip


def _early_effect(law: TransistorAtTemperature, mobility: float) -> dict[str, float]:
    """Parameters of the Early effect; mobility: m^2/V/s."""
    if law.early_field == 0.0:
        return {}
    steep = (2.0 / _SATURATION - 1.0) * law.early_field  # E_sat, V/m
    return {"vsat": 0.5 * mobility * steep, "a2": _SATURATION, "pclm": _NO_CLM}


def _slope_factor(law: Law, n: float, c_ox: float, temperature: float) -> dict[str, float]:
    """Parameters of doping, body effect and subthreshold slope."""
    doping = _doping(n, c_ox, temperature)
    k1 = math.sqrt(2.0 * ELEMENTARY_CHARGE * _EPS_SI * doping) / c_ox
    if law == "ekv-gamma":
        return {"nch": 1e-6 * doping, "k1": k1, "k2": 0.0, "a0": 1.0, "nfactor": 1.0, "cit": 0.0}
    # the share of n - 1 that k1 still has, n - 1 being k1 / (2 sqrt(phi))
    rest = (1.0 - _SHARE) * (n - 1.0)
    return {
        "nch": 1e-6 * doping,
        "k1": _SHARE * k1,
        "k2": rest,
        "a0": 1.0 / _SHARE,
        "nfactor": 0.0,
        "cit": (n - 1.0) * c_ox,
    }


def _doping(n: float, c_ox: float, temperature: float) -> float:
    """Channel doping, m^-3, at which the depletion charge gives the slope factor n."""
    u_t = BOLTZMANN * temperature / ELEMENTARY_CHARGE
    intrinsic = _intrinsic(temperature, u_t)
    wanted = ((n - 1.0) * c_ox) ** 2 * 2.0 / (ELEMENTARY_CHARGE * _EPS_SI)  # N / phi
    log_doping = math.log(1e22)
    for _ in range(_STEPS):
        phi = 2.0 * u_t * (log_doping - math.log(intrinsic))
        error = log_doping - math.log(wanted * phi)
        log_doping -= error / (1.0 - 2.0 * u_t / phi)
        if abs(error) < 1e-14:
            break
    return math.exp(log_doping)


def _intrinsic(temperature: float, u_t: float) -> float:
    """Intrinsic carriers as BSIM3 has them, m^-3."""
    gap = 1.16 - 7.02e-4 * temperature**2 / (temperature + 1108.0)
    return 1.45e16 * math.pow(temperature / 300.15, 1.5) * math.exp(21.5565981 - gap / (2.0 * u_t))
