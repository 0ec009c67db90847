"""An amplifier of five transistors to sweep, which the tests of ngspice and a benchmark share."""

from circuits.circuit import Circuit, Port
from circuits.devices import Source, Transistor
from circuits.devices.source import Constant
from circuits.testbench import Testbench


def amplifier() -> Testbench:
    """Transconductance amplifier of five transistors at 1.8 V, biased at 0.35 V."""
    size = {"width": 4e-6, "length": 4e-6}
    devices = (
        Transistor("mb", "n", "tail", "vb", "0", "0", **size),
        Transistor("m1", "n", "x", "plus", "tail", "0", **size),
        Transistor("m2", "n", "out", "minus", "tail", "0", **size),
        Transistor("m3", "p", "x", "x", "vdd", "vdd", **size),
        Transistor("m4", "p", "out", "x", "vdd", "vdd", **size),
    )
    volts = {"vdd": 1.8, "plus": 0.9, "minus": 0.9, "vb": 0.35}
    ports = (Port("vdd", "supply"), *(Port(n, "analog") for n in ("plus", "minus", "vb", "out")))
    sources = tuple(Source(name, name, Constant(v)) for name, v in volts.items())
    return Testbench("amplifier", Circuit("amplifier", ports, devices), sources, 1.0)
