"""Tuning curves: the firing rate of each neuron as a function of its input current.

The leaky integrate-and-fire neuron of Stöckel 2017, section II.B,

    tau_rc du/dt = J - u,    u = 0 for tau_ref after u reaches 1,

fires at the rate 1 / (tau_ref - tau_rc ln(1 - 1 / J)) where J > 1. Neurons of silicon have measured curves:
any `Curves` can take the place of the ideal one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from circuits.arrays import F64

TAU_RC, TAU_REF = 0.02, 0.002  # s; nengo's, with which the paper simulates

_SLOWEST = 1e-9  # Hz, so that nothing is divided by 0


class Curves(Protocol):
    """Tuning curves of neurons, which are numbered from 0; a current of 1 is an ideal neuron's threshold."""

    def rates(self, first: int, current: F64) -> F64:
        """Return the rates of neurons from `first` on, Hz, float64[points, neurons].

        Parameters
        ----------
        first
            Number of the first neuron.
        current
            Currents in thresholds of an ideal neuron (dimensionless), float64[points, neurons].
        """

    def currents(self, first: int, rate: F64) -> F64:
        """Return the currents at which neurons from `first` on fire at rates, float64[neurons].

        They are in thresholds of an ideal neuron (dimensionless).

        Parameters
        ----------
        rate
            Rates, Hz, float64[neurons]; 0 Hz stands for the threshold.
        """


@dataclass(frozen=True, slots=True)
class IdealCurves:
    """Curves of leaky integrate-and-fire neurons that are all alike.

    Attributes
    ----------
    tau_rc : float
        Membrane time constant, s.
    tau_ref : float
        Refractory period, s.
    """

    tau_rc: float = TAU_RC
    tau_ref: float = TAU_REF

    def rates(self, first: int, current: F64) -> F64:
        """Return rates from neuron `first` on at a `current`, Hz, float64[points, neurons], as `Curves`."""
        above = np.maximum(current, 1.0 + 1e-15)
        rate = 1.0 / (self.tau_ref - self.tau_rc * np.log1p(-1.0 / above))
        return np.where(current > 1.0, rate, 0.0)

    def currents(self, first: int, rate: F64) -> F64:
        """Return the currents at which neurons from `first` on fire at a `rate`, Hz, float64[neurons].

        They are as `Curves` say, and NaN beyond 1 / tau_ref, which no current reaches.
        """
        charging = 1.0 / np.maximum(rate, _SLOWEST) - self.tau_ref
        reached = charging > 0.0
        found = -1.0 / np.expm1(-np.where(reached, charging, 1.0) / self.tau_rc)
        return np.where(rate > 0.0, np.where(reached, found, np.nan), 1.0)
