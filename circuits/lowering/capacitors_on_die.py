"""Capacitors as they are on a die, for behavioural models, as `circuits.lowering.on_die` has transistors.

A model takes a capacitance as drawn from its circuit, and from here how far it is from that on a die, as the
transistor level has the same capacitor at the same place (`circuits.silicon.passive`). What transistors add
to a node does not deviate.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.devices import Capacitor
from circuits.errors import ParameterError
from circuits.lowering.on_die import DieDevices, device_names, paths_of, shape_of, site_of, spread
from circuits.silicon.die import Path
from circuits.silicon.passive import deviates
from circuits.silicon.silicon import Silicon


def capacitor_changes(
    circuit: Circuit, silicon: Silicon, wanted: Sequence[str], place: Path = ()
) -> dict[str, F64]:
    """Relative changes of capacitors of a circuit on the silicon's die, by name.

    Each is float64 of the shapes of the place and of the instance arrays inside the circuit, and 0 where the
    die's capacitors do not deviate.

    Parameters
    ----------
    circuit
        The circuit.
    silicon
        The silicon.
    wanted
        Names of capacitors (`membrane.c_r`: names of instances, then the device's).
    place
        Where the circuit stands, as of `circuits.lowering.on_die.on_die`; by itself unless given.

    Raises
    ------
    UnknownNameError
        The circuit lacks a name.
    ParameterError
        A name is that of no capacitor.
    """
    changes, _ = _changes(circuit, silicon, wanted, place)
    return changes


def added_capacitance(
    circuit: Circuit, silicon: Silicon, wanted: Sequence[str], place: Path = ()
) -> dict[str, F64]:
    """What capacitors of a circuit have on the silicon's die beyond what is drawn, F, by name.

    Arguments, shapes and errors are those of `capacitor_changes`.
    """
    changes, drawn = _changes(circuit, silicon, wanted, place)
    return {name: change * drawn[name].reshape(change.shape) for name, change in changes.items()}


def with_capacitors(
    d: DieDevices, circuit: Circuit, silicon: Silicon, place: Path = (), inside: str = ""
) -> DieDevices:
    """Return flat devices with the capacitors of their circuit, as `DieDevices.added` tells of them.

    They are as they were where there are none, or the die's do not deviate.

    Parameters
    ----------
    d
        Devices of the circuit on the silicon, flat.
    circuit, silicon, place
        As of `capacitor_changes`.
    inside
        Name of the instance array that the devices are in, whose capacitors are meant; all unless given.
    """
    names = [n for n in device_names(circuit, Capacitor) if n.startswith(f"{inside}." if inside else "")]
    if not names or not capacitors_deviate(circuit, silicon, place):
        return d
    added = added_capacitance(circuit, silicon, names, place)
    own = {name.removeprefix(f"{inside}."): np.ravel(x) for name, x in added.items()}
    return d._replace(more=own)


def _changes(
    circuit: Circuit, silicon: Silicon, wanted: Sequence[str], place: Path
) -> tuple[dict[str, F64], dict[str, F64]]:
    """Relative changes of capacitors in the shapes of their arrays, and what is drawn of each, F, flat."""
    sites = [site_of(circuit, name, capacitor_of(circuit, name)) for name in wanted]
    chip, paths = paths_of(circuit, sites, place)
    shapes = [shape_of(path) for path in paths]
    drawn = [spread(s.size["capacitance"], shape) for s, shape in zip(sites, shapes, strict=True)]
    change = silicon.change(chip, paths, "capacitor", np.concatenate([np.zeros(0), *drawn])).value
    ends = np.cumsum([x.size for x in drawn])
    each = np.split(np.broadcast_to(change, ends[-1] if ends.size else 0), ends[:-1])
    changes = {name: x.reshape(shape) for name, shape, x in zip(wanted, shapes, each, strict=True)}
    return changes, dict(zip(wanted, drawn, strict=True))


def capacitors_deviate(circuit: Circuit, silicon: Silicon, place: Path = ()) -> bool:
    """Whether capacitors of a circuit at a place deviate on the silicon's die."""
    chip = place[0][0] if place else circuit.name
    return deviates(silicon.die, silicon.place or ((chip, ()),))


def capacitor_of(circuit: Circuit, name: str) -> Capacitor:
    """The capacitor called `name`; raises `ParameterError` where that is another device."""
    device = circuit.device(name)
    if not isinstance(device, Capacitor):
        raise ParameterError(f"{circuit.name}.{name}: must be a capacitor; the model needs its capacitance")
    return device
