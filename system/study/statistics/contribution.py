"""Shares of a metric's variance by device, parameter or block, which sum to 1.

From gradients: with g_i the change of the metric (or of its logarithm) with one sigma of parameter i, and
y_hat = sum g_i z_i over the samples,

    share_i = R^2 g_i^2 / sum g^2,    unexplained = 1 - R^2,    R^2 = 1 - Var(y - y_hat) / Var(y)

R^2 needs no adjustment, for nothing is fitted. A regression on the same samples checks the shares; where R^2
is below 0.9 and samples suffice it takes their place: linear if that explains 0.9, else with squares and
interactions (`regression`), half of an interaction to each of its parameters.

A name is a label of `circuits.silicon.sampling`, a path with the parameter last: `chip.neuron[2].mi5.v_t0`,
`process.n.shared.v_t0`. Anything else that varied, such as `temperature`, has a name without a dot and a
column that the caller standardised (`standardise`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.plot import COLOURS, INK, PALE
from system.study.statistics.regression import Fit, enough, fit_linear, fit_quadratic

if TYPE_CHECKING:
    from matplotlib.axes import Axes

patheffects = later("matplotlib.patheffects")

Model = Literal["gradients", "linear", "quadratic"]
Key = Callable[[str], str]

UNEXPLAINED = "unexplained"
ENOUGH_R2 = 0.9
_PROCESS = re.compile(r"(process|wafer)\.(n|p|capacitor|resistor|diode|foundry)\.(?:shared\.)?(\w+)")


@dataclass(frozen=True, slots=True)
class VarianceShare:
    """Share of the variance that one device, parameter or block contributes.

    name : name of the contributor, or `unexplained`.
    value : share, from 0 to 1.
    """

    name: str
    value: float


@dataclass(frozen=True, slots=True, eq=False)
class Contributions:
    """Shares of a metric's variance, which with the unexplained part sum to 1.

    Attributes
    ----------
    names : tuple of str
        Label of each of the p parameters.
    values : array
        Share of each parameter, float64[p].
    model : Model
        Model that the shares come from.
    samples : int
        Number of samples at which the metric is defined.
    r2 : float
        Share of the variance that the model explains, R^2.
    linear : float
        Share of the variance that linear terms explain, a part of `r2`.
    squares : float
        Share that squares explain, a part of `r2`.
    interactions : float
        Share that products of two parameters explain, a part of `r2`.
    check : float or None
        Largest difference to the shares of a linear regression; None where that was not made.
    note : str
        Warning of too few samples, or of variance that the model does not explain; empty without
        either.
    """

    names: tuple[str, ...]
    values: F64
    model: Model
    samples: int
    r2: float
    linear: float
    squares: float
    interactions: float
    check: float | None
    note: str

    @property
    def unexplained(self) -> float:
        """Share of the variance that the model does not explain."""
        return 1.0 - float(self.values.sum())


def contributions(names: Sequence[str], z: F64, y: F64, gradient: F64 | None = None) -> Contributions:
    """Divide the variance of the response y among the parameters of the samples.

    Parameters
    ----------
    names
        Label of each parameter.
    z
        float64[n, p], standard normals of the samples.
    y
        float64[n], the metric or its logarithm; samples where it is not finite are left out.
    gradient
        float64[p], change of y with each z at the nominal die, in the unit of y; None if it is not known.

    Raises
    ------
    ParameterError
        Shapes do not fit, or samples are too few for a regression where there is no gradient.
    """
    if z.shape != (len(y), len(names)) or (gradient is not None and gradient.shape != (len(names),)):
        raise ParameterError(f"contributions: {z.shape} normals, must be samples {len(y)} by {len(names)}")
    defined = np.isfinite(y)
    z, y = z[defined], y[defined]
    linear = fit_linear(z, y) if gradient is None or enough(*z.shape) else None
    if gradient is not None:
        r2, values = _from_gradient(z, y, gradient)
        if r2 >= ENOUGH_R2 or linear is None:
            return _of_gradient(names, values, r2, len(y), linear)
    return _of_regression(names, z, y, linear or fit_linear(z, y))


def standardise(column: F64) -> F64:
    """Scale a factor to mean 0 and variance 1 over the samples, float64[n].

    It is for factors that are no draws, such as the temperature. A constant factor becomes 0.
    """
    sigma = float(column.std())
    return (column - column.mean()) / sigma if sigma > 0.0 else np.zeros_like(column)


def device(name: str) -> str:
    """Give the device of a label, as `chip.neuron[2].mi5`.

    The label of a process parameter gives its process, as `process.n`, or `wafer.n` for the part of a wafer;
    a name without a dot gives itself.
    """
    process = _PROCESS.fullmatch(name)
    return ".".join(process.groups()[:2]) if process else name.rpartition(".")[0] or name


def parameter(name: str) -> str:
    """Give the parameter of a label, as `v_t0` of a device.

    The label of a process parameter gives `process.n.v_t0`; a name without a dot gives itself.
    """
    process = _PROCESS.fullmatch(name)
    return ".".join(process.groups()) if process else name.rpartition(".")[2]


def block(name: str) -> str:
    """Give the block of a label, which is its path without device and parameter.

    The label of a process parameter gives `process`; a name without a dot gives itself.
    """
    if _PROCESS.fullmatch(name):
        return "process"
    owner = device(name)
    return owner.rpartition(".")[0] or owner


def kind(name: str) -> str:
    """Give the kind of a factor: `mismatch`, `process`, or its own name, such as `temperature`."""
    if _PROCESS.fullmatch(name):
        return "process"
    return "mismatch" if "." in name else name


def grouped(found: Contributions, key: Key) -> tuple[VarianceShare, ...]:
    """Add up the shares of the labels for which `key` gives the same name.

    The largest share comes first and the unexplained part last. The shares sum to 1.
    """
    sums: dict[str, float] = {}
    for name, value in zip(found.names, found.values, strict=True):
        sums[key(name)] = sums.get(key(name), 0.0) + float(value)
    ordered = sorted(sums.items(), key=lambda item: (-item[1], item[0]))
    return (*(VarianceShare(*item) for item in ordered), VarianceShare(UNEXPLAINED, found.unexplained))


def percentages(shares: Sequence[VarianceShare], decimals: int = 1) -> tuple[float, ...]:
    """Round shares to percentages with `decimals` digits that sum to 100 as printed.

    The shares with the largest remainders are rounded up.
    """
    scaled = np.array([share.value for share in shares]) * 100.0 * 10.0**decimals
    whole = np.floor(scaled)
    missing = round(float(scaled.sum() - whole.sum()))
    whole[np.argsort(whole - scaled, kind="stable")[:missing]] += 1.0
    return tuple(round(float(v) / 10.0**decimals, decimals) for v in whole)


def pareto(shares: Sequence[VarianceShare], ax: Axes, most: int = 12) -> None:
    """Draw shares as horizontal bars, the largest on top, with their running sum.

    Shares beyond the `most` largest are drawn as one bar.
    """
    *explained, rest = shares
    shown, others = explained[:most], explained[most:]
    if len(others) == 1:
        shown, others = explained, []
    if others:
        shown = [*shown, VarianceShare(f"{len(others)} others", sum(share.value for share in others))]
    bars = [*shown, rest]
    percent = percentages(bars)
    places = np.arange(len(bars))
    colours = [COLOURS[0]] * (len(shown) - bool(others)) + [COLOURS[5]] * bool(others) + [PALE]
    ax.barh(places, percent, color=colours)
    ax.plot(np.cumsum(percent), places, color=INK, marker="o", markersize=3, linewidth=1.0)
    for place, value in zip(places, percent, strict=True):
        text = ax.annotate(f"{value:.1f}", (value, place), (5, 0), textcoords="offset points", va="center")
        text.set(fontsize=7, path_effects=[patheffects.withStroke(linewidth=2.0, foreground="white")])
    ax.set_yticks(places, [share.name for share in bars])
    ax.invert_yaxis()
    ax.set_xlim(0.0, 105.0)
    ax.set_xlabel("share of the variance, and running sum (%)")


def _from_gradient(z: F64, y: F64, gradient: F64) -> tuple[float, F64]:
    power, left = gradient**2, y - z @ gradient
    whole, total = float(power.sum()), float(y.var()) if len(y) > 1 else 0.0
    r2 = max(0.0, 1.0 - float(left.var()) / total) if total > 0.0 and whole > 0.0 else 0.0
    return r2, power * (r2 / whole) if whole > 0.0 else np.zeros(len(power))


def _of_gradient(
    names: Sequence[str], values: F64, r2: float, samples: int, linear: Fit | None
) -> Contributions:
    if linear is None:
        check, note = None, f"{samples} samples for {len(names)} parameters: too few to check by regression"
    else:
        check, note = float(np.abs(values - linear.linear).max(initial=0.0)), ""
    if r2 < ENOUGH_R2:
        note += f"; R^2 {r2:.2f} and too few for a regression"
    return Contributions(tuple(names), values, "gradients", samples, r2, r2, 0.0, 0.0, check, note)


def _of_regression(names: Sequence[str], z: F64, y: F64, linear: Fit) -> Contributions:
    model: Model = "linear"
    fit, note = linear, ""
    if linear.r2 < ENOUGH_R2:
        model, fit = "quadratic", fit_quadratic(z, y)
    if fit.r2 < ENOUGH_R2:
        note = f"R^2 {fit.r2:.2f}: part of the variance is of a higher order"
    linear_part, squares, interactions = (
        float(part.sum()) for part in (fit.linear, fit.squares, fit.interactions)
    )
    values = fit.by_parameter()
    return Contributions(
        tuple(names), values, model, len(y), fit.r2, linear_part, squares, interactions, None, note
    )
