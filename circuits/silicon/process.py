"""Fabrication processes, and the laws by which their parameters follow temperature.

With T0 the process's nominal temperature,

    U_T = k T / q                                thermal voltage
    V_T0(T) = V_T0 + dV_T/dT (T - T0)            threshold
    mu(T) = mu (T / T0)^m                        mobility
    J(T) = J 2^((T - T0) / doubling)             junction leakage

A process states its second-order effects: body effect, Early effect by length and inversion, mobility
reduction, leakage of junctions, also where a gate induces it. `Process.under` chooses the law: `full` has all
of them, `ideal` none, as the equations of the papers do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Any, Literal, TypedDict, get_args

import numpy as np

from circuits.arrays import F64
from circuits.brief import OPTIONAL, brief
from circuits.checks import require_choice, require_real, require_type
from circuits.errors import ParameterError
from circuits.silicon.components import AMI_1500_COMPONENTS, ROLLS_180_COMPONENTS, Components
from circuits.silicon.size import SizeTerms
from circuits.units import quantity

BOLTZMANN = 1.380649e-23  # J/K
"""Boltzmann's constant, J/K."""
ELEMENTARY_CHARGE = 1.602176634e-19  # C
ZERO_CELSIUS = 273.15  # K
LOWEST_C, HIGHEST_C = -40.0, 125.0

