"""The standard normal draws behind a circuit's transistors on a die, with a label for each.

There are two for each transistor (V_T0 and beta) where the die has mismatch, and two for each polarity where
its process varies. The labels are those of `circuits.silicon.sampling`.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.lowering.flatten import FlatCircuit
from circuits.silicon.die import PARAMETERS, SHARED_PLACE, Die, Path, Place, standard_normals
from circuits.silicon.process import POLARITIES
from circuits.silicon.sampling import labels
from circuits.silicon.silicon import Silicon


def variation_labels(flat: FlatCircuit, silicon: Silicon) -> tuple[str, ...]:
    """Label of every standard normal that the silicon's die draws for the circuit."""
    return tuple(
        label
        for place, paths, parameter in _families(flat, silicon)
        for label in labels(place, paths, parameter)
    )


def variation_draws(flat: FlatCircuit, silicon: Silicon, die: Die) -> F64:
    """The standard normal draws of a die, float64[labels]; those of the nominal die are zero."""
    families = _families(flat, silicon)
    if die.number is None:
        return np.zeros(len(variation_labels(flat, silicon)))
    drawn = [standard_normals(die, place, paths, parameter) for place, paths, parameter in families]
    return np.concatenate([np.zeros(0), *drawn])


def _families(flat: FlatCircuit, silicon: Silicon) -> list[tuple[Place, list[Path], str]]:
    """Place, paths and parameter of what is drawn at once."""
    place = ((flat.circuit.name, ()),) if silicon.place is None else silicon.place
    groups = [g for g in flat.groups if isinstance(g.device, Transistor)]
    paths: list[Path] = [(*g.path, (g.device.name, ())) for g in groups]
    found: list[tuple[Place, list[Path], str]] = []
    if silicon.die.mismatch and paths:
        found += [(place, paths, parameter) for parameter in PARAMETERS]
    if silicon.die.process and silicon.die.corner == "random":
        found += [
            (SHARED_PLACE, [((polarity, ()),)], f"shared.{parameter}")
            for polarity in POLARITIES
            for parameter in PARAMETERS
        ]
    return found
