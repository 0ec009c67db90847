"""Fabrication processes, and the laws by which their parameters follow temperature.

With T0 the process's nominal temperature,

    U_T = k T / q                                thermal voltage
    V_T0(T) = V_T0 + dV_T/dT (T - T0)            threshold
    mu(T) = mu (T / T0)^m                        mobility
    J(T) = J 2^((T - T0) / doubling)             junction leakage
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal, get_args

from circuits.checks import require_choice, require_real, require_type
from circuits.errors import ParameterError

BOLTZMANN = 1.380649e-23  # J/K
"""Boltzmann's constant, J/K."""
ELEMENTARY_CHARGE = 1.602176634e-19  # C
ZERO_CELSIUS = 273.15  # K
LOWEST_C, HIGHEST_C = -40.0, 125.0

Polarity = Literal["n", "p"]
POLARITIES: tuple[Polarity, ...] = ("n", "p")
Law = Literal["ekv", "ekv-gamma"]


@dataclass(frozen=True, slots=True)
class TransistorModel:
    """Parameters of the transistors of one polarity at the nominal temperature, all of them magnitudes.

    Attributes
    ----------
    v_t0 : float
        Threshold voltage at v_p = 0, V.
    kappa : float
        Gate coupling, dimensionless; under `ekv-gamma` its value at v_p = 0.
    mu_cox : float
        Mobility times oxide capacitance, A/V^2.
    law : str
        `ekv` keeps kappa constant, as the equations of the papers do; `ekv-gamma` lets it follow the
        pinch-off voltage (body effect).
    surface_potential : float
        Surface potential 2 phi_F, V; used by `ekv-gamma` only. Ours: that of 1e16 cm^-3.
    early : float
        Relative change of the current for each volt of drain voltage, 1/V; off by default (ours).
    oxide_capacitance : float
        Capacitance of the gate oxide, F/m^2.
    gate_bulk_fraction : float
        Share of the oxide's capacitance over W L that is seen from gate to bulk, dimensionless.
    overlap_capacitance : float
        Capacitance between gate and drain, and between gate and source, for each metre of width, F/m.
    junction_capacitance : float
        Capacitance between drain and bulk, and between source and bulk, for each metre of width, F/m.
    junction_leakage : float
        Leakage of drain and source to the bulk for each metre of width at the nominal temperature, A/m; off
        by default (ours).
    leakage_doubling : float
        Rise of temperature that doubles the leakage, K; 8 to 10 are usual, unverified.
    v_t0_drift : float
        Change of the threshold with temperature, V/K.
    mobility_exponent : float
        Exponent of absolute temperature in the mobility, dimensionless; that of the MOSIS default card, not
        extracted.
    """

    v_t0: float
    kappa: float
    mu_cox: float
    law: Law = "ekv"
    surface_potential: float = 0.7
    early: float = 0.0
    oxide_capacitance: float = 1.1e-3
    gate_bulk_fraction: float = 0.5
    overlap_capacitance: float = 0.2e-9
    junction_capacitance: float = 1.5e-9
    junction_leakage: float = 0.0
    leakage_doubling: float = 9.0
    v_t0_drift: float = -1e-3
    mobility_exponent: float = -1.5

    def __post_init__(self) -> None:
        require_choice("transistor_model.law", self.law, get_args(Law))
        for each in fields(self):
            if each.name != "law":
                require_real(f"transistor_model.{each.name}", getattr(self, each.name), "SI")

    @property
    def gamma(self) -> float:
        """Body-effect coefficient, V^0.5, from `kappa(v_p = 0) = 1 / (1 + gamma / (2 sqrt(phi)))`."""
        return 2.0 * (1.0 / self.kappa - 1.0) * math.sqrt(self.surface_potential)


@dataclass(frozen=True, slots=True)
class Variation:
    """Standard deviations, from die to die, of what all transistors of one polarity share.

    The numbers are ours: 3 sigma of V_T0 is 0.1 V (two published runs of this line differ by 0.12 V), and 3
    sigma of beta is 12 %.

    Attributes
    ----------
    sigma_v_t0 : float
        Of the threshold voltage, V.
    sigma_beta : float
        Of the current factor, relative.
    """

    sigma_v_t0: float = 33e-3
    sigma_beta: float = 0.04


@dataclass(frozen=True, slots=True)
class Process:
    """A fabrication process: its transistors, its supply, and how far devices and dies differ.

    Attributes
    ----------
    name : str
        Name of the process.
    n, p : TransistorModel
        Models of nFETs and pFETs.
    v_dd : float
        Supply voltage, V.
    pair_a_vt : float
        Standard deviation of the difference of V_T in a pair, times sqrt(W L), V m.
    pair_a_beta : float
        Standard deviation of the relative difference of beta in a pair, times sqrt(W L), m.
    nominal_temperature_c : float
        Temperature at which the models' numbers hold, degC.
    variation : Variation
        Spread from die to die.
    """

    name: str
    n: TransistorModel
    p: TransistorModel
    v_dd: float
    pair_a_vt: float
    pair_a_beta: float
    nominal_temperature_c: float = 27.0
    variation: Variation = Variation()

    def __post_init__(self) -> None:
        require_type("process.name", self.name, str, "a name")
        for polarity in POLARITIES:
            model = getattr(self, polarity)
            require_type(f"{self.name}.{polarity}", model, TransistorModel, "a transistor model")
        for name in ("v_dd", "pair_a_vt", "pair_a_beta", "nominal_temperature_c"):
            require_real(f"{self.name}.{name}", getattr(self, name), "SI")
        require_type(f"{self.name}.variation", self.variation, Variation, "a variation")

    def model(self, polarity: Polarity) -> TransistorModel:
        """The transistor model of one polarity."""
        return self.n if polarity == "n" else self.p


