"""Numbers of a transistor model by least squares from measured or simulated drain currents.

The residuals are `ln(law / current)`, the law that of the solver (`circuits.devices.transistor`): an error
of 10 % counts alike at 100 pA and at 10 uA. The loss is soft beyond 5 % (`soft_l1`), so that corners in
which the law has no term do not bend the rest. What the points do not fix is not fitted: terms of the length
need several lengths, and so on (`terms_for`). Every fitted number has its standard error, from the Jacobian
at the end and the spread of the residuals.

A number of a model and its term of the size are called as in `v_t0`, `v_t0 1/L`, `v_t0 1/WL`; the unit of
length within a fit is 1 um, so that all steps are of one order.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.devices.transistor import drain_currents, transistor_arrays, transistor_work
from circuits.errors import ParameterError
from circuits.extraction.points import Points
from circuits.silicon.process import Process, TransistorModel, at_temperature
from circuits.silicon.size import FOLLOWING, NO_TERMS, SizeTerms

optimise = later("scipy.optimize")

SOFT = 0.05
"""Relative error beyond which a residual counts less than its square; ours."""
_UM = 1e-6
_POWERS = {" 1/L": (0, _UM), " 1/L2": (1, _UM**2), " 1/W": (2, _UM), " 1/WL": (3, _UM**2)}
# a step of a number that is neither nothing nor all of it; ours
_SCALE = {
    "v_t0": 0.1, "kappa": 0.05, "mu_cox": 0.3, "early_field": 3e6, "early_rise": 0.1,
    "mobility_reduction": 0.1, "v_t0_drift": 1e-4, "mobility_exponent": 0.1, "surface_potential": 0.1,
}  # fmt: skip
# the Early effect is kept from standing in for a slope: 1 V/um, and twice the rise of a measured chip; ours
_LEAST = {"early_rise": 0.0, "mobility_reduction": 0.0, "early_field": 1e6, "kappa": 0.3,
          "surface_potential": 0.3}  # fmt: skip
_MOST = {"kappa": 0.97, "surface_potential": 1.5, "early_rise": 0.3}
_LENGTH, _WIDTH = (" 1/L", " 1/L2"), (" 1/W",)
_TERMS = {
    "v_t0": (*_LENGTH, *_WIDTH, " 1/WL"), "mu_cox": (*_LENGTH, *_WIDTH, " 1/WL"), "kappa": (" 1/L", " 1/W"),
    "mobility_reduction": (" 1/L", " 1/W"), "v_t0_drift": (" 1/L", " 1/W"), "mobility_exponent": (" 1/L",),
    "early_field": (" 1/L",),
}  # fmt: skip
_FAR = 50.0  # residual where numbers make no law


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A fitted model.

    model: the model. names: what was fitted. values, errors: each number and its standard error,
    float64[names], SI; those of `mu_cox` are of its logarithm. correlation: of the fitted numbers' errors,
    float64[names, names]. free: numbers that the points do not fix: they stay as they were. limited: numbers
    that ended at a limit of what is sought.
    """

    model: TransistorModel
    names: tuple[str, ...]
    values: F64
    errors: F64
    correlation: F64
    free: tuple[str, ...]
    limited: tuple[str, ...] = ()


def fit(
    points: Points, start: TransistorModel, process: Process, names: Sequence[str] | None = None
) -> Fitted:
    """Fit numbers of a model to drain currents.

    Parameters
    ----------
    points
        Currents of one polarity.
    start
        The model to begin with; what is not fitted stays as it is.
    process
        Its nominal temperature and supply count.
    names
        What is fitted; all that the points fix unless given.

    Raises
    ------
    ParameterError
        Fewer points than numbers, or an unknown name.
    """
    chosen = terms_for(points) if names is None else tuple(names)
    known = _all_terms()
    for name in chosen:
        if name not in known:
            raise ParameterError(f"fit: {name}, must be one of {', '.join(known)}")
    if len(points) <= len(chosen):
        raise ParameterError(
            f"fit: {len(points)} points for {len(chosen)} numbers, must be more; measure more"
        )
    first = replace(start, size=_no_terms(points) if any(_power(n) for n in chosen) else start.size)

    def error(x: F64) -> F64:
        try:
            found = law_current(_changed(first, chosen, x), process, points)
        except (ParameterError, OverflowError):
            return np.full(len(points), _FAR)
        ratio = np.log(np.maximum(found, 1e-300) / points.current)
        return np.asarray(np.nan_to_num(np.clip(ratio, -_FAR, _FAR), nan=_FAR))

    bounds = _bounds(first, chosen)
    with np.errstate(all="ignore"):
        solved = optimise.least_squares(
            error, np.zeros(len(chosen)), bounds=bounds, loss="soft_l1", f_scale=SOFT
        )
    model = _changed(first, chosen, solved.x)
    errors, correlation = _uncertainty(solved.jac, solved.fun)
    steps = np.array([_step(name) for name in chosen])
    values = np.array([_value(model, name) for name in chosen])
    free = tuple(name for name in known if name not in chosen)
    limited = tuple(name for name, side in zip(chosen, solved.active_mask, strict=True) if side)
    return Fitted(model, chosen, values, errors * steps, correlation, free, limited)


