"""Gradients across a die: a plane a polarity and parameter, by which distant devices differ more.

    dP(x, y) = S (z_x x + z_y y)

with x and y from the die's centre (`circuits.silicon.floor_plan`) and two standard normals z a plane. Their
direction is uniform and their slope a Rayleigh draw. Two devices a distance D apart, in any direction, then
differ by a normal of `sigma = S D`, which is the distance term of Pelgrom (1989).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.silicon.die import (
    GRADIENT_PLACE,
    PARAMETERS,
    Die,
    Path,
    Place,
    components_of,
    note,
    standard_normals,
    unnoted,
)
from circuits.silicon.floor_plan import positions
from circuits.silicon.process import Polarity, Process

AXES = ("x", "y")


def gradient(
    die: Die, process: Process, place: Place, paths: Sequence[Path], polarities: Sequence[Polarity]
) -> tuple[F64, F64]:
    """What their place on the die adds to transistors: V_T0 (V) and relative beta, float64[places] each.

    Parameters
    ----------
    die
        The die.
    process
        Its process, which states components.
    place
        Where the circuit stands, ((chip, ()), (instance, index), ...).
    paths
        Paths of the transistors from there on; places are counted path after path, row-major.
    polarities
        Polarity of each path's transistor.

    Raises
    ------
    ParameterError
        The process states no components, or an index is outside of the chip's floor plan.
    """
    figures = components_of(process)
    counts = [int(np.prod([n for _, shape in path for n in shape], dtype=np.int64)) for path in paths]
    is_n = np.repeat(np.array([p == "n" for p in polarities], dtype=np.bool_), counts)
    x, y = positions(place, paths)
    planes = {polarity: _planes(die, polarity) for polarity in ("n", "p")}
    scales = figures.distance_v_t0, figures.distance_beta
    if unnoted(die) is not die:
        _note_planes(die, process, scales)
    v_t0, beta = (
        scale * np.where(is_n, n[0] * x + n[1] * y, p[0] * x + p[1] * y)
        for scale, n, p in zip(scales, planes["n"], planes["p"], strict=True)
    )
    return v_t0, beta


def slope_names() -> tuple[str, ...]:
    """Names of the draws behind the planes of a polarity."""
    return tuple(f"{axis}.{name}" for name in PARAMETERS for axis in AXES)


def _planes(die: Die, polarity: str) -> list[tuple[float, float]]:
    """Slopes in x and y, standard normals, of V_T0 and of beta."""
    x_v, y_v, x_b, y_b = (
        float(standard_normals(die, GRADIENT_PLACE, [((polarity, ()),)], name)[0]) for name in slope_names()
    )
    return [(x_v, y_v), (x_b, y_b)]


def _note_planes(die: Die, process: Process, scales: tuple[float, float]) -> None:
    """Keep the planes of a die whose draws are noted, V/m of V_T0 and 1/m of relative beta."""
    drawn = replace(die, edits=())
    for polarity in ("n", "p"):
        slopes = [
            scale * z for scale, plane in zip(scales, _planes(drawn, polarity), strict=True) for z in plane
        ]
        for name, slope in zip(slope_names(), slopes, strict=True):
            note(die, (GRADIENT_PLACE, (((polarity, ()),),), name), np.array([slope]), process)
