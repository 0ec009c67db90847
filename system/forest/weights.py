"""Weights that depend on the speed setting, which Wen & Horiuchi 2022 suggest twice (section 4.1).

The ping-direction bias P, which harms slow bats and helps fast ones, is linear in V_MAX between the speeds of
the table and as at its ends beyond. Chosen on seeds below 1000 from P = 0, 1, 2, 3 at V_MAX = 1, 1.5, 2, 3, 4
m/s. There R_MAX0 = 7 m ("Flat") brought nothing at any of these speeds, so that R_MAX0 stays as it is.

============  =====  =====  ===================
V_MAX (m/s)   1      1.5    2
P             1.2    2.0    the bat's own, 2.45
============  =====  =====  ===================
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circuits.errors import ParameterError
from system.openspace.law import Bat

WEIGHTS = ("fixed", "speed")
SPEEDS = (1.0, 1.5, 2.0)  # m/s
PING_BIAS = (1.2, 2.0, 2.45)


def weighted(bat: Bat, weights: str) -> Bat:
    """A bat with its weights as they are, or by its V_MAX; raises `ParameterError` for no such kind."""
    if weights not in WEIGHTS:
        raise ParameterError(f"weights: {weights}, must be {' or '.join(WEIGHTS)}")
    if weights == "fixed":
        return bat
    return replace(bat, ping_bias=float(np.interp(bat.max_speed, SPEEDS, PING_BIAS)))