def law_current(model: TransistorModel, process: Process, points: Points) -> F64:
    """The law's drain current at points, A, float64[n], with the junction's leakage.

    Parameters
    ----------
    model
        The model, of the polarity of the points.
    process
        Its nominal temperature and supply count.
    points
        Where the currents are wanted.
    """
    found = np.empty(len(points))
    for celsius in np.unique(points.temperature_c):
        here = points.temperature_c == celsius
        n = int(here.sum())
        volts = (points.v_d[here], points.v_g[here], points.v_s[here], np.zeros(n))
        terminal = np.arange(4 * n, dtype=np.int32).reshape(4, n)
        law = at_temperature(model, process, float(celsius))
        arrays = transistor_arrays(
            terminal, "n", law, points.width[here], points.length[here], np.ones(n)
        )  # mirrored, a pFET is an nFET
        work = transistor_work(n)
        drain_currents(arrays, np.concatenate(volts), work)
        found[here] = work.current + work.junction[0]
    return found


def terms_for(points: Points) -> tuple[str, ...]:
    """Numbers that points fix: terms of a length need three lengths, those of the temperature two."""
    lengths, widths, temperatures, sources, drains = (
        np.unique(x).size for x in (points.length, points.width, points.temperature_c, points.v_s, points.v_d)
    )
    found = ["v_t0", "kappa", "mu_cox", "mobility_reduction"]
    found += ["v_t0_drift", "mobility_exponent"] if temperatures > 1 else []
    found += ["surface_potential"] if sources > 1 else []
    found += ["early_field", "early_rise"] if drains > 1 else []
    allowed = [*(_LENGTH if lengths > 2 else ()), *(_WIDTH if widths > 2 else ())]
    allowed += [" 1/WL"] if lengths > 2 and widths > 2 else []
    more = [n + power for n in found for power in _TERMS.get(n, ()) if power in allowed]
    return (*found, *more)


def _all_terms() -> tuple[str, ...]:
    return (*_SCALE, *(name + power for name, powers in _TERMS.items() for power in powers))


def _no_terms(points: Points) -> SizeTerms:
    w, along = points.width, points.length
    return SizeTerms(float(w.min()), float(w.max()), float(along.min()), float(along.max()))


def _power(name: str) -> str:
    return next((power for power in _POWERS if name.endswith(power)), "")


def _step(name: str) -> float:
    """What 1 of a fit's unknown is of a number, SI."""
    power = _power(name)
    return _SCALE[name.removesuffix(power)] * (_POWERS[power][1] if power else 1.0)


def _bounds(model: TransistorModel, names: Sequence[str]) -> tuple[list[float], list[float]]:
    """Bounds of the unknowns: of numbers that have a least or a most."""
    low = [(_LEAST[n] - getattr(model, n)) / _SCALE[n] if n in _LEAST else -math.inf for n in names]
    high = [(_MOST[n] - getattr(model, n)) / _SCALE[n] if n in _MOST else math.inf for n in names]
    tiny = 1e-9  # a fit begins within its bounds
    return [min(x, -tiny) for x in low], [max(x, tiny) for x in high]


def _changed(model: TransistorModel, names: Sequence[str], x: F64) -> TransistorModel:
    """The model with its fitted numbers `x` steps from where it began."""
    plain: dict[str, Any] = {}
    terms: dict[str, list[float]] = {n: list(getattr(model.size, n, NO_TERMS)) for n in FOLLOWING}
    for name, value in zip(names, x.tolist(), strict=True):
        power, step = _power(name), value * _step(name)
        if power:
            terms[name.removesuffix(power)][_POWERS[power][0]] += step
        elif name == "mu_cox":
            plain[name] = model.mu_cox * math.exp(step)
        else:
            plain[name] = round(getattr(model, name) + step, 12)  # a bound is met to the digit
    size = model.size
    if size is not None:
        coefficients: dict[str, Any] = {n: tuple(values) for n, values in terms.items()}
        size = replace(size, **coefficients)
    return replace(model, **plain, size=size)


def _value(model: TransistorModel, name: str) -> float:
    power = _power(name)
    if power:
        return float(getattr(model.size, name.removesuffix(power))[_POWERS[power][0]])
    return math.log(model.mu_cox) if name == "mu_cox" else float(getattr(model, name))


def _uncertainty(jacobian: F64, residual: F64) -> tuple[F64, F64]:
    """Standard errors of the unknowns and their correlation, by the residuals' spread."""
    n, k = jacobian.shape
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * float(residual @ residual) / max(n - k, 1)
    errors = np.sqrt(np.diag(covariance))
    scale = np.where(errors > 0.0, errors, 1.0)
    return errors, covariance / np.outer(scale, scale)


@dataclass(frozen=True, slots=True)
class Distance:
    """How far a law is off currents.

    Attributes
    ----------
    median, worst : float
        Median of |law / current - 1|, and law / current - 1 of the farthest ratio: -90 % is a tenth, and
        farther than +800 %.
    where : mapping of str to float
        Voltages (V), temperature (degC) and current (A) of the worst point.
    points : int
        How many points.
    """

    median: float
    worst: float
    where: Mapping[str, float]
    points: int


def distance(model: TransistorModel, process: Process, points: Points) -> Distance:
    """How far the law is off points; raises `ParameterError` for no points."""
    if not len(points):
        raise ParameterError("points: none in the range of currents; take a wider one")
    ratio = law_current(model, process, points) / points.current
    off, k = ratio - 1.0, int(np.argmax(np.abs(np.log(np.maximum(ratio, 1e-300)))))
    names = ("temperature_c", "v_d", "v_g", "v_s", "current")
    return Distance(
        float(np.median(np.abs(off))),
        float(off[k]),
        {n: float(getattr(points, n)[k]) for n in names},
        len(points),
    )
