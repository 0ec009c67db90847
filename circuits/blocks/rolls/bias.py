"""Biases of the ROLLS chip by their coarse and fine codes: `I = I_coarse fine / 256`.

The codes are the defaults of the chip's control software (mn256r1_ncs). Code 0 means off. A device that is
off is given the current of fine code 1 in the lowest range, 0.06 pA, which at 27 degC is the off current of a
device nine times as long as wide. A shorter one would need its gate beyond the rail, which no copy in the
bias generator reaches (`circuits.blocks.bias.generator`). So devices that a bias may turn off are that long
in these circuits.
"""

from __future__ import annotations

from collections.abc import Mapping

from circuits.circuit import Bias
from circuits.errors import ParameterError, unknown_name
from circuits.generator.code import COARSE, CODES

Code = tuple[int, int]  # coarse, fine
OFF_CURRENT = COARSE[-1] / CODES  # A

# Name: (coarse, fine); those of the neuron and of the non-plastic synapses. Found: mn256r1_ncs, as lists of
# its bias files; what each does in the circuits is in the blocks that use it.
DEFAULT_CODES: Mapping[str, Code] = {
    "IF_BUF_P": (0, 11),
    "IF_RFR1_N": (0, 255),
    "IF_RFR2_N": (4, 128),
    "IF_AHW_P": (7, 0),
    "IF_AHTAU_N": (7, 0),
    "IF_ATHR_N": (7, 0),
    "IF_DC_P": (1, 7),
    "IF_TAU1_N": (7, 40),
    "IF_TAU2_N": (5, 20),
    "IF_THR_N": (4, 255),
    "IF_NMDA_N": (7, 0),
    "NPA_PWLK_P": (3, 52),
    "NPA_WEIGHT_EXC_P": (3, 98),
    "NPA_WEIGHT_EXC0_P": (2, 127),
    "NPA_WEIGHT_EXC1_P": (2, 255),
    "NPA_WEIGHT_INH_N": (1, 100),
    "NPA_WEIGHT_INH0_N": (0, 201),
    "NPA_WEIGHT_INH1_N": (0, 255),
    "NPDPIE_TAU_P": (6, 244),
    "NPDPIE_THR_P": (6, 244),
    "NPDPII_TAU_P": (6, 255),
    "NPDPII_THR_P": (6, 244),
}


def current_of(code: Code) -> float:
    """Nominal current of a (coarse, fine) code at 27 degC, A; that of a device that is off for fine code 0.

    Raises `ParameterError` for a code outside 0 to 7 and 0 to 255.
    """
    coarse, fine = code
    if not (0 <= coarse < len(COARSE) and 0 <= fine < CODES):
        raise ParameterError(f"bias code: {coarse}, {fine}, must be coarse 0 to 7 and fine 0 to 255")
    return COARSE[coarse] * fine / CODES if fine else OFF_CURRENT


def default_current(name: str) -> float:
    """Current (A) of the default code that the lab software has for the bias called `name`.

    Raises `UnknownNameError` for a name that the software does not have.
    """
    if name not in DEFAULT_CODES:
        raise unknown_name("ROLLS bias", name, DEFAULT_CODES)
    return current_of(DEFAULT_CODES[name])


def gate_bias(name: str, code: Code | str, device: str) -> Bias:
    """The bias `i_{name}` of the port `v_{name}` into a device.

    code: a (coarse, fine) code, or the name of a bias of the lab software, which means its default code.
    device: path of the device. Raises `ParameterError` for a code outside 0 to 7 and 0 to 255, and
    `UnknownNameError` for a name that the software does not have.
    """
    current = default_current(code) if isinstance(code, str) else current_of(code)
    return Bias(f"i_{name}", f"v_{name}", "gate", current, device)