Polarity = Literal["n", "p"]
POLARITIES: tuple[Polarity, ...] = ("n", "p")
Law = Literal["ekv", "ekv-gamma"]
Effects = Literal["ideal", "full"]
EFFECTS: tuple[Effects, ...] = ("ideal", "full")
"""Which second-order effects a law has: none, or all that the process states."""


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
    early_field : float
        Early voltage of a device in weak inversion over its length, V/m; 0 for no Early effect.
    early_rise : float
        Relative rise of the Early voltage for each unit of `sqrt(I_F / I_S) + sqrt(I_R / I_S)`, a ratio.
    mobility_reduction : float
        Fall of the mobility for each volt of pinch-off voltage, 1/V.
    oxide_capacitance : float
        Capacitance of the gate oxide, F/m^2.
    gate_bulk_fraction : float
        Share of the oxide's capacitance over W L that is seen from gate to bulk, dimensionless.
    overlap_capacitance : float
        Capacitance between gate and drain, and between gate and source, for each metre of width, F/m.
    junction_capacitance : float
        Capacitance between drain and bulk, and between source and bulk, for each metre of width, F/m.
    junction_leakage : float
        Leakage of drain and source to the bulk for each metre of width at the nominal temperature, A/m.
    gate_induced_leakage : float
        What a gate adds to it where the drain is a supply above the gate, A/m; at all temperatures.
    gate_induced_slope : float
        Voltage between drain and gate that changes this e-fold, V.
    leakage_doubling : float
        Rise of temperature that doubles the leakage, K; 8 to 10 are usual, unverified.
    v_t0_drift : float
        Change of the threshold with temperature, V/K.
    mobility_exponent : float
        Exponent of absolute temperature in the mobility, dimensionless; that of the MOSIS default card, not
        extracted.
    size : SizeTerms or None
        How the numbers follow a device's width and length; None where all sizes share them.
    """

    v_t0: float
    kappa: float
    mu_cox: float
    law: Law = "ekv"
    surface_potential: float = quantity(0.7, "V")
    early_field: float = quantity(0.0, "V/m")
    early_rise: float = quantity(0.0, "")
    mobility_reduction: float = quantity(0.0, "1/V")
    oxide_capacitance: float = quantity(1.1e-3, "F/m^2")
    gate_bulk_fraction: float = quantity(0.5, "")
    overlap_capacitance: float = quantity(0.2e-9, "F/m")
    junction_capacitance: float = quantity(1.5e-9, "F/m")
    junction_leakage: float = quantity(0.0, "A/m")
    gate_induced_leakage: float = quantity(0.0, "A/m")
    gate_induced_slope: float = quantity(0.15, "V")
    leakage_doubling: float = quantity(9.0, "K")
    v_t0_drift: float = quantity(-1e-3, "V/K")
    mobility_exponent: float = quantity(-1.5, "")
    size: SizeTerms | None = field(default=None, metadata=OPTIONAL)

    def __post_init__(self) -> None:
        require_choice("transistor_model.law", self.law, get_args(Law))
        for each in fields(self):
            if each.name not in {"law", "size"}:
                require_real(f"transistor_model.{each.name}", getattr(self, each.name), "SI")
        if self.size is not None:
            require_type("transistor_model.size", self.size, SizeTerms, "terms of the size")

    def __repr__(self) -> str:
        """As of every dataclass; one without terms of the size says nothing of them, as in kept hashes."""
        return brief(self)

    def ideal(self) -> TransistorModel:
        """The same transistors without second-order effects: constant kappa, no Early effect, no leakage."""
        size = None if self.size is None else self.size.ideal()
        return replace(self, law="ekv", size=size, **dict.fromkeys(SECOND_ORDER, 0.0))

    @property
    def gamma(self) -> float:
        """Body-effect coefficient, V^0.5, from `kappa(v_p = 0) = 1 / (1 + gamma / (2 sqrt(phi)))`."""
        return 2.0 * (1.0 / self.kappa - 1.0) * math.sqrt(self.surface_potential)


class _SecondOrder(TypedDict, total=False):
    law: Law
    early_field: float
    early_rise: float
    mobility_reduction: float
    junction_leakage: float
    gate_induced_leakage: float


SECOND_ORDER = (
    "early_field", "early_rise", "mobility_reduction", "junction_leakage", "gate_induced_leakage",
)  # fmt: skip
"""Figures of a `TransistorModel` that are 0 without their effect; the law's variant is another."""


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
class DiodeVariation:
    """Standard deviations of the saturation currents I_S of a process's diodes.

    The area of a diode is that of `circuits.devices.Diode`, in whatever its model counts it.

    Attributes
    ----------
    pair_a_saturation : float
        Standard deviation of the relative difference of I_S in a pair, times the root of the area of one:
        dimensionless where an area is a number of unit junctions, m where it is in m^2.
    sigma_saturation : float
        Standard deviation from die to die of what all diodes share of I_S, relative.

    Raises
    ------
    ParameterError
        A figure is negative.
    """

    pair_a_saturation: float
    sigma_saturation: float

    def __post_init__(self) -> None:
        figures = {"pair_a_saturation": self.pair_a_saturation, "sigma_saturation": self.sigma_saturation}
        for name, value in figures.items():
            require_real(f"diodes.{name}", value, "SI")
            if not 0.0 <= value < math.inf:
                raise ParameterError(f"diodes.{name}: {value:g}, must be >= 0 and finite; correct it")


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
    components : Components or None
        Components of variation that a die has beside these where it is asked for them; None where the process
        states none.
    cards : str
        Name of the foundry's process whose own cards ngspice takes in the place of our law, which stands for
        them in our solver; empty for a process that is our law's alone.
    diodes : DiodeVariation or None
        How far diodes and dies differ in their saturation currents; None where the process does not state it
        and all diodes are as drawn on every die.
    """

    name: str
    n: TransistorModel
    p: TransistorModel
    v_dd: float
    pair_a_vt: float
    pair_a_beta: float
    nominal_temperature_c: float = 27.0
    variation: Variation = Variation()
    components: Components | None = field(default=None, repr=False)  # of dies that have them alone

    cards: str = field(default="", metadata=OPTIONAL)
    diodes: DiodeVariation | None = field(default=None, metadata=OPTIONAL)

    def __repr__(self) -> str:
        """As of every dataclass; cards and diodes that it has not go unsaid, as in kept hashes."""
        return brief(self)

    def __post_init__(self) -> None:
        require_type("process.name", self.name, str, "a name")
        require_type(f"{self.name}.cards", self.cards, str, "a name")
        for polarity in POLARITIES:
            model = getattr(self, polarity)
            require_type(f"{self.name}.{polarity}", model, TransistorModel, "a transistor model")
        for name in ("v_dd", "pair_a_vt", "pair_a_beta", "nominal_temperature_c"):
            require_real(f"{self.name}.{name}", getattr(self, name), "SI")
        require_type(f"{self.name}.variation", self.variation, Variation, "a variation")
        if self.components is not None:
            require_type(f"{self.name}.components", self.components, Components, "components")
        if self.diodes is not None:
            require_type(f"{self.name}.diodes", self.diodes, DiodeVariation, "a variation of diodes")

    def model(self, polarity: Polarity) -> TransistorModel:
        """The transistor model of one polarity."""
        return self.n if polarity == "n" else self.p

    def ideal(self) -> Process:
        """The same process with transistors without second-order effects."""
        return replace(self, n=self.n.ideal(), p=self.p.ideal())

    def under(self, effects: Effects) -> Process:
        """The same process under a law: `full` as it is, `ideal` without second-order effects."""
        require_choice("law", effects, EFFECTS)
        return self.ideal() if effects == "ideal" else self

    @property
    def effects(self) -> Effects:
        """`ideal` where no transistor has a second-order effect, else `full`."""
        return _effects_of(self)


@lru_cache(maxsize=64)
def _effects_of(process: Process) -> Effects:
    return "ideal" if process == process.ideal() else "full"


# AMI 1.5 um: V_T0, kappa, mu Cox and capacitances of the rebound neuron's feasibility study; pair figures
# from the rule of 1 mV um a nm of oxide (30 nm) and from Pelgrom's 2.5 um process. Ours: an Early voltage of
# 10 V/um, which is the study's 0.03 /V at a length of 3.3 um; its rise, as measured in 0.18 um; a mobility
# reduction of 0.1 /V, as cards of MOSIS runs of this line have it; a leakage of 10 aA/um^2 over diffusions of
# 3.75 um. An oxide of 30 nm leaves a gate no leakage to induce.
_AMI_SECOND_ORDER: _SecondOrder = {
    "law": "ekv-gamma", "early_field": 10e6, "early_rise": 0.13, "mobility_reduction": 0.1,
    "junction_leakage": 4e-11,
}  # fmt: skip
AMI_1500 = Process(
    name="ami-1500",
    n=TransistorModel(v_t0=0.60, kappa=0.70, mu_cox=72e-6, **_AMI_SECOND_ORDER),
    p=TransistorModel(v_t0=0.85, kappa=0.75, mu_cox=25e-6, **_AMI_SECOND_ORDER),
    v_dd=5.0,
    pair_a_vt=28e-9,
    pair_a_beta=0.02e-6,
    components=AMI_1500_COMPONENTS,
)
"""The AMI 1.5 um process with a supply of 5 V, in which the sonar's circuits are designed."""
AMI_1500_IDEAL = AMI_1500.ideal()
"""The same without second-order effects: the law of the papers' equations."""

