"""The axon-hillock neuron (Mead 1989): a current charges it, positive feedback fires it, its spike resets it.

noctule simulate axon_hillock.py:spike
"""

from typing import Annotated

from circuits.api import Bias, Capacitor, Circuit, Port, Testbench, current_into, inverter, mos, powered


def axon_hillock(membrane: Annotated[float, "F"] = 1e-12, feedback: Annotated[float, "F"] = 0.5e-12):
    """An amplifier of two inverters with capacitive feedback, and a reset of two transistors."""
    ports = (
        Port("vdd", "supply"),
        Port("i_in", "analog"),
        Port("v_pw", "bias"),
        Port("spike", "event", "out"),
    )
    devices = (
        Capacitor("c_mem", "i_in", "0", membrane),
        Capacitor("c_fb", "spike", "i_in", feedback),
        *inverter("first", "i_in", "v_a", width=3.0, length=1.5),
        *inverter("second", "v_a", "spike", width=3.0, length=1.5),
        mos("reset", "n", "i_in", "spike", "v_r", 6.0, 3.0),
        mos("width", "n", "v_r", "v_pw", "0", 6.0, 3.0),
    )
    bias = Bias("i_pw", "v_pw", "gate", 50e-9, "width")
    return Circuit("axon_hillock", ports, devices, biases=(bias,))


def spike(membrane: Annotated[float, "F"] = 1e-12, *, i_in: Annotated[float, "A"] = 1e-9, v_dd=5.0):
    """A constant current into the membrane, which begins at 0 V."""
    drive = (*powered(v_dd), current_into("i_in", i_in))
    return Testbench("axon_hillock", axon_hillock(membrane), drive, 20e-3, ("spike",), initial={"i_in": 0.0})
