"""The standard normal draws behind a circuit's transistors on a die, with a label for each.

There are two for each transistor (V_T0 and beta) where the die has mismatch, those that biases stand on
included (`circuits.lowering.bias_moves`), and two for each polarity where its process varies. A die with
components of variation has more: four a polarity for its gradients, two for what a wafer shares, one for each
capacitor, and those of what all its capacitors and all its resistors share. A process that states figures of
its diodes has one for each diode and one for all of them. A lot's draws have no label here: dies of a study
are of one lot, so that nothing varies by them. The labels are those of `circuits.silicon.sampling`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.devices import Capacitor, Resistor, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.lowering.bias_moves import bias_families
from circuits.lowering.flatten import FlatCircuit
from circuits.silicon.components import AMI_1500_COMPONENTS
from circuits.silicon.die import (
    DIE_PLACE,
    GRADIENT_PLACE,
    LOT_PLACE,
    PARAMETERS,
    SHARED_PLACE,
    WAFER_PLACE,
    Die,
    Path,
    Place,
    standard_normals,
)
from circuits.silicon.floor_plan import BOARDS
from circuits.silicon.gradient import slope_names
from circuits.silicon.passive import QUANTITY, Kind
from circuits.silicon.process import POLARITIES, DiodeVariation
from circuits.silicon.sampling import labels
from circuits.silicon.silicon import Silicon

_NO_SPREAD = DiodeVariation(0.0, 0.0)  # of diodes as drawn


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


def variation_sigma(flat: FlatCircuit, silicon: Silicon) -> F64:
    """Standard deviation of what each draw moves, float64[labels], in V for thresholds and relative else.

    It is NaN for a draw of components of variation, which moves several devices or a capacitance.
    """
    process, diodes = silicon.process, silicon.process.diodes or _NO_SPREAD
    area = _areas(flat, Transistor, ("width", "length", "multiplicity"))
    pair = {"v_t0": process.pair_a_vt, "beta": process.pair_a_beta}
    own = {
        **{name: each / np.sqrt(2.0 * area) for name, each in pair.items()},
        QUANTITY["diode"]: diodes.pair_a_saturation / np.sqrt(2.0 * _areas(flat, Diode, ("area",))),
    }
    behind = {(each.place, each.paths): each.area for each in bias_families(flat.circuit, silicon)}
    shared = {
        "v_t0": process.variation.sigma_v_t0,
        "beta": process.variation.sigma_beta,
        QUANTITY["diode"]: diodes.sigma_saturation,
    }
    found = [np.zeros(0)]
    for place, paths, parameter in _families(flat, silicon):
        name = parameter.removeprefix("shared.")
        count = len(labels(place, paths, parameter))
        if (place, tuple(paths)) in behind:
            found.append(pair[parameter] / np.sqrt(2.0 * behind[place, tuple(paths)]))
        elif parameter in own:
            found.append(own[parameter])
        elif silicon.die.variation == "plain" and name in shared:
            found.append(np.full(count, shared[name]))
        else:
            found.append(np.full(count, np.nan))
    return np.concatenate(found)


def drawn_families(flat: FlatCircuit, silicon: Silicon) -> list[tuple[Place, list[Path], str]]:
    """List place, paths and parameter of all that a circuit can draw on any die, and that edits can set."""
    die, own = Die(silicon.die.lot, 0, variation="full"), silicon.process
    process = replace(own, diodes=own.diodes or _NO_SPREAD, components=own.components or AMI_1500_COMPONENTS)
    place, resistors = _place(flat, silicon), _paths(flat, Resistor)
    alone = [(place, resistors, QUANTITY["resistor"])] if resistors and place[0][0] not in BOARDS else []
    drawn = _families(flat, replace(silicon, die=die, process=process))
    levels = [
        (level, paths, name)
        for place, paths, name in drawn
        if place == SHARED_PLACE
        for level in (LOT_PLACE, DIE_PLACE)
    ]
    return [*drawn, *levels, *alone]


def _place(flat: FlatCircuit, silicon: Silicon) -> Place:
    return ((flat.circuit.name, ()),) if silicon.place is None else silicon.place


def _families(flat: FlatCircuit, silicon: Silicon) -> list[tuple[Place, list[Path], str]]:
    """Place, paths and parameter of what is drawn at once."""
    die, place = silicon.die, _place(flat, silicon)
    paths = _paths(flat, Transistor)
    found: list[tuple[Place, list[Path], str]] = []
    if die.mismatch and paths:
        found += [(place, paths, parameter) for parameter in PARAMETERS]
    if die.mismatch:
        behind = bias_families(flat.circuit, silicon)
        found += [(each.place, list(each.paths), name) for each in behind for name in PARAMETERS]
    if die.mismatch and paths and die.variation != "plain":
        found += [(GRADIENT_PLACE, [((p, ()),)], name) for p in POLARITIES for name in slope_names()]
    shared: list[tuple[str, str]] = [
        (polarity, parameter) for polarity in POLARITIES for parameter in PARAMETERS
    ]
    diodes = _paths(flat, Diode) if place[0][0] not in BOARDS else []
    if diodes and silicon.process.diodes is not None:
        found += [(place, diodes, QUANTITY["diode"])] if die.mismatch else []
        shared.append(("diode", QUANTITY["diode"]))
    if die.variation == "full" and place[0][0] not in BOARDS:
        kinds: dict[Kind, list[Path]] = {
            "capacitor": _paths(flat, Capacitor), "resistor": _paths(flat, Resistor)
        }  # fmt: skip
        if die.mismatch and kinds["capacitor"]:
            found.append((place, kinds["capacitor"], QUANTITY["capacitor"]))
        shared += [(kind, QUANTITY[kind]) for kind, there in kinds.items() if there]
    if die.process and die.corner == "random":
        levels = (SHARED_PLACE,) if die.variation == "plain" else (SHARED_PLACE, WAFER_PLACE)
        found += [
            (level, [((kind, ()),)], f"shared.{parameter}") for level in levels for kind, parameter in shared
        ]
    return found


def _areas(flat: FlatCircuit, kind: type[Device], sizes: tuple[str, ...]) -> F64:
    """Product of some sizes of all devices of a type, float64[devices]."""
    groups = [g for g in flat.groups if isinstance(g.device, kind)]
    each = [np.prod([g.parameters[name] for name in sizes], axis=0) for g in groups]
    return np.concatenate([np.zeros(0), *each])


def _paths(flat: FlatCircuit, kind: type[Device]) -> list[Path]:
    """Paths of all devices of a type."""
    return [(*g.path, (g.device.name, ())) for g in flat.groups if isinstance(g.device, kind)]
