"""Junction diode with SPICE's law: current, breakdown, and the charges of its depletion layer and of transit.

With `v = v_anode - v_cathode`, `U = N U_T` and the saturation current I_S of its area at the temperature,

    i = I_S (e^(v/U) - 1)               above -3 U
    i = -I_S (1 + (3 U / (v e))^3)      below, down to breakdown
    i = -I_S e^(-(v + B)/U_B)           beyond, U_B = N_B U_T

where B makes the current at -BV that of breakdown, IBV, by `IBV / I_S = e^((BV - B)/U_B) - 1 + B/U_T`. Above
1 kA the exponentials go on as their tangents (ours), so that a solver may pass there. The charge is

    q = TT i + C_J V_J (1 - (1 - v/V_J)^(1-M)) / (1 - M)

and beyond FC V_J, where the depletion layer's capacitance would grow without limit, that capacitance goes on
as its tangent. With the temperature T, from the nominal one T_0,

    I_S(T) = I_S (T/T_0)^(XTI/N) e^((T/T_0 - 1) EG / U)

and V_J and C_J follow the band gap of silicon as in SPICE. There is no `gmin` beside the junction.

Source: level 1 of ngspice's diode (its manual, chapter on diodes), itself that of SPICE2 (Nagel 1975).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I32, I64, Bools
from circuits.brief import OPTIONAL, brief
from circuits.checks import require_real
from circuits.compiled import compiled
from circuits.devices.device import Device
from circuits.errors import ParameterError
from circuits.silicon.process import BOLTZMANN, ELEMENTARY_CHARGE, ZERO_CELSIUS, kelvin, thermal_voltage

BREAKDOWN_CURRENT = 1e-3  # A, SPICE's default of IBV
FAR_CURRENT = 1e3  # A, ours: beyond it an exponential goes on as its tangent
_REFERENCE = 300.15  # K, of SPICE's law of the band gap
ROUNDS = 50  # of the fixed point for breakdown, which gains a digit or more in each
_THIRD = 3.0 / math.e  # of U, over v, whose cube a reverse current has more than I_S
# field: its unit, its least value, whether that value itself is allowed, and what it must be below
_RULES: dict[str, tuple[str, float, bool, float]] = {
    "area": ("", 0.0, False, math.inf),
    "saturation_current": ("A", 0.0, False, math.inf),
    "emission": ("", 0.0, False, math.inf),
    "junction_capacitance": ("F", 0.0, True, 1e-3),
    "junction_potential": ("V", 0.0, False, 10.0),
    "grading": ("", 0.0, True, 0.9),
    "forward_coefficient": ("", 0.0, True, 0.95),
    "transit_time": ("s", 0.0, True, 1.0),
    "breakdown_voltage": ("V", 0.0, True, math.inf),
    "breakdown_current": ("A", 0.0, False, math.inf),
    "breakdown_emission": ("", 0.0, False, math.inf),
    "energy_gap": ("eV", 0.1, True, 10.0),
    "current_exponent": ("", -math.inf, True, math.inf),
    "nominal_temperature_c": ("degC", -273.15, False, math.inf),
}


@dataclass(frozen=True, slots=True, repr=False)
class Diode(Device):
    """A junction diode between `anode` and `cathode`, in the words of SPICE's `.model D`.

    On a die its I_S deviates where the process says how far (`circuits.silicon.process.DiodeVariation`); else
    it is the same on every die. A resistance in series (RS) is a `Resistor` of its own.

    Attributes
    ----------
    anode, cathode : str
        The nodes.
    area : float
        How many times the model's junction it is, dimensionless: it multiplies I_S and C_J, but not IBV.
    saturation_current : float
        I_S at the nominal temperature, A.
    emission : float
        Emission coefficient N, dimensionless.
    junction_capacitance : float
        C_J at 0 V (CJO), F; 0 for none.
    junction_potential : float
        V_J, V.
    grading : float
        Grading coefficient M, dimensionless, below 0.9.
    forward_coefficient : float
        FC: the share of V_J beyond which the depletion layer's capacitance is a straight line, below 0.95.
    transit_time : float
        TT, s.
    breakdown_voltage, breakdown_current : float
        BV, V, 0 for a diode that does not break down, and the current IBV that it carries there, A.
    breakdown_emission : float
        Emission coefficient NBV of breakdown, dimensionless.
    energy_gap : float
        EG, eV.
    current_exponent : float
        XTI, exponent of the temperature in I_S, dimensionless.
    nominal_temperature_c : float
        TNOM, to which the figures belong, degC.

    Raises
    ------
    ParameterError
        A value is outside of what its law allows, or FC V_J is above 1 V.
    """

    name: str
    anode: str
    cathode: str
    area: float = 1.0
    saturation_current: float = field(default=1e-14, metadata=OPTIONAL)
    emission: float = field(default=1.0, metadata=OPTIONAL)
    junction_capacitance: float = field(default=0.0, metadata=OPTIONAL)
    junction_potential: float = field(default=1.0, metadata=OPTIONAL)
    grading: float = field(default=0.5, metadata=OPTIONAL)
    forward_coefficient: float = field(default=0.5, metadata=OPTIONAL)
    transit_time: float = field(default=0.0, metadata=OPTIONAL)
    breakdown_voltage: float = field(default=0.0, metadata=OPTIONAL)
    breakdown_current: float = field(default=BREAKDOWN_CURRENT, metadata=OPTIONAL)
    breakdown_emission: float = field(default=1.0, metadata=OPTIONAL)
    energy_gap: float = field(default=1.11, metadata=OPTIONAL)
    current_exponent: float = field(default=3.0, metadata=OPTIONAL)
    nominal_temperature_c: float = field(default=27.0, metadata=OPTIONAL)

    def __repr__(self) -> str:
        return brief(self)

    def terminals(self) -> tuple[str, ...]:
        """The nodes anode and cathode."""
        return self.anode, self.cathode

    def parameters(self) -> Mapping[str, float]:
        """All figures by name, in the units of the class."""
        return {name: getattr(self, name) for name in _RULES}

    def check(self) -> None:
        """Raise `ParameterError` for a figure outside of what the law allows."""
        for name, (unit, least, allowed, below) in _RULES.items():
            value, tail = getattr(self, name), f" {unit}" if unit else ""
            label = f"{self.name}.{name}"
            require_real(label, value, unit)
            if not (math.isfinite(value) and (value > least or (allowed and value == least))):
                sign = ">=" if allowed else ">"
                raise ParameterError(f"{label}: {value:g}{tail}, must be {sign} {least:g}; correct it")
            if not value < below:
                raise ParameterError(f"{label}: {value:g}{tail}, must be below {below:g}{tail}; correct it")
        if self.forward_coefficient * self.junction_potential > 1.0:
            raise ParameterError(
                f"{self.name}.junction_potential: {self.junction_potential:g} V, must be at most 1 V /"
                f" forward_coefficient {self.forward_coefficient:g}; lower one of them"
            )

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """Direct current flows between anode and cathode."""
        return ((0, 1),)


class DiodeArrays(NamedTuple):
    """Coefficients of n diodes at one temperature, float64[n] each unless stated.

    terminal: int32[2, n], positions of anode and cathode in the voltage vector. charge: int32[n], position
    of the unknown that is the diode's charge, -1 without one. saturation: I_S, A. slope: N U_T, V.
    highest: exponent above which a current is its tangent. breakdown: B, V, inf without breakdown.
    breakdown_slope: N_B U_T, V. capacitance, potential, grading: C_J, F, V_J, V, and M. bend: FC V_J, V.
    bend_charge, bend_capacitance, bend_rise: charge, C, capacitance, F, and its slope, F/V, there.
    transit: TT, s.
    """

    terminal: I32
    charge: I32
    saturation: F64
    slope: F64
    highest: F64
    breakdown: F64
    breakdown_slope: F64
    capacitance: F64
    potential: F64
    grading: F64
    bend: F64
    bend_charge: F64
    bend_capacitance: F64
    bend_rise: F64
    transit: F64


def stores_charge(parameters: Mapping[str, F64]) -> Bools:
    """Which diodes store charge, bool[n], by their `parameters`, float64[n] each."""
    return np.asarray((parameters["junction_capacitance"] > 0.0) | (parameters["transit_time"] > 0.0))


def diode_arrays(
    terminal: I32 | I64, charge: I32 | I64, parameters: Mapping[str, F64], temperature_c: float
) -> DiodeArrays:
    """Coefficients of diodes at a temperature, degC; arguments as in `DiodeArrays`.

    Raises `ParameterError` where a junction's potential vanishes at the temperature.
    """
    p, u_t = parameters, thermal_voltage(temperature_c)
    saturation = p["area"] * p["saturation_current"] * _growth(p, temperature_c)
    slope, m = p["emission"] * u_t, p["grading"]
    potential, shape = _junction(p, temperature_c)
    capacitance = p["area"] * p["junction_capacitance"] * shape
    bend, rest = p["forward_coefficient"] * potential, 1.0 - p["forward_coefficient"]
    at_bend = capacitance * rest**-m
    return DiodeArrays(
        terminal.astype(np.int32), charge.astype(np.int32), saturation, slope,
        np.log(FAR_CURRENT / saturation), _breakdown(p, saturation, u_t),
        p["breakdown_emission"] * u_t, capacitance, potential, m, bend,
        capacitance * potential * (1.0 - rest ** (1.0 - m)) / (1.0 - m), at_bend,
        at_bend * m / (rest * potential), p["transit_time"],
    )  # fmt: skip


def _growth(p: Mapping[str, F64], temperature_c: float) -> F64:
    """I_S at a temperature over that at the nominal one."""
    ratio = kelvin(temperature_c) / (p["nominal_temperature_c"] + ZERO_CELSIUS)
    rise = (ratio - 1.0) * p["energy_gap"] / (p["emission"] * thermal_voltage(temperature_c))
    return np.asarray(np.exp(rise + p["current_exponent"] / p["emission"] * np.log(ratio)))


def _junction(p: Mapping[str, F64], temperature_c: float) -> tuple[F64, F64]:
    """V_J at a temperature, V, and C_J over that at the nominal temperature."""
    nominal, at = p["nominal_temperature_c"] + ZERO_CELSIUS, np.asarray(kelvin(temperature_c))
    reference = (p["junction_potential"] - _shift(nominal)) * _REFERENCE / nominal
    potential = _shift(at) + reference * at / _REFERENCE
    if (potential <= 0.0).any():
        raise ParameterError(
            f"diode.junction_potential: {float(potential.min()):g} V at {temperature_c:g} degC, must be > 0;"
            " stay at lower temperatures"
        )
    before = 1.0 + p["grading"] * (
        4e-4 * (nominal - _REFERENCE) - (p["junction_potential"] / reference - 1.0)
    )
    after = 1.0 + p["grading"] * (4e-4 * (at - _REFERENCE) - (potential / reference - 1.0))
    return potential, after / before


def _shift(at: F64) -> F64:
    """What the band gap of silicon adds to a junction's potential at a temperature (K), V."""
    u_t = BOLTZMANN * at / ELEMENTARY_CHARGE
    gap = 1.16 - 7.02e-4 * at**2 / (at + 1108.0)
    return np.asarray(gap - 1.1150877 * at / _REFERENCE - 3.0 * u_t * np.log(at / _REFERENCE))