# A 0.18 um process of 1.8 V like that of ROLLS, whose own figures are not public. kappa: software models of
# these circuits (teili). V_T0: ours, so that a square device's current at V_G = 0 is their I_0, 0.5 pA. mu
# Cox (350 and 80 cm^2/V/s, 4.1 nm of oxide), capacitances, the matching of a pair (general knowledge: 3.5 to
# 5 mV um, about 1 % um) and the spread of dies: ours, unverified. dV_T/dT: as in two open 0.18 um processes.
# Early voltage: measured on nFETs of a 0.18 um chip, 4 to 5.5 V at a length of 1 um in weak inversion (one
# indirect figure), and 24, 39, 45, 59, 51 V at 4 um and V_G 0.8 to 1.6 V, which is 4.75 V/um (1 + 0.13 q)
# with q = sqrt(I_F / I_S) of 4.5 to 16; pFETs: the same, ours. Mobility reduction: the same chip's 0.5 to
# 0.85 /V of gate voltage over kappa. Leakage (10 aA/um^2 over diffusions of 0.5 um, and twice that of their
# edges) and what a gate induces (0.1 pA/um at the supply, a decade for 0.35 V): ours, unverified.
_ROLLS_SECOND_ORDER: _SecondOrder = {
    "law": "ekv-gamma", "early_field": 4.75e6, "early_rise": 0.13, "mobility_reduction": 0.9,
    "junction_leakage": 1.5e-11, "gate_induced_leakage": 1e-7,
}  # fmt: skip
ROLLS_180 = Process(
    name="rolls-180",
    n=TransistorModel(
        v_t0=0.478, kappa=0.75, mu_cox=295e-6, oxide_capacitance=8.4e-3,
        overlap_capacitance=0.3e-9, junction_capacitance=0.8e-9, **_ROLLS_SECOND_ORDER,
    ),
    p=TransistorModel(
        v_t0=0.490, kappa=0.66, mu_cox=67e-6, oxide_capacitance=8.4e-3,
        overlap_capacitance=0.3e-9, junction_capacitance=0.8e-9, **_ROLLS_SECOND_ORDER,
    ),
    v_dd=1.8,
    pair_a_vt=4.5e-9,
    pair_a_beta=0.01e-6,
    variation=Variation(sigma_v_t0=15e-3, sigma_beta=0.04),
    components=ROLLS_180_COMPONENTS,
)  # fmt: skip
"""A 0.18 um process with a supply of 1.8 V, like that of ROLLS, whose own figures are not public."""
ROLLS_180_IDEAL = ROLLS_180.ideal()
"""The same without second-order effects."""

