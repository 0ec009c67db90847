"""The pinch-off voltage of a transistor with constant kappa, `v_p = kappa (v_g - V_T0)`.

It is what models take of the transistor's law (`circuits.devices.transistor`) before its interpolation
(`circuits.devices.ekv`): the voltage of a source at which the channel just carries its specific current.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64


def pinch_off(kappa: ArrayLike, gate: ArrayLike, threshold: ArrayLike) -> F64:
    """Return v_p (V), in the shape that the arguments broadcast to; over what `kappa` is over, such as U_T.

    gate, threshold: v_g and V_T0, V above the bulk (below it for a pFET).
    """
    height = np.asarray(gate, dtype=np.float64) - np.asarray(threshold, dtype=np.float64)
    return np.asarray(np.asarray(kappa, dtype=np.float64) * height)
