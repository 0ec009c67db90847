"""Differential pair: two nFETs share a tail current by the difference of their gates.

    I_1 - I_2 = I_b tanh(kappa (v_1 - v_2 - v_offset) / 2 U_T)        in weak inversion

and `ln(I_1 / I_2)` is a straight line of slope kappa / U_T, of which the offset is where it passes 0. The
testbench moves both gates about a common voltage, as the laboratory does, so that the tail's drain moves
little. Both drains stand at an ideal voltage: the converters that read them are no part of the circuit.

Source: topology, sizes (1 um by 1 um) and the bias's code are the laboratory's. The drains' voltage is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import crossing, difference_sweep, log_ratio, slope, thermal_voltage
from circuits.blocks.block import Block, Stimulus, Values
from circuits.blocks.drive import driven
from circuits.blocks.mos import mos
from circuits.blocks.ports import analog_in, analog_out, bias_ports
from circuits.blocks.sizes import Sizes
from circuits.circuit import Circuit
from circuits.silicon.process import ROLLS_180
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

STRAIGHT = 0.15  # V of difference within which kappa is read


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Sizes, um."""

    pair_width: float = quantity(1.0, "um")
    pair_length: float = quantity(1.0, "um")
    tail_width: float = quantity(1.0, "um")
    tail_length: float = quantity(1.0, "um")


BIASES = (coded_bias("tail", MASTERS[3], 50, "mb", (1.0, 1.0)),)


def build(params: Params = Params()) -> Circuit:
    """The pair: ports v1, v2 (gates), i1, i2 (currents in), v_tail (bias); params: sizes."""
    pair = params.size("pair")
    return Circuit(
        "differential_pair",
        (*analog_in("v1", "v2"), *analog_out("i1", "i2"), *bias_ports(BIASES)),
        (
            mos("m1", "n", "i1", "v1", "v_s", *pair),
            mos("m2", "n", "i2", "v2", "v_s", *pair),
            mos("mb", "n", "v_s", "v_tail", "0", *params.size("tail")),
        ),
        biases=BIASES,
    )


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The difference from -span to +span about `common`, with both drains at `out`.

    Raises `ParameterError` for a sweep that leaves the supply.
    """
    waves, duration = difference_sweep(stimuli, v_dd, ("i1", "i2"))
    return Testbench("differential pair", circuit, driven(waves), duration)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `kappa`, `offset_V`, `tail_A` and `transconductance_S`.

    kappa: from the slope of ln(I_1 / I_2) within 0.15 V of the offset. offset: v_1 - v_2 at which both
    currents are equal. tail: their sum there. transconductance: of the difference of the currents there.
    None where the sweep does not reach the offset.
    """
    i1, i2 = drain_current(result, "m1"), drain_current(result, "m2")
    difference = result["v1"] - result["v2"]
    offset = crossing(difference, i1 - i2, 0.0)
    if offset is None:
        return dict.fromkeys(("kappa", "offset_V", "tail_A", "transconductance_S"))
    straight = np.abs(difference - offset) < STRAIGHT
    rise = slope(difference, log_ratio(i1, i2), straight)
    near = np.abs(difference - offset) < 0.01
    return {
        "kappa": None if rise is None else rise * thermal_voltage(result),
        "offset_V": offset,
        "tail_A": float(np.interp(offset, difference, i1 + i2)),
        "transconductance_S": slope(difference, i1 - i2, near),
    }


def outcome(result: Result) -> str:
    """`balanced` where the sweep passes the point of equal currents, else `one-sided`."""
    return "one-sided" if measures(result)["offset_V"] is None else "balanced"


BLOCK = Block(
    name="differential-pair",
    summary="nFET pair on a tail current: a tanh of the difference of two voltages",
    build=build,
    stimuli=(
        Stimulus("common", "V", 0.9, "mean of both gates"),
        Stimulus("span", "V", 0.3, "largest difference of the gates"),
        Stimulus("out", "V", 1.2, "of both drains"),
        Stimulus("duration", "s", 1.0, "length of the sweep"),
    ),
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("v1", "v2", "v_s"),
    process=ROLLS_180,
)
