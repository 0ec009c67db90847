"""A follower-integrator: a transconductance amplifier that follows its input onto a capacitor.

noctule simulate follower.py:step
"""

from typing import Annotated

from circuits.api import Bias, Capacitor, Circuit, Port, Testbench, mos, powered
from circuits.blocks.drive import step as step_from


def follower(size: Annotated[float, "um"] = 6.0, load: Annotated[float, "F"] = 1e-12):
    """Five transistors and a capacitor; the bias is the tail's current."""
    ports = (
        Port("vdd", "supply"),
        Port("v_in", "analog"),
        Port("v_b", "bias"),
        Port("v_out", "analog", "out"),
    )
    devices = (
        mos("tail", "n", "v_s", "v_b", "0", size, size),
        mos("plus", "n", "v_d", "v_in", "v_s", size, size),
        mos("minus", "n", "v_out", "v_out", "v_s", size, size),
        mos("diode", "p", "v_d", "v_d", "vdd", size, size),
        mos("mirror", "p", "v_out", "v_d", "vdd", size, size),
        Capacitor("c", "v_out", "0", load),
    )
    return Circuit("follower", ports, devices, biases=(Bias("i_b", "v_b", "gate", 10e-9, "tail"),))


def step(size: Annotated[float, "um"] = 6.0, *, height: Annotated[float, "V"] = 0.02, v_dd=5.0):
    """Its answer to a step of the input from 2 V."""
    wave = step_from(0.1e-3, 0.101e-3, 2.0, 2.0 + height)
    return Testbench("follower", follower(size), powered(v_dd, {"v_in": wave}), stop=0.5e-3)
