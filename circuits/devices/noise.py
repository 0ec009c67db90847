"""Noise of the devices, as one-sided spectral densities of their currents, A^2/Hz.

The white noise of a transistor's channel follows from its own law. With the current `I = I_S [F(u_f) -
F(u_r)]` the channel carries at a quasi-Fermi voltage V the charge that conducts `g(V) = (I_S / U_T) F'(u)`,
and

    S = 4 k T G,   G = (I_S / U_T) int F'(u)^2 du / int F'(u) du,   both from u_r to u_f
      = (I_S / U_T) 2 / (L_f + L_r) int_0^1 L^2 (1 - e^-L) dt,   L = L_r + (L_f - L_r) t,

as F = L^2 and F' = L (1 - e^-L) with L = ln(1 + e^(u/2)). In weak inversion this is `2 q (I_f + I_r)`, the
shot noise of the forward and the reverse current. Without a current it is 4 k T g_ds, so that a switch leaves
k T / C on a capacitor. In saturation in strong inversion it is 4 k T (2/3) g_ms. The factors of the
Early effect and of the mobility multiply it (ours).

Flicker noise is a voltage at the gate of density `K_F / (m W L Cox f^AF)`, V^2/Hz. A junction that leaks J
far in reverse has the shot noise of both its components, `2 q J (1 + e^(-v/U_T))`. A diode has that of its
whole current, `2 q |i|`, as in SPICE. A resistor has 4 k T / R.
Capacitors, linear sources and operational amplifiers make no noise.

Sources: Klaassen, Prins, "Thermal noise of MOS transistors" (1967); Enz, Krummenacher, Vittoz (1995), section
on noise; Tsividis, "Operation and Modeling of the MOS Transistor", flicker noise by area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, Bools
from circuits.compiled import compiled
from circuits.devices.transistor import TransistorArrays, TransistorWork
from circuits.errors import ParameterError
from circuits.silicon.process import BOLTZMANN, ELEMENTARY_CHARGE, Polarity, Process

# Gauss-Legendre on 0 to 1: the mean of L^2 (1 - e^-L) is off by 1e-6 of itself at L = 20, by less below
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
CHANNEL_SHARE, CHANNEL_WEIGHT = 0.5 * (1.0 + _NODES), 0.5 * _WEIGHTS


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """Flicker noise of the transistors of a process.

    Attributes
    ----------
    flicker_n, flicker_p : float
        K_F of nFETs and of pFETs, V^2 F: 0 for none.
    exponent : float
        Exponent AF of frequency, dimensionless.

    Raises
    ------
    ParameterError
        K_F is outside 0 to 1e-18 V^2 F, or the exponent outside 0.5 to 1.5.
    """

    flicker_n: float
    flicker_p: float
    exponent: float = 1.0

    def __post_init__(self) -> None:
        for name, value in (("flicker_n", self.flicker_n), ("flicker_p", self.flicker_p)):
            if not 0.0 <= value < 1e-18:
                raise ParameterError(f"noise.{name}: {value:g} V^2 F, must be 0 to 1e-18; 1e-24 is usual")
        if not 0.5 <= self.exponent <= 1.5:
            raise ParameterError(f"noise.exponent: {self.exponent:g}, must be 0.5 to 1.5; 1 is usual")

    def flicker(self, polarity: Polarity) -> float:
        """K_F of one polarity, V^2 F."""
        return self.flicker_n if polarity == "n" else self.flicker_p


WHITE_ONLY = NoiseModel(0.0, 0.0)
"""Noise without flicker: what a run takes whose devices have thermal and shot noise alone."""

# Ours, unverified: no run of these lines publishes its noise. Textbooks give 1e-25 to 1e-23 V^2 F for nFETs
# and a tenth or less for buried pFETs of the 1.5 um generation; surface pFETs of 0.18 um come nearer.
_PUBLISHED_RANGE = NoiseModel(4e-24, 2e-25)
NOISE_MODELS = {"ami-1500": _PUBLISHED_RANGE, "rolls-180": NoiseModel(2e-24, 5e-25)}


def noise_model(process: Process) -> NoiseModel:
    """Flicker noise of a process, by its name; a process that the table lacks has the figures of 1.5 um."""
    return NOISE_MODELS.get(process.name, _PUBLISHED_RANGE)


def resistor_noise(resistance: F64, kelvin: float) -> F64:
    """White noise `4 k T / R` of each resistor, float64[n], A^2/Hz.

    resistance: float64[n], Ohm. kelvin: temperature, K.
    """
    return 4.0 * BOLTZMANN * kelvin / resistance


@compiled()
def channel_noise(a: TransistorArrays, w: TransistorWork, out: F64) -> None:
    """Fill `out`, float64[n], with the white density of every channel, A^2/Hz.

    a: the transistors' coefficients. w: what `drain_currents` left.
    """
    n = a.sign.size
    for i in range(n):
        forward, reverse = w.value[i], w.value[n + i]
        total = 0.0
        for j in range(CHANNEL_SHARE.size):
            x = reverse + (forward - reverse) * CHANNEL_SHARE[j]
            total -= CHANNEL_WEIGHT[j] * x * x * np.expm1(-x)
        scale = 8.0 * ELEMENTARY_CHARGE * a.specific_current[i] * w.factor[i]
        both = forward + reverse
        out[i] = scale * total / both if both > 0.0 else 0.0


@compiled()
def junction_noise(a: TransistorArrays, w: TransistorWork, out: F64) -> None:
    """Fill `out`, float64[2 n], with the shot noise of the drain junctions, then the source's, A^2/Hz.

    a: the transistors' coefficients. w: what `drain_currents` left.
    """
    n = a.sign.size
    for side in range(2):
        for i in range(n):
            both = 2.0 * w.leakage[side, i] - a.sign[i] * w.junction[side, i]
            out[side * n + i] = 2.0 * ELEMENTARY_CHARGE * both


@compiled()
def diode_noise(current: F64, out: F64) -> None:
    """Fill `out`, float64[n], with the shot noise `2 q |i|` of currents (A) through diodes, A^2/Hz."""
    for i in range(current.size):
        out[i] = 2.0 * ELEMENTARY_CHARGE * abs(current[i])


def gate_flicker(model: NoiseModel, process: Process, is_n: Bools, area: F64) -> F64:
    """Flicker noise of every gate voltage at 1 Hz, float64[n], V^2/Hz.

    is_n: bool[n], whether a transistor is an nFET. area: float64[n], m W L, m^2.
    """
    per_area = [model.flicker(p) / process.model(p).oxide_capacitance for p in ("n", "p")]
    return np.where(is_n, per_area[0], per_area[1]) / area
