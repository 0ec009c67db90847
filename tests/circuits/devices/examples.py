"""A device of each type."""

from circuits.devices import (
    Capacitor,
    ControlledSource,
    Device,
    OperationalAmplifier,
    Resistor,
    Source,
    Transistor,
)
from circuits.devices.source import Constant

EXAMPLES: dict[type[Device], Device] = {
    Transistor: Transistor("m", "n", "d", "g", "s", "0", 1e-6, 1e-6),
    Capacitor: Capacitor("c", "a", "b", 1e-12),
    Resistor: Resistor("r", "a", "b", 1e3),
    ControlledSource: ControlledSource("g", "a", "b", "c", "d", 1e-3),
    OperationalAmplifier: OperationalAmplifier("x", "p", "n", "o", "vdd"),
    Source: Source("v", "a", Constant(1.0)),
}
