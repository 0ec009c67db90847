"""Deviations of capacitors and resistors on a die.

    C = C_drawn (1 + s) (1 + A_C / sqrt(2 area) z),    area = C_drawn / capacitance_density
    R = R_drawn (1 + s)

s is what all capacitors of a die share, or all its resistors, z a draw of each capacitor. What stands on a
board is no part of the die (`circuits.silicon.floor_plan.BOARDS`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.silicon.die import Die, Path, Place, components_of, shared_relative, standard_normals
from circuits.silicon.edit import edited
from circuits.silicon.floor_plan import BOARDS
from circuits.silicon.process import Process

Kind = Literal["capacitor", "resistor"]
QUANTITY: dict[Kind, str] = {"capacitor": "capacitance", "resistor": "resistance"}
"""The parameter of each kind that deviates."""


def deviates(die: Die, place: Place) -> bool:
    """Whether capacitors and resistors of the circuit at a place deviate on a die."""
    varies = die.number is not None and die.variation == "full"
    return (varies or die.sets(*QUANTITY.values())) and place[0][0] not in BOARDS


def passive(
    die: Die, process: Process, place: Place, paths: Sequence[Path], kind: Kind, value: F64
) -> F64 | float:
    """Relative change of capacitors or resistors, float64[places], or 0 for none.

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
        Whether they are capacitors or resistors.
    value
        Their capacitance (F) or resistance (Ohm) as drawn, float64[places].

    Raises
    ------
    ParameterError
        The process states no components.
    """
    if not deviates(die, place):
        return 0.0
    capacitor, varies = kind == "capacitor", die.number is not None and die.variation == "full"
    common, own = _shared(die, process, kind, varies=varies), np.zeros(value.shape)
    if capacitor and varies and die.mismatch:
        figures = components_of(process)
        single = figures.pair_a_capacitance * np.sqrt(0.5 * figures.capacitance_density / value)
        own = single * standard_normals(die, place, paths, QUANTITY[kind])
    changed = edited(die.edits, place, tuple(paths), QUANTITY[kind]) if die.edits else None
    if changed is not None:
        own = changed.of(own)
    return np.asarray((1.0 + common) * (1.0 + own) - 1.0) if own.any() else np.full(value.shape, common)


def _shared(die: Die, process: Process, kind: Kind, *, varies: bool) -> float:
    """Relative change of all devices of a kind together."""
    if not varies:
        return shared_relative(die, process, kind, QUANTITY[kind], 0.0)
    figures = components_of(process)
    sigma = figures.sigma_capacitance if kind == "capacitor" else figures.sigma_resistance
    return shared_relative(die, process, kind, QUANTITY[kind], sigma)
