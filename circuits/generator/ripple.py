"""A supply that moves: by how much the generator's lines follow it, over frequency.

The supply of a chip goes up and down by a sine about its value. A line follows by the circuit of its
generator on the die: the Early effect and the drain voltages of its mirrors, and those of the masters that it
has in common with others. All of it are small signals of the whole network, with the capacitances of its
transistors and the line's decoupling capacitor, which holds an nFET's line to ground and a pFET's to the
supply (`circuits.generator.solve.response_at`). What counts is by how much the gate-source voltage of the
biased device moves. Left out: what else hangs at a line, and gates of lines at the masters' diodes, which
make both slower; and the blocks that the lines bias, whose own supply stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from circuits.arrays import C128, F64
from circuits.errors import ParameterError
from circuits.generator.solve import response_at
from circuits.generator.voltage import (
    OFF,
    RANGES,
    Codes,
    Line,
    coded,
    lines_at_rest,
    masters_at_rest,
    resistor_of,
)
from circuits.silicon.silicon import Silicon

DECOUPLING = 10e-12  # F, capacitor at each line; ours


@dataclass(frozen=True, slots=True)
class Ripple:
    """A sine on a chip's supply.

    Attributes
    ----------
    amplitude : float
        Its peak, V.
    frequency : float
        Its frequency, Hz.

    Raises
    ------
    ParameterError
        One of them is not finite and above zero.
    """

    amplitude: float
    frequency: float

    def __post_init__(self) -> None:
        """Refuse what is no sine."""
        for name, value, unit in (
            ("amplitude", self.amplitude, "V"),
            ("frequency", self.frequency, "Hz"),
        ):
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(
                    f"ripple.{name}: {value:g} {unit}, must be > 0 and finite; write as in 10mV@50Hz"
                )

    def __str__(self) -> str:
        return f"{1e3 * self.amplitude:g} mV at {self.frequency:g} Hz"


def line_response(
    lines: Line, current: F64, silicon: Silicon, frequency: float, decoupling: float = DECOUPLING
) -> C128:
    """Return by how much gate-source voltages of biased devices follow the supply, V/V, complex128[lines].

    lines, current, silicon, and what it raises: as of `circuits.generator.voltage.line_voltages`; frequency:
    Hz, 0 for a supply that has moved for long; decoupling: capacitor at each line, F.
    """
    return _response(lines, coded(current), replace(silicon, place=lines.place), frequency, decoupling)


@lru_cache(maxsize=256)
def _masters(silicon: Silicon, frequency: float) -> dict[str, C128]:
    """What the nodes that lines share do on a silicon whose place is the chip's, V/V."""
    rest = masters_at_rest(silicon, resistor_of(silicon.process))
    moving = {"vdd": np.ones(1, np.complex128)}
    return response_at(rest, silicon, moving, (), frequency)


@lru_cache(maxsize=1024)
def _response(lines: Line, codes: Codes, silicon: Silicon, frequency: float, decoupling: float) -> C128:
    masters = _masters(silicon, frequency)
    rest = lines_at_rest(lines, codes, silicon, resistor_of(silicon.process))
    moving = {
        "vdd": np.ones(len(codes), np.complex128),
        "range_n": np.array([masters[RANGES[coarse]][0] for coarse, _ in codes]),
        OFF: np.full(len(codes), masters[OFF][0]),
    }
    found = response_at(rest, silicon, moving, _held(lines, decoupling), frequency)[lines.node]
    return np.asarray(found if lines.device.polarity == "n" else 1.0 - found)


def _held(lines: Line, decoupling: float) -> Sequence[tuple[str, str, float]]:
    return ((lines.node, "0" if lines.device.polarity == "n" else "vdd", decoupling),)
