"""Bias lines of the teaching chip: a master, a fine code, and the output device of either type.

    I = s_m (T / T_0) I_master sum_b (1 + e_b) w_b 2^b / 256

A line of type N is the gate of a diode-connected nFET of 4 um by 12 um that carries I, and one of type P that
of a pFET. So a line biases a device of any size by the ratio of its shape to that, and one of the other type
parks a gate: P with code 0 is at the supply, N with code 0 at ground.

w_b are what the splitter's bits are worth; e_b what each line's own splitter deviates on a die, by the area
of its unit devices, `kappa dV_T / U_T` and the deviation of beta; the output device deviates too. s_m is a
master's scale, which nobody has measured.

Source: w_b relative to bits 2 to 4 is what calibrations of one chip show: bits 5 and 6 4 to 7 % and 4 to 10 %
low, bits 0 and 1 5 to 18 % high; the middle of each is taken, and bit 7 is not known. The unit device of the
splitter, 1 um by 6 um, is ours.

The generator of a chip that was identified (`chips.coach.identified`) has lines of their own, and the rule by
which it was identified: a line is the gate at which a device of the biased one's size carries its current.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Literal, NamedTuple, get_args

import numpy as np

from circuits.bias import deviating_gate_voltage
from circuits.blocks.bench.bias import CODES, MASTERS, OUTPUT, code_current
from circuits.checks import require_choice
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.lowering.on_die import DieDevices, on_die
from circuits.silicon.die import Path
from circuits.silicon.process import Polarity, kelvin
from circuits.silicon.silicon import Silicon

Kind = Literal["N", "P"]
BITS = (1.12, 1.05, 1.0, 1.0, 1.0, 0.945, 0.93, 1.0)
IDEAL_BITS = (1.0,) * 8
CHIP = "coach"
REFERENCE_C = 27.0  # degC
_UNIT = 1e-6, 6e-6  # m, width and length of the splitter's unit device
_UM = 1e-6


@dataclass(frozen=True, slots=True)
class Code:
    """What a bias is set to.

    kind: type of its output device, `N` or `P`. master: the coarse current, A, one of the five masters. fine:
    the fine code, 0 to 255.

    Raises `ParameterError` for a type, master or code that the generator does not have.
    """

    kind: Kind
    master: float
    fine: int

    def __post_init__(self) -> None:
        require_choice("bias type", self.kind, get_args(Kind))
        code_current(self.master, self.fine, *OUTPUT)


@dataclass(frozen=True, slots=True)
class Generator:
    """What a chip's generator has beside its devices' deviations.

    Attributes
    ----------
    bits
        What each bit is worth of its nominal current, from bit 0 to bit 7.
    scale
        Of a master's current by its nominal one, A; 1 for those that are left out.
    lines
        What each bit of a line is worth, by the line's name; `bits` for those that are left out.
    factors
        Of the current of a line, by its name; 1 for those that are left out.
    codes
        Of the current of a line at a master (A) and fine code, by that of bits that are worth what they
        should; for those that are left out it follows from their bits.
    reference
        Device at whose gate voltage a line is: the generator's output device, or one of the biased device's
        size.
    """

    bits: tuple[float, ...] = BITS
    scale: Mapping[float, float] = field(default_factory=dict)
    lines: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)
    codes: Mapping[tuple[str, float, int], float] = field(default_factory=dict)
    reference: Literal["output", "biased"] = "output"

    def __post_init__(self) -> None:
        """Refuse another number of bits, and scales of masters that are none."""
        for name, bits in {"bits": self.bits, **self.lines}.items():
            if len(bits) != 8:
                raise ParameterError(f"generator.{name}: {len(bits)}, must be eight; bit 0 is first")
        for master in self.scale:
            code_current(master, 0, *OUTPUT)


def line_current(generator: Generator, name: str, code: Code, silicon: Silicon) -> float:
    """Current in the output device of the line `name` on a silicon, A; 0 for fine code 0."""
    warm = kelvin(silicon.temperature_c) / kelvin(REFERENCE_C)
    scale = generator.scale.get(code.master, 1.0) * warm
    return scale * code.master * line_share(generator, name, code, silicon)


def line_share(generator: Generator, name: str, code: Code, silicon: Silicon) -> float:
    """What the line `name` takes of its master's current on a silicon; 0 for fine code 0."""
    law, own = silicon.law("n"), generator.codes.get((name, code.master, code.fine))
    bits = generator.lines.get(name, generator.bits) if own is None else IDEAL_BITS
    share, devices = 0.0, _devices(silicon, name, "n")
    for bit, worth in enumerate(bits):
        if code.fine >> bit & 1:
            v_t0, beta = devices.own(f"bit{bit}")
            error = (1.0 + beta) * math.exp(-law.kappa * v_t0 / law.u_t)
            share += worth * error * 2.0**bit / CODES
    return share * generator.factors.get(name, 1.0) * (1.0 if own is None else own)


def line_voltage(
    generator: Generator, name: str, code: Code, silicon: Silicon, biased: Transistor | None = None
) -> float:
    """Voltage of a line on a silicon, V, within ground and the supply.

    Parameters
    ----------
    generator
        The generator.
    name
        The line's name.
    code
        What it is set to.
    silicon
        Process, temperature and die.
    biased
        The transistor whose gate it is, where that is one.
    """
    polarity: Polarity = "n" if code.kind == "N" else "p"
    v_dd, current = silicon.process.v_dd, line_current(generator, name, code, silicon)
    above = 0.0
    if current > 0.0:
        own, output = _devices(silicon, name, polarity).own("output"), _output(polarity)
        if generator.reference == "biased" and biased is not None and biased.polarity == polarity:
            current *= biased.square / output.square
            output = biased
        above = deviating_gate_voltage(silicon.law(polarity), output, current, own)
    above = min(max(above, 0.0), v_dd)
    return above if polarity == "n" else v_dd - above


def _output(polarity: Polarity) -> Transistor:
    bulk = "0" if polarity == "n" else "vdd"
    return Transistor("output", polarity, "v", "v", bulk, bulk, OUTPUT[0] * _UM, OUTPUT[1] * _UM)


class _Line(NamedTuple):
    """Devices of a line on a die."""

    found: DieDevices

    def own(self, device: str) -> tuple[float, float]:
        """Deviations of V_T0 (V) and of beta of one of them."""
        fet = self.found.fet[device]
        return float(np.ravel(fet.v_t0)[0]), float(np.ravel(fet.beta)[0])


@lru_cache(maxsize=256)
def _devices(silicon: Silicon, line: str, polarity: Polarity) -> _Line:
    """The splitter's bits, each of as many unit devices as it is worth, and the output device; kept."""
    unit = Transistor("unit", "n", "v", "v", "0", "0", *_UNIT)
    bits = (replace(unit, name=f"bit{k}", multiplicity=2.0**k) for k in range(len(BITS)))
    circuit = Circuit("bias_line", (), (*bits, _output(polarity)))
    place: Path = ((CHIP, ()), ("bias generator", ()), (line, ()))
    return _Line(on_die(circuit, replace(silicon, place=place[:1]), place=place))


def master_named(text: str) -> float:
    """The master that a text names, as `460pA`, A. Raises `ParameterError` for one that there is not."""
    names = {"60pA": MASTERS[0], "460pA": MASTERS[1], "3.8nA": MASTERS[2], "30nA": MASTERS[3]}
    names["240nA"] = MASTERS[4]
    plain = text.replace(" ", "")
    if plain not in names:
        raise ParameterError(f"bias master: {text!r}, must be one of {', '.join(names)}")
    return names[plain]
