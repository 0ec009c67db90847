"""Components of variation beside the local mismatch of transistors and the process that a die shares.

| component | law |
|---|---|
| capacitors | one has `sigma(dC / C) = A_C / sqrt(2 area)`, `area = C / capacitance_density` |
| capacitances, resistances | one relative shift of all of a kind on a die |
| gradients | a plane a die, polarity and parameter: a pair a distance D apart differs by `S D` (sigma) |
| lot and wafer | shares of the variance that all devices of a die share; the rest is the die's own |
| n and p | correlation of what nFETs and pFETs of a die share, of V_T0 and of beta |

Source: Pelgrom, Duinmaijer, Welbers, "Matching properties of MOS transistors", IEEE JSSC 24 (1989) 1433, for
the law `sigma^2 = A^2 / (W L) + S^2 D^2`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Literal

from circuits.checks import require_real
from circuits.errors import ParameterError

Extent = Literal["plain", "transistors", "full"]
EXTENTS: tuple[Extent, ...] = ("plain", "transistors", "full")
"""Which components a die has: `plain` none of these, `transistors` those of transistors, `full` all."""

DIES_A_WAFER = 40
"""Dies of a lot, in the order of their numbers, that come from one wafer. Ours."""


@dataclass(frozen=True, slots=True)
class Components:
    """Figures of a process's components of variation.

    Attributes
    ----------
    pair_a_capacitance : float
        Standard deviation of the relative difference of a pair of capacitors, times the root of the area of
        one, m.
    capacitance_density : float
        Capacitance of a capacitor for each area, F/m^2.
    sigma_capacitance : float
        Standard deviation from die to die of all capacitors together, relative.
    sigma_resistance : float
        Standard deviation from die to die of all resistors together, relative.
    distance_v_t0 : float
        Standard deviation of the difference of V_T0 in a pair for each distance, V/m.
    distance_beta : float
        Standard deviation of the relative difference of beta in a pair for each distance, 1/m.
    lot_share : float
        Share of the lot in the variance that a die's devices share, 0 to 1.
    wafer_share : float
        Share of the wafer in it, 0 to 1.
    correlation_v_t0 : float
        Correlation of what nFETs and pFETs of a die share of |V_T0|, -1 to 1.
    correlation_beta : float
        Correlation of what they share of beta, -1 to 1.

    Raises
    ------
    ParameterError
        A figure is negative, a correlation is no correlation, or the shares are more than 1 together.
    """

    pair_a_capacitance: float
    capacitance_density: float
    sigma_capacitance: float
    sigma_resistance: float
    distance_v_t0: float
    distance_beta: float
    lot_share: float
    wafer_share: float
    correlation_v_t0: float
    correlation_beta: float

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            require_real(f"components.{each.name}", value, "SI")
            correlation = each.name.startswith("correlation")
            low, high = (-1.0, 1.0) if correlation else (0.0, float("inf"))
            if not low <= value <= high:
                rule = "within -1 to 1" if correlation else ">= 0"
                raise ParameterError(f"components.{each.name}: {value:g}, must be {rule}; correct it")
        if not self.capacitance_density > 0.0:
            raise ParameterError("components.capacitance_density: 0 F/m^2, must be > 0; correct it")
        if self.lot_share + self.wafer_share > 1.0:
            raise ParameterError(
                f"components.wafer_share: {self.wafer_share:g} beside a lot_share of {self.lot_share:g}, must"
                " be at most 1 together; the rest is the die's own"
            )


# Of AMI's 1.5 um line. Capacitance between its two layers of polysilicon: 610 aF/um^2 in MOSIS's run T69L.
# Spread of capacitances and resistances: three runs of the sister line C5 (T36S, T77Z, T85R) have 858, 912,
# 874 aF/um^2 and 988, 1042, 1058 Ohm a square of high-resistance polysilicon, which is 3.2 and 3.6 %.
# Distance: Pelgrom's 2.5 um process, 4 uV/um and 2e-6 /um, from memory, unverified. Matching of capacitors:
# 0.023 % at 50 um by 50 um in a foundry's table that a forum quotes, so 1.15 % um. The shares and the
# correlations (one oxide and one length for both polarities, but implants of their own) are ours.
AMI_1500_COMPONENTS = Components(
    pair_a_capacitance=11.5e-9,
    capacitance_density=610e-6,
    sigma_capacitance=0.032,
    sigma_resistance=0.036,
    distance_v_t0=4.0,
    distance_beta=2.0,
    lot_share=0.5,
    wafer_share=0.3,
    correlation_v_t0=0.3,
    correlation_beta=0.6,
)

# Of a 0.18 um line: 1 fF/um^2 between metals (general knowledge, unverified), and a distance term of V_T0
# that falls with the oxide, 30 to 4.1 nm (ours); the rest as above.
ROLLS_180_COMPONENTS = replace(AMI_1500_COMPONENTS, capacitance_density=1e-3, distance_v_t0=0.55)
