"""Bias currents of the teaching chip by their master and fine code: `I = w (fine / 256) I_master`.

w is what the biased device is worth of the generator's output device, a square of a third: `w = 3 W / L`.

Sources: masters, code and the output device of 4 um by 12 um are the laboratory's; that one rule holds for
all circuits, where its texts take other w for some, is what the chip's slew rates and slopes say.
"""

from __future__ import annotations

from circuits.checks import require_real
from circuits.circuit import Bias
from circuits.errors import ParameterError

MASTERS = (60e-12, 460e-12, 3.8e-9, 30e-9, 240e-9)  # A
CODES = 256
OUTPUT = (4.0, 12.0)  # um, of the generator's output device


def code_current(master: float, fine: float, width: float, length: float) -> float:
    """Nominal current of a code in a device, A.

    Parameters
    ----------
    master
        The coarse current, A: one of `MASTERS`.
    fine
        The fine code, a whole number from 0 to 255.
    width, length
        Size of the biased device, in one unit.

    Raises
    ------
    ParameterError
        The generator has no such master or no such code.
    """
    require_real("bias master", master, "A")
    require_real("bias fine code", fine, "")
    if master not in MASTERS:
        known = ", ".join(f"{each:g}" for each in MASTERS)
        raise ParameterError(f"bias master: {master:g} A, must be one of {known} A")
    if fine != int(fine) or not 0 <= fine < CODES:
        raise ParameterError(f"bias fine code: {fine:g}, must be a whole number from 0 to {CODES - 1}")
    return master * fine / CODES * (width / length) / (OUTPUT[0] / OUTPUT[1])


def coded_bias(name: str, master: float, fine: float, device: str, size: tuple[float, float]) -> Bias:
    """The bias `i_{name}` of the port `v_{name}`, at a code's current.

    Parameters
    ----------
    name
        What it biases.
    master, fine
        Its code: the coarse current, A, and a whole number from 0 to 255.
    device
        Path of the device that it biases.
    size
        Width and length of that device, um.

    Raises
    ------
    ParameterError
        The generator has no such code.
    """
    return Bias(f"i_{name}", f"v_{name}", "gate", code_current(master, fine, *size), device)