# AMI 1.5 um: V_T0, kappa, mu Cox and capacitances of the rebound neuron's feasibility study; pair figures
# from the rule of 1 mV um a nm of oxide (30 nm) and from Pelgrom's 2.5 um process.
AMI_1500 = Process(
    name="ami-1500",
    n=TransistorModel(v_t0=0.60, kappa=0.70, mu_cox=72e-6),
    p=TransistorModel(v_t0=0.85, kappa=0.75, mu_cox=25e-6),
    v_dd=5.0,
    pair_a_vt=28e-9,
    pair_a_beta=0.02e-6,
)
"""The AMI 1.5 um process with a supply of 5 V, in which the sonar's circuits are designed."""

# A 0.18 um process of 1.8 V like that of ROLLS, whose own figures are not public. kappa: software models of
# these circuits (teili). V_T0: ours, so that a square device's current at V_G = 0 is their I_0, 0.5 pA. mu
# Cox (350 and 80 cm^2/V/s, 4.1 nm of oxide), capacitances, the matching of a pair (general knowledge: 3.5 to
# 5 mV um, about 1 % um) and the spread of dies: ours, unverified. dV_T/dT: as in two open 0.18 um processes.
ROLLS_180 = Process(
    name="rolls-180",
    n=TransistorModel(
        v_t0=0.478, kappa=0.75, mu_cox=295e-6, oxide_capacitance=8.4e-3,
        overlap_capacitance=0.3e-9, junction_capacitance=0.8e-9,
    ),
    p=TransistorModel(
        v_t0=0.490, kappa=0.66, mu_cox=67e-6, oxide_capacitance=8.4e-3,
        overlap_capacitance=0.3e-9, junction_capacitance=0.8e-9,
    ),
    v_dd=1.8,
    pair_a_vt=4.5e-9,
    pair_a_beta=0.01e-6,
    variation=Variation(sigma_v_t0=15e-3, sigma_beta=0.04),
)  # fmt: skip
"""A 0.18 um process with a supply of 1.8 V, like that of ROLLS, whose own figures are not public."""

PROCESSES = {p.name: p for p in (AMI_1500, ROLLS_180)}
"""The processes that noctule has, by name."""


def check_temperature(temperature_c: float) -> None:
    """Raise `ParameterError` for a temperature (degC) outside of the range over which the laws hold."""
    require_real("temperature", temperature_c, "degC")
    if not LOWEST_C <= temperature_c <= HIGHEST_C:
        raise ParameterError(
            f"temperature: {temperature_c:g} degC, must be within {LOWEST_C:g} to {HIGHEST_C:g} degC,"
            " where the temperature laws hold"
        )


def kelvin(temperature_c: float) -> float:
    """Absolute temperature, K, of a temperature in degC."""
    return temperature_c + ZERO_CELSIUS


def thermal_voltage(temperature_c: float) -> float:
    """Thermal voltage `U_T = k T / q` at `temperature_c` (degC), V."""
    return BOLTZMANN * kelvin(temperature_c) / ELEMENTARY_CHARGE


@dataclass(frozen=True, slots=True)
class TransistorAtTemperature:
    """Parameters of a transistor model at one temperature, in the form that the current law takes.

    square_current: specific current of a device as wide as long, `2 mu Cox U_T^2 / kappa`, A.
    """

    square_current: float
    u_t: float
    v_t0: float
    kappa: float
    gamma: float  # 0 for the constant-kappa law
    surface_potential: float
    early: float
    junction_leakage: float


def at_temperature(model: TransistorModel, process: Process, temperature_c: float) -> TransistorAtTemperature:
    """A transistor model's parameters at a temperature (degC)."""
    check_temperature(temperature_c)
    u_t = thermal_voltage(temperature_c)
    rise = temperature_c - process.nominal_temperature_c
    ratio = kelvin(temperature_c) / kelvin(process.nominal_temperature_c)
    try:
        square_current = 2.0 * model.mu_cox * ratio**model.mobility_exponent * u_t**2 / model.kappa
        junction_leakage = model.junction_leakage * 2.0 ** (rise / model.leakage_doubling)
    except (OverflowError, ZeroDivisionError):
        found = f"kappa {model.kappa:g}, mobility_exponent {model.mobility_exponent:g}, leakage_doubling"
        raise ParameterError(
            f"process.{found} {model.leakage_doubling:g} K: no finite current at {temperature_c:g} degC;"
            " correct them"
        ) from None
    return TransistorAtTemperature(
        square_current=square_current,
        u_t=u_t,
        v_t0=model.v_t0 + model.v_t0_drift * rise,
        kappa=model.kappa,
        gamma=model.gamma if model.law == "ekv-gamma" else 0.0,
        surface_potential=model.surface_potential,
        early=model.early,
        junction_leakage=junction_leakage,
    )
