"""Small circuits with known answers that several of the solver's tests share."""

from __future__ import annotations

from collections.abc import Mapping

from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Device, Resistor, Source, Transistor
from circuits.devices.source import Constant, Waveform
from circuits.testbench import Testbench

UM = 1e-6
R, C = 1e3, 1e-9
TAU = R * C  # 1 us
V_DD = 5.0
SUPPLY = Source("vdd", "vdd", Constant(V_DD))


def low_pass(waveform: Waveform, stop: float, *, watch: bool = False) -> Testbench:
    """R from `a` to `y`, C from `y` to ground; `a` driven."""
    ports = (Port("a", "analog"), Port("y", "event", "out"))
    circuit = Circuit("low_pass", ports, (Resistor("r", "a", "y", R), Capacitor("c", "y", "0", C)))
    return Testbench("low pass", circuit, (Source("a", "a", waveform),), stop, ("y",) if watch else ())


def inverter(name: str, a: str, y: str, width: float = 6.0) -> tuple[Device, ...]:
    """An inverter between `vdd` and ground; `width` of its pFET in um."""
    return (
        Transistor(f"{name}p", "p", y, a, "vdd", "vdd", width * UM, 1.5 * UM),
        Transistor(f"{name}n", "n", y, a, "0", "0", 3 * UM, 1.5 * UM),
    )


def latch(start: Mapping[str, float] | None = None, width: float = 6.0) -> Testbench:
    """Two inverters in a ring, nodes `a` and `b`; `width` of the pFET that drives `b` in um."""
    devices = (*inverter("i", "a", "b", width), *inverter("j", "b", "a"))
    circuit = Circuit("latch", (Port("vdd", "supply"),), devices)
    return Testbench("latch", circuit, (SUPPLY,), 1e-6, start=start or {})


def neuron(stop: float | None = None, **stimuli: float | None) -> Testbench:
    """The rebound neuron with a call at 1 ms and an echo 6.4 ms later."""
    values = {"delay": 6.4e-3, "call": 1.0, "echo": 1.0, "duration": stop, **stimuli}
    return rebound_neuron.testbench(rebound_neuron.build(), values, V_DD)
