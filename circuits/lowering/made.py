"""Capacitors, resistors and diodes as they are made on a die: each one's value, from what is drawn."""

from __future__ import annotations

from circuits.arrays import F64
from circuits.devices import Capacitor, Resistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.lowering.flatten import DeviceGroup
from circuits.silicon.passive import QUANTITY, Kind
from circuits.silicon.silicon import Change, Silicon

_KINDS: dict[type[Device], Kind] = {Capacitor: "capacitor", Resistor: "resistor", Diode: "diode"}


def kind_of(device: Device) -> Kind | None:
    """What kind of a device with one deviating value it is; None for any other."""
    return _KINDS.get(type(device))


def change_of(group: DeviceGroup, kind: Kind, circuit: str, silicon: Silicon) -> Change:
    """Change of a group of devices of a kind in a circuit on the silicon's die."""
    path = (*group.path, (group.device.name, ()))
    size = group.parameters["area" if kind == "diode" else QUANTITY[kind]]
    return silicon.change(circuit, (path,), kind, size)


def made(group: DeviceGroup, circuit: str, silicon: Silicon) -> F64:
    """Capacitances (F), resistances (Ohm) or saturation currents (A) on the silicon's die, float64[count].

    Raises `TypeError` for a group of other devices.
    """
    kind = kind_of(group.device)
    if kind is None:
        raise TypeError(type(group.device).__name__)
    drawn = group.parameters[QUANTITY[kind]]
    value = change_of(group, kind, circuit, silicon).value
    return drawn if isinstance(value, float) else drawn * (1.0 + value)