PROCESSES = {p.name: p for p in (AMI_1500, ROLLS_180)}
"""The processes that noctule has, by name, with all their second-order effects."""


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
    early_field: float  # V/m, 0 for none
    early_rise: float
    mobility_reduction: float
    junction_leakage: float
    gate_induced_leakage: float
    gate_induced_slope: float
    gate_induced_from: float  # V between drain and gate, of `gate_induced_leakage`
    size: SizeTerms | None = field(default=None, metadata=OPTIONAL)
    rise: float = field(default=0.0, metadata=OPTIONAL)  # K above the nominal temperature, for `of_size`
    ratio: float = field(
        default=1.0, metadata=OPTIONAL
    )  # absolute temperature over the nominal one, likewise

    def of_size(self, width: F64 | float, length: F64 | float) -> TransistorAtTemperature:
        """The law of devices of a width and a length, m; its numbers are arrays where these are.

        Raises `ParameterError` for a size that the process does not hold for.
        """
        if self.size is not None:
            self.size.check(width, length)
        return self.of_any_size(width, length)

    def of_any_size(self, width: F64 | float, length: F64 | float) -> TransistorAtTemperature:
        """The same for sizes (m) that somebody has looked at, or of which the numbers are thrown away."""
        if self.size is None:
            return self
        more = self.size.at(width, length)
        kappa = self.kappa + more["kappa"]
        gain = np.exp(more["mu_cox"]) * self.ratio ** more["mobility_exponent"] * self.kappa / kappa
        gamma: Any = (
            2.0 * (1.0 / kappa - 1.0) * math.sqrt(self.surface_potential) if self.gamma > 0.0 else 0.0
        )
        scalar = isinstance(kappa, float)
        return replace(
            self,
            square_current=self.square_current * (float(gain) if scalar else gain),
            v_t0=self.v_t0 + more["v_t0"] + more["v_t0_drift"] * self.rise,
            kappa=kappa,
            gamma=gamma,
            early_field=self.early_field + more["early_field"],
            mobility_reduction=self.mobility_reduction + more["mobility_reduction"],
            size=None,
        )

    def ideal(self) -> TransistorAtTemperature:
        """The same without second-order effects."""
        size = None if self.size is None else self.size.ideal()
        return replace(self, gamma=0.0, size=size, **dict.fromkeys(SECOND_ORDER, 0.0))

    def without_leakage(self) -> TransistorAtTemperature:
        """The same with junctions that do not leak."""
        return replace(self, junction_leakage=0.0, gate_induced_leakage=0.0)


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
        early_field=model.early_field,
        early_rise=model.early_rise,
        mobility_reduction=model.mobility_reduction,
        junction_leakage=junction_leakage,
        gate_induced_leakage=model.gate_induced_leakage,
        gate_induced_slope=model.gate_induced_slope,
        gate_induced_from=process.v_dd,
        size=model.size,
        rise=rise,
        ratio=ratio,
    )