def _breakdown(p: Mapping[str, F64], saturation: F64, u_t: float) -> F64:
    """B of each diode, V; inf without breakdown."""
    voltage, slope = p["breakdown_voltage"], p["breakdown_emission"] * u_t
    share = p["breakdown_current"] / saturation
    found = voltage.copy()
    for _ in range(ROUNDS):
        found = voltage - slope * np.log(np.maximum(share + 1.0 - found / u_t, 1.0))
    # a current below what the saturation current has there anyway begins at the voltage itself, as in SPICE
    found = np.where(share < voltage / u_t, voltage, found)
    return np.where(voltage > 0.0, found, np.inf)


@compiled()
def _exponential(x: float, highest: float) -> tuple[float, float]:
    """`e^x` and its derivative, beyond `highest` its tangent."""
    if x <= highest:
        e = math.exp(x)
        return e, e
    e = math.exp(highest)
    return e * (1.0 + x - highest), e


@compiled()
def diode_currents(d: DiodeArrays, v: F64, current: F64, slope: F64) -> None:
    """Fill in the currents from anode to cathode and the charges of n diodes, and their derivatives.

    v: float64[columns], V. current: float64[2, n], A and C. slope: float64[2, n], S and F, by the voltage
    from anode to cathode.
    """
    for k in range(d.saturation.size):
        u, s, g = v[d.terminal[0, k]] - v[d.terminal[1, k]], d.saturation[k], d.slope[k]
        if u >= -3.0 * g:
            e, by = _exponential(u / g, d.highest[k])
            i, conductance = s * (e - 1.0), s * by / g
        elif u >= -d.breakdown[k]:
            more = (_THIRD * g / u) ** 3
            i, conductance = -s * (1.0 + more), 3.0 * s * more / u
        else:
            b = d.breakdown_slope[k]
            e, by = _exponential(-(u + d.breakdown[k]) / b, d.highest[k])
            i, conductance = -s * e, s * by / b
        current[0, k], slope[0, k] = i, conductance
        charge, capacitance = _depletion(d, k, u)
        current[1, k] = charge + d.transit[k] * i
        slope[1, k] = capacitance + d.transit[k] * conductance


@compiled()
def diode_course(d: DiodeArrays, v: F64, own: int, current: F64, slope: F64, found: F64) -> None:
    """Fill `found`, float64[2, T], with current (A) and charge (C) of diode `own` at each row of v.

    v: float64[T, columns], V. current, slope: float64[2, n], scratch.
    """
    for p in range(v.shape[0]):
        diode_currents(d, v[p], current, slope)
        found[0, p], found[1, p] = current[0, own], current[1, own]


@compiled()
def _depletion(d: DiodeArrays, k: int, u: float) -> tuple[float, float]:
    """Charge (C) and capacitance (F) of a depletion layer at the voltage u, V."""
    if d.capacitance[k] == 0.0:
        return 0.0, 0.0
    if u < d.bend[k]:
        left, m = 1.0 - u / d.potential[k], d.grading[k]
        small = left**-m
        return (
            d.capacitance[k] * d.potential[k] * (1.0 - left * small) / (1.0 - m),
            d.capacitance[k] * small,
        )
    beyond = u - d.bend[k]
    more = d.bend_rise[k] * beyond
    return d.bend_charge[k] + beyond * (d.bend_capacitance[k] + 0.5 * more), d.bend_capacitance[k] + more
