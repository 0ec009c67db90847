"""A ring oscillator of inverters that are starved on both sides: its current sets its rate.

noctule simulate ring.py:run
"""

from typing import Annotated

from circuits.api import Bias, Capacitor, Circuit, Port, Testbench, mos, powered

STAGE = Circuit(
    "stage",
    (
        Port("vdd", "supply"),
        Port("v_n", "bias"),
        Port("v_p", "analog"),
        Port("a", "analog"),
        Port("y", "analog", "out"),
    ),
    (
        mos("sink", "n", "low", "v_n", "0", 6.0, 6.0),
        mos("down", "n", "y", "a", "low", 3.0, 1.5),
        mos("up", "p", "y", "a", "high", 6.0, 1.5),
        mos("source", "p", "high", "v_p", "vdd", 6.0, 6.0),
        Capacitor("c", "y", "0", 50e-15),
    ),
)


def ring(stages: int = 3):
    """An odd number of stages; a mirror copies the current of the sinks to the sources."""
    ports = (Port("vdd", "supply"), Port("v_n", "bias"), Port("v", "event", "out", (stages,)))
    mirror = (mos("copy", "n", "v_p", "v_n", "0", 6.0, 6.0), mos("diode", "p", "v_p", "v_p", "vdd", 6.0, 6.0))
    inside = (STAGE.instance(f"stage{k}", a=f"v[{k}]", y=f"v[{(k + 1) % stages}]") for k in range(stages))
    bias = Bias("i_b", "v_n", "gate", 200e-9, "copy")
    return Circuit("ring", ports, mirror, tuple(inside), biases=(bias,))


def run(stages: int = 3, *, duration: Annotated[float, "s"] = 30e-6, v_dd=5.0):
    """One stage is held at 0 V until time 0: the rest state is stable on some dies."""
    return Testbench("ring", ring(stages), powered(v_dd), duration, ("v[0]",), initial={"v[0]": 0.0})
