"""Statistical corners: the die at a distance of k sigma on which a metric is highest, or lowest.

    z <- k g / |g|,     g = the metric's gradient on the last die,

until the direction stays. In the linear theory such a die has the metric k of its standard deviations from
the nominal one, and is the most probable of all that do; a corner of slow or fast transistors says nothing of
the sort.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError, SolverError
from circuits.silicon.die import Die
from circuits.silicon.edit import DEVIATIONS
from system.options.die.file import write_die_file
from system.study.search.slope import Slopes

_ROUNDS, _ALIKE = 6, 1e-3
_SHARED = ".shared"


@dataclass(frozen=True, slots=True, eq=False)
class StatisticalCorner:
    """A corner of a metric.

    metric : name of the metric.
    sigma : distance of the die; below 0 where the metric is low.
    point : draws of the die, float64[labels].
    value : the metric as it was measured on that die, in SI units.
    """

    metric: str
    sigma: float
    point: F64
    value: float


def corners(slopes: Slopes, sigma: float) -> tuple[StatisticalCorner, StatisticalCorner]:
    """Find the low and the high corner of a metric at a distance of `sigma`.

    Raises
    ------
    ParameterError
        The distance is not above 0, and at most 8.
    SolverError
        The metric has no gradient on the way, or one whose direction does not settle, or is not defined at a
        corner.
    """
    if not 0.0 < sigma <= 8.0:
        raise ParameterError(f"sigma: {sigma:g}, must be above 0 and at most 8; write as in 3")
    low, high = (_corner(slopes, sign * sigma) for sign in (-1.0, 1.0))
    return low, high


def _corner(slopes: Slopes, sigma: float) -> StatisticalCorner:
    z = np.zeros(len(slopes.labels))
    for _ in range(_ROUNDS):
        found = slopes.at(z)
        length = float(np.linalg.norm(found.by))
        if length == 0.0 and not z.any():
            raise SolverError(f"{slopes.metric}: nothing that varies on these dies moves it; name another")
        if not np.isfinite(length) or length == 0.0:
            raise SolverError(f"{slopes.metric}: has no gradient on the way; {found.note or 'name another'}")
        aim = sigma * found.by / length
        settled = float(np.linalg.norm(aim - z)) < _ALIKE * abs(sigma)
        z = aim
        if settled:
            break
    else:
        raise SolverError(
            f"{slopes.metric}: its gradient has another direction on each die at {sigma:+g} sigma, so that no"
            " corner is found; take a smaller distance, or sample plainly"
        )
    (value,) = slopes.values(z[None])
    if not np.isfinite(value):
        raise SolverError(f"{slopes.metric}: is not defined at {sigma:+g} sigma; take a smaller distance")
    return StatisticalCorner(slopes.metric, sigma, z, float(value))


def die_at(slopes: Slopes, point: F64) -> Die:
    """Give the die with some draws as the nominal die with every deviation set by hand.

    Raises
    ------
    ParameterError
        A draw moves several devices at once, as those of components of variation.
    """
    found = Die(slopes.die.lot, None, slopes.die.corner)
    for label, z, sigma in zip(slopes.labels, point, slopes.sigma, strict=True):
        owner, _, parameter = label.rpartition(".")
        if not np.isfinite(sigma) or parameter not in DEVIATIONS:
            raise ParameterError(
                f"variation: {label} is a component of variation, of which no die's file can be; take plain"
            )
        found = found.with_(owner.removesuffix(_SHARED), parameter, float(z * sigma))
    return found


def write_dies(folder: Path, slopes: Slopes, points: Iterable[tuple[str, F64]]) -> tuple[Path, ...]:
    """Write dies by their names into a folder, which is made, and give their paths."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ParameterError(f"output: {folder}, cannot be a folder; {error.strerror}") from None
    found = []
    for name, point in points:
        path = folder / f"{name}.toml"
        write_die_file(path, die_at(slopes, point))
        found.append(path)
    return tuple(found)
