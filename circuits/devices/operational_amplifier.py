"""Operational amplifier with finite gain, output resistance, and rails at its supplies.

Its open output voltage `v_t = v_mid + h tanh(A (v_p - v_n + v_os) / h)` saturates at the rails, with `v_mid =
(v_dd + v_ss) / 2` and `h = (v_dd - v_ss) / 2`, and the output delivers `(v_t - v_out) / R_o`. The tanh keeps
the derivative continuous at the rails (ours). The amplifier has no dynamics of its own: its speed comes from
what loads the output. The supplies carry the output current: a current that flows out is drawn from v_dd and
one that flows in enters v_ss, each by the smooth share `(1 +- tanh) / 2` (ours). Without a supply h stays at
1 uV.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from circuits.arrays import F64, I32
from circuits.compiled import compiled
from circuits.devices.device import Device, require_finite, require_positive

TERMINALS = 5
LEAST_HEADROOM = 1e-6  # V, keeps the law finite while a solver passes unpowered states


@dataclass(frozen=True, slots=True)
class OperationalAmplifier(Device):
    """An operational amplifier between its supplies.

    Attributes
    ----------
    positive, negative : str
        Nodes of the inputs.
    output : str
        Node of the output.
    vdd, vss : str
        Nodes of the supplies.
    gain : float
        Open-loop gain, V/V.
    output_resistance : float
        Resistance of the output, Ohm.
    offset : float
        Input offset voltage, V.

    Raises
    ------
    ParameterError
        Gain or resistance is not above zero, or the offset is not finite.
    """

    name: str
    positive: str
    negative: str
    output: str
    vdd: str
    vss: str = "0"
    gain: float = 1e5
    output_resistance: float = 100.0
    offset: float = 0.0

    def terminals(self) -> tuple[str, ...]:
        """The nodes positive, negative, output, vdd and vss."""
        return self.positive, self.negative, self.output, self.vdd, self.vss

    def parameters(self) -> Mapping[str, float]:
        """The gain (V/V), output resistance (Ohm) and offset (V)."""
        return {"gain": self.gain, "output_resistance": self.output_resistance, "offset": self.offset}

    def check(self) -> None:
        """Raise `ParameterError` unless gain and output resistance are above zero and the offset finite."""
        require_positive(self, "gain", "V/V")
        require_positive(self, "output_resistance", "Ohm")
        require_finite(self, "offset", "V")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """Direct current flows between the output and either supply."""
        return ((2, 3), (2, 4))


@compiled()
def amplifier_currents(terminal: I32, value: F64, v: F64, current: F64, slope: F64) -> None:
    """Fill in the currents into the terminals of n amplifiers, and their derivatives.

    terminal: int32[5, n], positions of the terminals in `v`. value: float64[3, n], gain (V/V), output
    resistance (Ohm) and offset (V). v: float64[nodes], V. current: float64[5, n], A, into the device at each
    terminal. slope: float64[5, 5, n], S, where `slope[i, j] = d current[i] / d v[terminal[j]]`.
    """
    for k in range(terminal.shape[1]):
        gain, conductance = value[0, k], 1.0 / value[1, k]
        v_out, v_dd, v_ss = v[terminal[2, k]], v[terminal[3, k]], v[terminal[4, k]]
        half = 0.5 * (v_dd - v_ss)
        d_h = 0.5 if half > LEAST_HEADROOM else 0.0
        half = max(half, LEAST_HEADROOM)
        drive = gain * (v[terminal[0, k]] - v[terminal[1, k]] + value[2, k])
        u = drive / half
        th = math.tanh(u)
        se = 1.0 - th * th
        d_in = gain * se
        # d(h tanh(drive / h))/dh, with dh/dv_dd = -dh/dv_ss = d_h
        d_half = th - u * se
        i_out = conductance * (v_out - 0.5 * (v_dd + v_ss) - half * th)
        up = 0.5 * (1.0 + th)
        d_up = 0.5 * se / half
        g0, g3, g4 = (
            -conductance * d_in,
            -conductance * (0.5 + d_h * d_half),
            -conductance * (0.5 - d_h * d_half),
        )
        u0, u3 = d_up * gain, -d_up * u * d_h
        current[0, k] = 0.0
        current[1, k] = 0.0
        current[2, k] = i_out
        current[3, k] = -up * i_out
        current[4, k] = -i_out - current[3, k]  # what flows in flows out, to a rounding of any size
        for j in range(TERMINALS):
            slope[0, j, k] = 0.0
            slope[1, j, k] = 0.0
        slope[2, 0, k] = g0
        slope[2, 1, k] = -g0
        slope[2, 2, k] = conductance
        slope[2, 3, k] = g3
        slope[2, 4, k] = g4
        slope[3, 0, k] = -up * g0 - i_out * u0
        slope[3, 1, k] = up * g0 + i_out * u0
        slope[3, 2, k] = -up * conductance
        slope[3, 3, k] = -up * g3 - i_out * u3
        slope[3, 4, k] = -up * g4 + i_out * u3
        for j in range(TERMINALS):
            slope[4, j, k] = -slope[2, j, k] - slope[3, j, k]
