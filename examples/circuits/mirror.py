"""A pair of current mirrors: an nFET mirror, and the pFET mirror that turns its copy round.

noctule op mirror.py:drive
"""

from typing import Annotated

from circuits.api import Circuit, Port, Resistor, Testbench, current_into, mos, powered


def mirror(size: Annotated[float, "um"] = 6.0, gain: int = 1):
    """Two mirrors one behind the other; the load turns the copy into a voltage."""
    ports = (Port("vdd", "supply"), Port("i_in", "analog"), Port("v_out", "analog", "out"))
    devices = (
        mos("n_in", "n", "i_in", "i_in", "0", size, size),
        mos("n_out", "n", "v_mid", "i_in", "0", size, size),
        mos("p_in", "p", "v_mid", "v_mid", "vdd", size, size),
        *(mos(f"p_out{k}", "p", "v_out", "v_mid", "vdd", size, size) for k in range(gain)),
        Resistor("load", "v_out", "0", 100e6),
    )
    return Circuit("mirror", ports, devices)


def drive(
    size: Annotated[float, "um"] = 6.0, gain: int = 1, *, i_in: Annotated[float, "A"] = 10e-9, v_dd=5.0
):
    """A constant current into the first mirror."""
    return Testbench("mirror", mirror(size, gain), (*powered(v_dd), current_into("i_in", i_in)), stop=1e-3)
