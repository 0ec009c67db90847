"""Bias generator: a current from a 3-bit coarse and an 8-bit fine code, proportional to temperature.

The current is `I = I_coarse fine / 256`. A self-biased core makes the master current, a current splitter
divides a scaled copy into the eight coarse currents, one of these is mirrored into a splitter of octaves, and
the bits of the fine code steer its branches to the output or to the supply:

    I_master = (U_T / R) ln M                           m1, m2 in weak inversion
    g_k / g_tap = sum(I_j, j > k) / (I_k - I_(k+1))     W/L between the coarse nodes k and k + 1
    I_out = I_coarse (b_7 / 2 + b_6 / 4 + ... + b_0 / 256)

The transistors of a splitter share their gate and bulk voltages, so that their ratios are those of W/L at any
current (Bult & Geelen 1992), switches included: a switch that is on has the gate voltage of its branch. The
splitters divide down to any small current, but the copies at the output are nFETs with their sources at
ground: at code 0 they deliver their off current `I_0 W/L`, and the lowest codes sit on it. A self-biased core
can also rest where only off and junction currents flow; the diodes `mk1` to `mk3` pull the gate of `mk4` up
until `mk5` conducts, so that the working state is the only one. On a die the devices have their mismatch, and
nothing else is drawn.

Source: codes from the control software of ROLLS (mn256r1_ncs), the formula of the master current from jAER's
Masterbias, proportionality to absolute temperature from the abstract of Delbruck & van Schaik (2005), "Bias
current generators with wide dynamic range". The topology in detail, sizes, M, R and start-up are ours, in the
AMI 1.5 um process.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.ports import SUPPLY, analog_in, analog_out
from circuits.blocks.rest import rested
from circuits.checks import require_positive
from circuits.circuit import Circuit
from circuits.count import whole_number
from circuits.devices import Transistor
from circuits.devices.transistor import drain_currents, transistor_work
from circuits.errors import ParameterError, unknown_name
from circuits.generator.circuit import (
    CORE_RATIO,
    MASTER_CURRENT,
    WIDE,
    coarse_splitter,
    core,
    fine_splitter,
    n_diode,
    p_copy,
    p_diode,
    range_diode,
    sized,
    sum_mirror,
)
from circuits.generator.code import COARSE, CODES, REFERENCE_C
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params:
    """Codes, the core's resistor (Ohm), and the size ratio M of the core's two nFETs.

    Raises `ParameterError` for a code outside 0 to 7 or 0 to 255, a ratio that is not above 1, and a resistor
    that is not above zero.
    """

    coarse: int = quantity(5, "")
    fine: int = quantity(125, "")  # with the coarse code: 400 pA, the neuron's I_rtau
    # ours: gives the master current at the reference temperature
    core_resistance: float = quantity(147.93e3, "Ohm")
    core_ratio: float = quantity(CORE_RATIO, "")  # ours

    def __post_init__(self) -> None:
        for name, code, count in (("coarse", self.coarse, len(COARSE)), ("fine", self.fine, CODES)):
            whole_number(name, code, 0, count - 1)
        if not self.core_ratio > 1.0:
            raise ParameterError(f"core_ratio: {self.core_ratio:g}, must be > 1; 8 is usual")
        require_positive(self, "core_resistance")


def build(params: Params = Params()) -> Circuit:
    """The generator: ports i_out (sinks the current), v_n, v_p (gates of 6/6 copies, out) and the supply."""
    return Circuit(
        "bias_generator",
        (SUPPLY, *analog_in("i_out"), *analog_out("v_n", "v_p")),
        (
            *core(params.core_resistance, params.core_ratio),
            *coarse_splitter(int(params.coarse)),
            range_diode(),
            *fine_splitter(int(params.fine)),
            *sum_mirror(),
            n_diode(),
            sized("mout", "n", ("i_out", "v_n", "0"), WIDE.copy),
            p_copy(),
            p_diode(),
        ),
    )


STIMULI = (
    Stimulus("output", "V", 2.5, "ideal voltage at the output"),
    DURATION,
)
PLOTTED = ("v_n", "v_p")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """An ideal voltage `output` (V) at i_out, through which the current flows; it begins as it works."""
    sources = powered(v_dd, {"i_out": stimuli["output"] or 0.0})
    return rested("bias generator", circuit, sources, stimuli["duration"] or STOP)


STOP = 1e-3  # s; ours: nothing moves


def transistor_current(point: OperatingPoint, path: str) -> float:
    """Current from drain to source of the transistor at a path such as `stage_3.md`, A, negative in a pFET.

    Raises `UnknownNameError` for a path that is no transistor.
    """
    transistors = point.machine.kernel.transistors
    work = transistor_work(transistors.sign.size)
    drain_currents(transistors, point.voltage, work)
    labels = point.machine.flat.labels(Transistor)
    if path not in labels:
        raise unknown_name(f"{point.machine.flat.circuit.name} transistor", path, labels)
    current: float = work.current[labels.index(path)].item()
    return current


def output_current(point: OperatingPoint) -> float:
    """Current that i_out sinks at an operating point of the testbench, A."""
    return transistor_current(point, "mout")


def measures(result: Result) -> dict[str, float | None]:
    """Numbers at rest: `output_current_A` and `master_current_A`."""
    point = result.operating_point
    return {
        "output_current_A": output_current(point),
        "master_current_A": transistor_current(point, "m1"),
    }


def outcome(result: Result) -> str:
    """`started`, or `no-current` where the core rests below a tenth of its master current."""
    scale = (result.machine.silicon.temperature_c + 273.15) / (REFERENCE_C + 273.15)
    master = transistor_current(result.operating_point, "m1")
    return "started" if np.abs(master) > 0.1 * scale * MASTER_CURRENT else "no-current"


BLOCK = catalogued("bias-generator", build, STIMULI, testbench, measures, outcome, PLOTTED)
