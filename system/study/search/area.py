"""The area that each device should get for a wanted spread of a metric, at least total area.

A device's own deviations fall with the square root of its area (Pelgrom 1989), so that in the linear theory
the variance of a metric is

    s^2 = s_0^2 + sum over devices of v_i a_i / A_i,

where v_i is what transistor i adds at its area a_i, and s_0^2 is what no such area lessens: the process that
all share, diodes, whose area is in no unit of a transistor's, and gradients across the die. Of all areas with
s = S the least in total are, by a multiplier of Lagrange,

    A_i = sqrt(v_i a_i) sum_j sqrt(v_j a_j) / (S^2 - s_0^2).

No device is made smaller than a share of its own area: those that would be stay there, and the others are
found anew without them. Widths and lengths grow alike, so that currents stay; capacitances of gates and what
they do to the metric are left out, which is why the result is a prediction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import PARAMETERS
from circuits.units import format_quantity
from system.study.search.slope import Slope, Slopes
from system.study.statistics.contribution import device, kind


@dataclass(frozen=True, slots=True, eq=False)
class Matched:
    """Areas of devices.

    devices : name of each device with mismatch.
    variance : what each adds to the metric's variance, float64[devices], in the metric's unit squared.
    fixed : variance that no transistor's area lessens, in the same unit.
    area, wanted : area of each device, and the one that it should get, float64[devices], m^2.
    spread : standard deviation that the wanted areas give, in the metric's unit.
    """

    devices: tuple[str, ...]
    variance: F64
    fixed: float
    area: F64
    wanted: F64
    spread: float

    @property
    def spread_now(self) -> float:
        """Standard deviation at the areas that the devices have, in the metric's unit."""
        return math.sqrt(self.fixed + float(self.variance.sum()))


def matched(slopes: Slopes, slope: Slope, wanted: float, least: float) -> Matched:
    """Give the areas for a wanted spread.

    Parameters
    ----------
    slopes
        The metric.
    slope
        Its gradient about the nominal die.
    wanted
        The standard deviation that it should have over dies, in its unit.
    least
        Smallest share of its own area that a device may get, above 0.

    Raises
    ------
    ParameterError
        The spread is not above what no area lessens, there is no gradient, or no device has mismatch.
    """
    if not np.isfinite(slope.by).all():
        raise ParameterError(f"metric: {slopes.metric} has no gradient; {slope.note or 'name another'}")
    devices, variance, area = _by_device(slopes, slope)
    local = np.array([_lessened(*each) for each in zip(slopes.labels, slopes.sigma, strict=True)])
    fixed = float((slope.by[~local] ** 2).sum())
    if not wanted**2 > fixed:
        told = format_quantity(math.sqrt(fixed), _unit(slopes))
        others = any(kind(label) != "process" for label in np.array(slopes.labels)[~local])
        raise ParameterError(
            f"spread: {format_quantity(wanted, _unit(slopes))}, must be above {told}, which the process"
            f" {'and what is no transistor make' if others else 'alone makes'} and no area lessens; take the"
            " process out, or a larger spread"
        )
    found = least_areas(variance, area, wanted**2 - fixed, least)
    spread = math.sqrt(fixed + float((variance * area / found).sum()))
    return Matched(devices, variance, fixed, area, found, spread)


def least_areas(variance: F64, area: F64, wanted: float, least: float) -> F64:
    """Areas of least total, float64[devices], m^2, at which devices add a wanted variance.

    Parameters
    ----------
    variance
        Variance that each device adds at its area, float64[devices].
    area
        Area of each, float64[devices], m^2.
    wanted
        The variance that all should add together, in the unit of `variance`.
    least
        Smallest share of its own area that a device may get.
    """
    root, found, free = np.sqrt(variance * area), least * area, np.ones(len(area), np.bool_)
    for _ in range(len(area)):
        left = wanted - float((variance * area / found)[~free].sum())
        if not free.any() or left <= 0.0:
            break
        found[free] = root[free] * root[free].sum() / left
        small = free & (found < least * area)
        if not small.any():
            break
        found[small], free = (least * area)[small], free & ~small
    return found


def scaled_rows(slopes: Slopes, found: Matched, rows: F64) -> F64:
    """Draws of dies, float64[n, labels], of devices that have the wanted areas."""
    factor = dict(zip(found.devices, np.sqrt(found.area / found.wanted), strict=True))
    return np.asarray(rows * np.array([factor.get(device(label), 1.0) for label in slopes.labels]))


def _by_device(slopes: Slopes, slope: Slope) -> tuple[tuple[str, ...], F64, F64]:
    """Devices, the variance that each adds, and their areas, m^2."""
    pair = slopes.target.choice.silicon.process.pair_a_vt
    variance: dict[str, float] = {}
    area: dict[str, float] = {}
    for label, by, sigma in zip(slopes.labels, slope.by, slopes.sigma, strict=True):
        if _lessened(label, float(sigma)):
            variance[device(label)] = variance.get(device(label), 0.0) + float(by) ** 2
            if label.endswith(".v_t0"):
                area[device(label)] = 0.5 * (pair / float(sigma)) ** 2
    if not area:
        raise ParameterError("metric: no device varies, so none can be matched; leave mismatch on")
    return tuple(area), np.array([variance[d] for d in area]), np.array(list(area.values()))


def _lessened(label: str, sigma: float) -> bool:
    """Whether a draw is a transistor's own, which its area lessens; sigma: NaN of what moves several."""
    return math.isfinite(sigma) and kind(label) != "process" and label.rpartition(".")[2] in PARAMETERS


def _unit(slopes: Slopes) -> str:
    return next(q.limit_unit for q in slopes.target.quantities if q.name == slopes.metric)


def order(found: Matched) -> Sequence[int]:
    """Devices in the order of what they add to the variance, the most first."""
    return [int(k) for k in np.argsort(-found.variance, kind="stable")]
