"""Capacitors and resistors as they are made on a die: the value of each, from the value that is drawn."""

from __future__ import annotations

from circuits.arrays import F64
from circuits.devices import Capacitor, Resistor
from circuits.devices.device import Device
from circuits.lowering.flatten import DeviceGroup
from circuits.silicon.passive import QUANTITY, Kind
from circuits.silicon.silicon import Change, Silicon


def kind_of(device: Device) -> Kind | None:
    """What kind of a passive device it is; None for any other."""
    if isinstance(device, Capacitor):
        return "capacitor"
    return "resistor" if isinstance(device, Resistor) else None


def change_of(group: DeviceGroup, kind: Kind, circuit: str, silicon: Silicon) -> Change:
    """Change of a group of capacitors or resistors of a circuit on the silicon's die."""
    path = (*group.path, (group.device.name, ()))
    return silicon.change(circuit, (path,), kind, group.parameters[QUANTITY[kind]])


def made(group: DeviceGroup, circuit: str, silicon: Silicon) -> F64:
    """Capacitances (F) or resistances (Ohm) of a group on the silicon's die, float64[count].

    Raises `TypeError` for a group of other devices.
    """
    kind = kind_of(group.device)
    if kind is None:
        raise TypeError(type(group.device).__name__)
    drawn = group.parameters[QUANTITY[kind]]
    value = change_of(group, kind, circuit, silicon).value
    return drawn if isinstance(value, float) else drawn * (1.0 + value)
