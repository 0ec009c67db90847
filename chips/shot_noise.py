"""White noise and flicker of a saturated transistor's current, over those that it has in weak inversion.

With `I = I_S L^2`, L = ln(1 + e^(u/2)), the channel's white density (`circuits.devices.noise`, without a
reverse component) and how steeply the current follows its gate are

    S = 2 q I phi(L),    phi = (4 / L^4) [L^3 / 3 - 2 + e^-L (L^2 + 2 L + 2)]
    d ln I / dv_G = (kappa / U_T) psi(L),    psi = (1 - e^-L) / L

both 1 in weak inversion, where L is small. A current that fills or empties a capacitor for a time T moves its
charge by `q phi I T`, in squares, and flicker moves the current by `psi kappa / U_T` of the mean of its
gate's wander over T.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from chips.noise import SiliconNoise, mean_variance
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices import ekv
from circuits.devices.channel import height_of, mobility, pinch_off_of
from circuits.devices.noise import gate_flicker
from circuits.silicon.process import Polarity, TransistorAtTemperature
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import relaxations

_WEAK = 0.05  # L below which three terms of the series are exact to 1e-5
_SHIFT = 1e-4  # V, of a derivative by the gate; ours
_FASTEST = 0.1  # of the shortest time: a grid up to whose band flicker is summed

_compiled = compiled()


@_compiled
def share_at(root: float) -> float:
    """Return phi, the white noise of a saturated current over that of weak inversion, at L = `root`."""
    if root < _WEAK:
        return 1.0 - 0.4 * root + root * root / 9.0
    e = math.exp(-root)
    return 4.0 / root**4 * (root**3 / 3.0 - 2.0 + e * (root * root + 2.0 * root + 2.0))


_shares = np.vectorize(share_at, otypes=[np.float64])


def shot_share(current: ArrayLike, specific: ArrayLike) -> F64:
    """Return phi of currents (A) in devices of these specific currents (A), in the shape of both."""
    return np.asarray(_shares(_root(current, specific)))


def steepness(current: ArrayLike, specific: ArrayLike) -> F64:
    """Return psi, how steeply a saturated current follows its gate beside weak inversion.

    current, specific: of the devices, A; the result has the shape of both.
    """
    return ekv.steepness(np.asarray(current, dtype=np.float64) / np.asarray(specific, dtype=np.float64))


def steepness_under(law: TransistorAtTemperature, current: ArrayLike, specific: ArrayLike) -> F64:
    """Return psi with body effect and mobility reduction in it, so that `psi kappa / U_T` is the slope.

    Parameters
    ----------
    law
        What the devices' polarity shares at its temperature; without these effects it is `steepness`.
    current, specific
        Currents and specific currents of the devices, A; the result has the shape of both.
    """
    if law.gamma == 0.0 and law.mobility_reduction == 0.0:
        return steepness(current, specific)
    share = np.asarray(current, dtype=np.float64) / np.asarray(specific, dtype=np.float64)
    height = height_of(law, law.u_t * ekv.argument(share))
    low, high = (_saturated(law, height + x) for x in (-_SHIFT, _SHIFT))
    return np.asarray(np.log(high / low) / (2.0 * _SHIFT) * law.u_t / law.kappa)


def _saturated(law: TransistorAtTemperature, height: F64) -> F64:
    """A saturated current over the specific one, at a gate's voltage (V) above V_T0."""
    pinch = pinch_off_of(law, height)
    return np.asarray(ekv.interpolation(pinch / law.u_t) * mobility(law, pinch))


def _root(current: ArrayLike, specific: ArrayLike) -> F64:
    return np.sqrt(np.asarray(current, dtype=np.float64) / np.asarray(specific, dtype=np.float64))


def gate_wander(
    silicon: Silicon, noise: SiliconNoise, polarity: Polarity, area: float, time: ArrayLike
) -> F64:
    """Return the variance (V^2) of the mean of a gate's flicker over a time (s), in the shape of the time.

    polarity, area: of the device, `m W L` in m^2.
    """
    length = np.asarray(time, dtype=np.float64)
    flicker = noise.flicker_in(silicon.process)
    rate, variance = relaxations(flicker, _FASTEST * float(length.min()))
    if rate.size == 0:
        return np.zeros(length.shape)
    is_n = np.array([polarity == "n"])
    at_gate = float(gate_flicker(flicker, silicon.process, is_n, np.array([area]))[0])
    return np.asarray(at_gate * (mean_variance(rate * length[..., None]) @ variance))


def current_wander(
    silicon: Silicon,
    noise: SiliconNoise,
    polarity: Polarity,
    area: float,
    time: ArrayLike,
    steep: ArrayLike = 1.0,
) -> F64:
    """Return the relative variance of the mean of a current over a time (s), by the flicker of its gate.

    polarity, area: of the device, `m W L` in m^2; steep: psi of the current, 1 in weak inversion.
    """
    slope = silicon.law(polarity).kappa / silicon.thermal_voltage * np.asarray(steep, dtype=np.float64)
    if not math.isfinite(float(np.max(slope))):
        return np.zeros(np.shape(time))
    return np.asarray(slope**2 * gate_wander(silicon, noise, polarity, area, time))
