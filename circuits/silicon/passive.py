"""Deviations of capacitors, resistors and diodes on a die.

    C = C_drawn (1 + s) (1 + A_C / sqrt(2 area) z),    area = C_drawn / capacitance_density
    R = R_drawn (1 + s)
    I_S = I_S,drawn (1 + s) (1 + A_S / sqrt(2 area) z),    area as the diode's model counts it

s is what all devices of a kind share on a die, z a draw of each. Capacitors and resistors deviate where a die
has all components of variation, diodes on every die of a process that states their figures. What stands on a
board is no part of the die (`circuits.silicon.floor_plan.BOARDS`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die, Path, Place, components_of, shared_relative, standard_normals
from circuits.silicon.edit import edited
from circuits.silicon.floor_plan import BOARDS
from circuits.silicon.process import Process
from circuits.silicon.sampling import labels

Kind = Literal["capacitor", "resistor", "diode"]
QUANTITY: dict[Kind, str] = {
    "capacitor": "capacitance", "resistor": "resistance", "diode": "saturation_current"
}  # fmt: skip
"""The parameter of each kind that deviates."""


def deviates(die: Die, place: Place) -> bool:
    """Whether capacitors and resistors of the circuit at a place deviate on a die."""
    varies = die.number is not None and die.variation == "full"
    return (varies or die.sets("capacitance", "resistance")) and place[0][0] not in BOARDS


def passive(
    die: Die, process: Process, place: Place, paths: Sequence[Path], kind: Kind, value: F64
) -> F64 | float:
    """Relative change of devices of a kind, float64[places], or 0 for none.

    Parameters
    ----------
    die
        The die.
    process
        Its process.
    place
        Where the circuit stands, ((chip, ()), (instance, index), ...).
    paths
        Paths of the devices from there on; places are counted path after path, row-major.
    kind
        What they are.
    value
        Their capacitance (F) or resistance (Ohm) as drawn, or the area of a diode, float64[places].

    Raises
    ------
    ParameterError
        The process states no components, or nothing is left of what is changed.
    """
    if kind == "diode":
        return _of_diodes(die, process, place, paths, value)
    if not deviates(die, place):
        return 0.0
    capacitor, varies = kind == "capacitor", die.number is not None and die.variation == "full"
    common, own = _shared(die, process, kind, varies=varies), np.zeros(value.shape)
    if capacitor and varies and die.mismatch:
        figures = components_of(process)
        single = figures.pair_a_capacitance * np.sqrt(0.5 * figures.capacitance_density / value)
        own = single * standard_normals(die, place, paths, QUANTITY[kind])
    return _together(die, place, paths, kind, common, own)


def _of_diodes(die: Die, process: Process, place: Place, paths: Sequence[Path], area: F64) -> F64 | float:
    """Relative change of the saturation currents of diodes, float64[places], or 0 for none."""
    figures, name = process.diodes, QUANTITY["diode"]
    drawn = figures is not None and die.number is not None
    if not (drawn or die.sets(name)) or place[0][0] in BOARDS:
        return 0.0
    common, own = 0.0, np.zeros(area.shape)
    if figures is not None:
        common = shared_relative(die, process, "diode", name, figures.sigma_saturation)
        if drawn and die.mismatch:
            single = figures.pair_a_saturation / np.sqrt(2.0 * area)
            own = single * standard_normals(die, place, paths, name)
    return _together(die, place, paths, "diode", common, own)


def _together(die: Die, place: Place, paths: Sequence[Path], kind: Kind, common: float, own: F64) -> F64:
    """What all of a kind share with what each has of its own after the die's edits, as one change."""
    changed = edited(die.edits, place, tuple(paths), QUANTITY[kind]) if die.edits else None
    if changed is not None:
        own = changed.of(own)
    whole = np.asarray((1.0 + common) * (1.0 + own) - 1.0) if own.any() else np.full(own.shape, common)
    if (whole <= -1.0).any():
        worst = int(np.argmin(whole))
        raise ParameterError(
            f"{labels(place, paths, QUANTITY[kind])[worst]}: changes by {100.0 * whole[worst]:.4g} % on"
            f" {die}, must be above -100 %; state a smaller deviation"
        )
    return whole


def _shared(die: Die, process: Process, kind: Kind, *, varies: bool) -> float:
    """Relative change of all devices of a kind together."""
    if not varies:
        return shared_relative(die, process, kind, QUANTITY[kind], 0.0)
    figures = components_of(process)
    sigma = figures.sigma_capacitance if kind == "capacitor" else figures.sigma_resistance
    return shared_relative(die, process, kind, QUANTITY[kind], sigma)
