"""How the numbers of a transistor model follow a device's width and length.

A number P of a model becomes, for a device of width W and length L,

    P(W, L) = P + a / L + b / L^2 + c / W + d / (W L)

with coefficients a, b, c, d in P's unit times m, m^2, m and m^2. The mobility's are those of its logarithm,
`mu Cox(W, L) = mu Cox e^(a / L + ...)`, so that it stays above zero. Terms hold for the sizes to which they
were fitted: a device of another size is refused.

The form is that in which foundries write the size into binned cards (Cheng and Hu, "MOSFET modeling and BSIM3
user's guide", 1999, chapter 9, binning); the term in `1 / L^2` is ours, for channels that the ends shorten.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.checks import require_real
from circuits.errors import ParameterError

Coefficients = tuple[float, float, float, float]
NO_TERMS: Coefficients = (0.0, 0.0, 0.0, 0.0)
"""Coefficients of a number that all sizes share."""

FOLLOWING = (
    "v_t0", "kappa", "mu_cox", "early_field", "mobility_reduction", "v_t0_drift", "mobility_exponent",
)  # fmt: skip
"""Numbers of a `TransistorModel` that may follow the size."""
_BOX = ("least_width", "most_width", "least_length", "most_length")
_ROUNDING = 1e-9  # relative, by which a size may miss the box


@dataclass(frozen=True, slots=True)
class SizeTerms:
    """Coefficients by which numbers of a transistor model follow the size, and the sizes that they hold for.

    Attributes
    ----------
    least_width, most_width, least_length, most_length : float
        Sizes for which the terms hold, m.
    v_t0, kappa, mu_cox, early_field, mobility_reduction, v_t0_drift, mobility_exponent : tuple of float
        Coefficients of `1 / L`, `1 / L^2`, `1 / W` and `1 / (W L)`, in the number's unit times a power of m.

    Raises
    ------
    ParameterError
        The sizes are no range above zero, or a number has not four finite coefficients.
    """

    least_width: float
    most_width: float
    least_length: float
    most_length: float
    v_t0: Coefficients = NO_TERMS
    kappa: Coefficients = NO_TERMS
    mu_cox: Coefficients = NO_TERMS
    early_field: Coefficients = NO_TERMS
    mobility_reduction: Coefficients = NO_TERMS
    v_t0_drift: Coefficients = NO_TERMS
    mobility_exponent: Coefficients = NO_TERMS

    def __post_init__(self) -> None:
        for name in _BOX:
            require_real(f"size.{name}", getattr(self, name), "m")
        for axis in ("width", "length"):
            low, high = getattr(self, f"least_{axis}"), getattr(self, f"most_{axis}")
            if not 0.0 < low <= high:
                raise ParameterError(f"size.least_{axis}: {low:g} m, must be > 0 and at most {high:g} m")
        for name in FOLLOWING:
            given = tuple(getattr(self, name))
            if len(given) != len(NO_TERMS):
                raise ParameterError(f"size.{name}: {len(given)} coefficients, must be of 1/L 1/L^2 1/W 1/WL")
            for value in given:
                require_real(f"size.{name}", value, "SI")
            object.__setattr__(self, name, tuple(map(float, given)))

    def at(self, width: F64 | float, length: F64 | float) -> dict[str, Any]:
        """What each number gets for a device's size, float64 of the shape of width and length (m)."""
        across, along = (1.0 / np.asarray(side, dtype=np.float64) for side in (width, length))
        powers = (along, along**2, across, across * along)
        found: dict[str, Any] = {}
        for name in FOLLOWING:
            total = sum(c * p for c, p in zip(getattr(self, name), powers, strict=True))
            found[name] = total if across.ndim or along.ndim else float(total)
        return found

    def check(self, width: F64 | float, length: F64 | float, owner: str = "") -> None:
        """Raise `ParameterError` for a size (m) for which no terms hold; owner: path of the device."""
        for axis, value in (("width", width), ("length", length)):
            low, high = getattr(self, f"least_{axis}"), getattr(self, f"most_{axis}")
            sizes = np.atleast_1d(np.asarray(value, dtype=np.float64))
            out = sizes[(sizes < low * (1.0 - _ROUNDING)) | (sizes > high * (1.0 + _ROUNDING))]
            if out.size:
                name = f"{owner}.{axis}" if owner else axis
                raise ParameterError(
                    f"{name}: {1e6 * out[0]:g} um, must be within {1e6 * low:g} to {1e6 * high:g} um, the"
                    " sizes that this process was fitted to; change the size, or extract over a wider range"
                )

    def ideal(self) -> SizeTerms:
        """The same for a law without second-order effects."""
        return replace(self, early_field=NO_TERMS, mobility_reduction=NO_TERMS)


def to_numbers(terms: SizeTerms | None) -> tuple[float, ...]:
    """All numbers of terms in the order of their fields, each coefficient by itself; () for None."""
    if terms is None:
        return ()
    box = tuple(getattr(terms, name) for name in _BOX)
    return (*box, *(c for name in FOLLOWING for c in getattr(terms, name)))


def from_numbers(numbers: Sequence[float]) -> SizeTerms | None:
    """Terms of what `to_numbers` gave; raises `ValueError` for another count."""
    if not numbers:
        return None
    count = len(NO_TERMS)
    if len(numbers) != len(_BOX) + count * len(FOLLOWING):
        raise ValueError(f"{len(numbers)} numbers")
    rest = numbers[len(_BOX) :]
    terms: dict[str, Any] = {n: tuple(rest[count * k : count * k + count]) for k, n in enumerate(FOLLOWING)}
    low_w, high_w, low_l, high_l = numbers[: len(_BOX)]
    return SizeTerms(low_w, high_w, low_l, high_l, **terms)
