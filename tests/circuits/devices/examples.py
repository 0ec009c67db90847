"""A device of each type."""

from circuits import devices
from circuits.devices.source import Constant

EXAMPLES: dict[type[devices.Device], devices.Device] = {
    devices.Transistor: devices.Transistor("m", "n", "d", "g", "s", "0", 1e-6, 1e-6),
    devices.Capacitor: devices.Capacitor("c", "a", "b", 1e-12),
    devices.Resistor: devices.Resistor("r", "a", "b", 1e3),
    devices.Diode: devices.Diode("d", "a", "b", junction_capacitance=1e-12, breakdown_voltage=6.0),
    devices.ControlledSource: devices.ControlledSource("g", "a", "b", "c", "d", 1e-3),
    devices.OperationalAmplifier: devices.OperationalAmplifier("x", "p", "n", "o", "vdd"),
    devices.Source: devices.Source("v", "a", Constant(1.0)),
}
