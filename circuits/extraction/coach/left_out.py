"""How well measurements are predicted that a fit has not seen: each is left out in turn.

Nothing is fitted anew. Near the minimum the fit's equations are linear in what is left out, so that the fit
without some points is one step of Gauss and Newton away:

    A' = A - J_L^T J_L,   dx = A'^-1 (J_L^T r_L - g),   r_L' = r_L + J_L dx,   var = J_L A'^-1 J_L^T + noise^2

with residuals r and their derivatives J in units of the noise, and the cost's derivative g at the fit of all.
At a minimum g is nothing. But a fit ends where its cost falls by little, and where a measurement's model is
rough, as that of a transient is, or a direction is nearly free, g is not nothing there. The noise of what is
left out is that of what stays: of the same column, or of its circuit's other measurements where the whole of
it is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.joint import Block, Fit

SIGMAS = 1.959964
"""Half of the band of 95 %, in standard deviations."""
FIFTH = 5  # every so manieth point of a curve is left out
_FEW = 3  # points that say how large a noise is

Key = tuple[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class LeftOut:
    """What was left out, and how it was predicted.

    Attributes
    ----------
    group : str
        What is left out together, as `fet_n_sat_vg` or `wta_iin_16cells cell 3`.
    key : tuple of str
        Measurement and column.
    points : array
        Which of the points that were fitted, by number, int64[n].
    off : array
        Measured less predicted, in units of the column's noise, float64[n].
    sd : array
        Standard deviation of that by what is not known and by noise, float64[n].
    """

    group: str
    key: Key
    points: I64
    off: F64
    sd: F64

    @property
    def inside(self) -> Bools:
        """Which points lie inside their band, bool[n]."""
        return np.asarray(np.abs(self.off) <= SIGMAS * self.sd)


def left_out(fit: Fit, conditions: Mapping[str, Condition]) -> Iterator[LeftOut]:
    """Leave out each transistor's sweep, each repeated calibration, each cell, every fifth of other points.

    Parameters
    ----------
    fit
        The fit of all.
    conditions
        What was set at its measurements, by name.
    """
    normal = _normal(fit)
    for group, parts in groups(fit, conditions).items():
        yield from _without(fit, conditions, normal, group, parts)


def groups(fit: Fit, conditions: Mapping[str, Condition]) -> dict[str, dict[Key, Bools]]:
    """What is left out together: points of columns, by a name."""
    found: dict[str, dict[Key, Bools]] = {}
    for key, block in fit.blocks.items():
        name, column = key
        whole = np.ones(block.residual.size, np.bool_)
        circuit = conditions[name].circuit
        if circuit in ("nfet", "pfet") or (circuit == "converter" and name.endswith(("_runA", "_runB"))):
            found.setdefault(name, {})[key] = whole
        elif circuit == "ring-inputs":
            found[f"{name} {column}"] = {key: whole}
        else:
            for k in range(FIFTH):
                some = np.arange(block.residual.size) % FIFTH == k
                if some.any():
                    found.setdefault(f"{name} fifth {k}", {})[key] = some
    return found


def _normal(fit: Fit) -> tuple[F64, F64]:
    """`J^T J` and `J^T r` of all that was fitted, and of what was known before, in units of that."""
    known = fit.posterior.unknowns
    before = np.array([(u.mean, u.sd) for u in known])
    information, slope = np.eye(len(known)), (fit.posterior.mean - before[:, 0]) / before[:, 1]
    for block in fit.blocks.values():
        information += block.jacobian.T @ block.jacobian
        slope = slope + block.jacobian.T @ block.residual
    return information, slope


def _without(
    fit: Fit, conditions: Mapping[str, Condition], normal: tuple[F64, F64], group: str,
    parts: dict[Key, Bools],
) -> Iterator[LeftOut]:  # fmt: skip
    information, slope = normal
    jacobian = np.concatenate([fit.blocks[key].jacobian[some] for key, some in parts.items()])
    residual = np.concatenate([fit.blocks[key].residual[some] for key, some in parts.items()])
    covariance = np.linalg.inv(information - jacobian.T @ jacobian)
    step = covariance @ (jacobian.T @ residual - slope)
    for key, some in parts.items():
        block = fit.blocks[key]
        own = block.jacobian[some]
        noise = _noise(fit, conditions, key, some)
        sd = np.sqrt(np.einsum("ij,jk,ik->i", own, covariance, own) + noise**2)
        yield LeftOut(
            group, key, np.flatnonzero(some).astype(np.int64), block.residual[some] + own @ step, sd
        )


def _noise(fit: Fit, conditions: Mapping[str, Condition], key: Key, some: Bools) -> float:
    """Noise of what is left out over that of the fit: by points of its column that stay, or by others."""
    stay = fit.blocks[key].residual[~some]
    if stay.size >= _FEW:
        return float(max(np.sqrt((stay**2).mean()), 0.5))
    circuit, column = conditions[key[0]].circuit, key[1]
    unit = column.rpartition("_")[2]
    others = [
        factor
        for other, factor in fit.factors.items()
        if other != key and conditions[other[0]].circuit == circuit and other[1].endswith(f"_{unit}")
    ]
    return float(np.median(others)) / fit.factors[key] if others else 1.0


def share_inside(found: list[LeftOut]) -> float:
    """Share of all points that lie inside their bands."""
    inside = np.concatenate([each.inside for each in found])
    return float(inside.mean())


def fitted_curve(block: Block, measured: F64, kept: Bools) -> tuple[F64, F64]:
    """The fit's own curve at the points that were fitted, and the noise there, in the column's unit."""
    return measured[kept] - block.residual * block.noise[kept], block.noise[kept]
