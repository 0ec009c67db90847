"""The types of devices that circuits are made of, one in each file."""

from circuits.devices.capacitor import Capacitor
from circuits.devices.controlled_source import ControlledSource
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.devices.operational_amplifier import OperationalAmplifier
from circuits.devices.resistor import Resistor
from circuits.devices.source import Source
from circuits.devices.transistor import Transistor

DEVICE_TYPES: tuple[type[Device], ...] = (
    Transistor, Capacitor, Resistor, Diode, ControlledSource, OperationalAmplifier, Source,
)  # fmt: skip

__all__ = [
    "DEVICE_TYPES",
    "Capacitor",
    "ControlledSource",
    "Device",
    "Diode",
    "OperationalAmplifier",
    "Resistor",
    "Source",
    "Transistor",
]
