"""Result and checks that the two methods for the probability of a rare failure share.

A die is a row z of independent standard normals; `fails(z)` says which of float64[n, d] rows fail, bool[n].
Scaled sigma (`scaled_sigma`) assumes nothing of where failures lie, but extrapolates; mean shift
(`mean_shift`) is unbiased, but must have found every region of failure.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError
from system.study.statistics.interval import Interval

Fails = Callable[[F64], Bools]


@dataclass(frozen=True, slots=True)
class RareFailure:
    """Probability of a failure with its interval.

    Attributes
    ----------
    method : str
        Method that estimated it, `mean-shift` or `scaled-sigma`.
    probability : float
        Estimated probability that a die fails.
    interval : Interval
        Confidence interval of the probability.
    samples : int
        Number of dies that were measured.
    effective_samples : float
        Number (sum w)^2 / sum w^2 over the weights w of the failing samples; NaN for an extrapolation.
    detail : str
        One line on how the method went.
    """

    method: str
    probability: float
    interval: Interval
    samples: int
    effective_samples: float
    detail: str


def check_budget(dimensions: int, samples: int, fewest: int) -> None:
    """Check the number of standard normals of a die, and the number of samples.

    Raises `ParameterError` for no dimension, and for fewer samples than the `fewest` that a method needs.
    """
    if dimensions < 1:
        raise ParameterError("rare failures: nothing varies, so there is no probability; leave mismatch on")
    if samples < fewest:
        raise ParameterError(f"samples: {samples}, must be >= {fewest} for a rare failure; take more")
