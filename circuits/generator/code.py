"""Codes of the bias generator: a 3-bit coarse and an 8-bit fine code, `I = I_coarse fine / 256`.

A line can only have a current that a code has. Within a range codes are `I_coarse / 256` apart, and the
finest range that reaches a current is taken: a code is within half a step of it, which is 1.5 % where two
ranges meet, and within half a code of the least.

Source: codes and ranges from the control software of ROLLS (mn256r1_ncs).
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError

COARSE = (24e-6, 3.2e-6, 0.4e-6, 50e-9, 6.5e-9, 820e-12, 105e-12, 15e-12)  # A, of codes 0 to 7; facts
FINE_BITS = 8
CODES = 1 << FINE_BITS
_MOST = COARSE[0] * (CODES - 1) / CODES  # A
REFERENCE_C = 27.0  # degC at which the nominal generator gives these currents; ours


def codes_of(current: F64) -> I64:
    """Return the codes whose current is nearest to each (A), coarse and fine, int64[..., 2].

    The finest range that reaches a current is taken, and 59 fA for what is below the least. Raises
    `ParameterError` for a current that no code reaches.
    """
    wanted = np.asarray(current, dtype=np.float64)
    within = (wanted > 0.0) & (wanted <= _MOST)
    if not within.all():
        raise ParameterError(
            f"bias code: {wanted[~within].ravel()[0]:g} A, must be > 0 and at most {_MOST:.3g} A"
        )
    coarse = np.zeros(wanted.shape, dtype=np.int64)
    for k, amperes in enumerate(COARSE):
        coarse[wanted <= amperes * (CODES - 1) / CODES] = k
    fine = np.clip(np.rint(CODES * wanted / np.array(COARSE)[coarse]), 1, CODES - 1).astype(np.int64)
    return np.stack([coarse, fine], axis=-1)


def currents_of(codes: I64) -> F64:
    """Return the nominal currents of codes, A; codes: int64[..., 2]."""
    return np.asarray(np.array(COARSE)[codes[..., 0]] * codes[..., 1] / CODES)


def nearest_currents() -> F64:
    """Return the nominal currents, A, rising, of all codes that are the nearest to their own current."""
    every = np.stack(np.meshgrid(range(len(COARSE)), range(1, CODES), indexing="ij"), axis=-1).reshape(-1, 2)
    currents = currents_of(every)
    return np.asarray(np.sort(currents[(codes_of(currents) == every).all(axis=1)]))
