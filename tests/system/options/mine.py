"""Files that a user might write, for tests of what a command is about."""

FOLLOWER = '''"""A follower-integrator."""
from typing import Annotated

from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.testbench import Testbench

PORTS = (Port("vdd", "supply"), Port("v_in", "analog"), Port("v_b", "bias"), Port("v_out", "analog", "out"))
BIASES = (Bias("i_b", "v_b", "gate", 10e-9, "tail"),)


def integrator(w: Annotated[float, "m"] = 6e-6, c_F=1e-12):
    """A transconductance amplifier that follows its input onto a capacitor."""
    devices = (
        Transistor("tail", "n", "v_s", "v_b", "0", "0", w, 3e-6),
        Transistor("plus", "n", "v_d", "v_in", "v_s", "0", w, 3e-6),
        Transistor("minus", "n", "v_out", "v_out", "v_s", "0", w, 3e-6),
        Transistor("diode", "p", "v_d", "v_d", "vdd", "vdd", w, 3e-6),
        Transistor("mirror", "p", "v_out", "v_d", "vdd", "vdd", w, 3e-6),
        Capacitor("c", "v_out", "0", c_F),
    )
    return Circuit("follower", PORTS, devices, biases=BIASES)


def follower(w: Annotated[float, "m"] = 6e-6, *, low_V=2.0, step_V=0.1, v_dd=5.0):
    """A follower-integrator after a step of its input."""
    step = PiecewiseLinear((0.0, 0.1e-3, 0.101e-3), (low_V, low_V, low_V + step_V))
    sources = (Source("vdd", "vdd", Constant(v_dd)), Source("v_in", "v_in", step))
    return Testbench("follower", integrator(w), sources, 1e-3)


CIRCUIT = integrator()
SHARED = (Bias("i_b", "v_b", "gate", 20e-9, "cell.tail"),)


def pair():
    """Two of them on a die."""
    array = CIRCUIT.array("cell", (2,), v_out="v_out")
    out = Port("v_out", "analog", "out", (2,))
    return Circuit("pair", (*PORTS[:3], out), (), (array,), biases=SHARED)


def broken():
    return 1 / 0


def other():
    return 3


def chatty():
    print("hello")
    return CIRCUIT


def sized(w):
    return integrator(w)
'''
