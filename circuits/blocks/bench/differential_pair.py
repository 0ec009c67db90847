"""Differential pair: two nFETs share a tail current by the difference of their gates.

    I_1 - I_2 = I_b tanh(kappa (v_1 - v_2 - v_offset) / 2 U_T)        in weak inversion

and `ln(I_1 / I_2)` is a straight line of slope kappa / U_T, of which the offset is where it passes 0. The
testbench moves both gates about a common voltage, as the laboratory does, so that the tail's drain moves
little. Both drains stand at an ideal voltage: the converters that read them are no part of the circuit.

Source: topology, sizes (1 um by 1 um) and the bias's code are the laboratory's. The drains' voltage is ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import (
    crossing,
    difference_knobs,
    difference_sweep,
    log_ratio,
    slope,
    thermal_voltage,
)
from circuits.blocks.block import catalogued
from circuits.blocks.measure import whether
from circuits.blocks.mos import mos
from circuits.blocks.ports import analog_in, analog_out, biased
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.silicon.process import ROLLS_180
from circuits.solver.power import drain_current
from circuits.solver.transient import Result

STRAIGHT = 0.15  # V of difference within which kappa is read


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Sizes, um, of the nFETs.

    pair: of m1 and m2, between whose gates the difference stands. tail: of mb, whose current they share.
    """

    pair_width: float = um(1.0)
    pair_length: float = um(1.0)
    tail_width: float = um(1.0)
    tail_length: float = um(1.0)


BIASES = (coded_bias("tail", MASTERS[3], 50, "mb", (1.0, 1.0)),)


def build(params: Params = Params()) -> Circuit:
    """The pair: ports v1, v2 (gates), i1, i2 (currents in), v_tail (bias); params: sizes."""
    pair = params.size("pair")
    devices = (
        mos("m1", "n", "i1", "v1", "v_s", *pair),
        mos("m2", "n", "i2", "v2", "v_s", *pair),
        mos("mb", "n", "v_s", "v_tail", "0", *params.size("tail")),
    )
    return biased("differential_pair", (*analog_in("v1", "v2"), *analog_out("i1", "i2")), BIASES, devices)


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


STIMULI = difference_knobs(0.3, "both")
PLOTTED = ("v1", "v2", "v_s")
testbench = partial(difference_sweep, "differential pair", ("i1", "i2"))
outcome = whether(measures, "offset_V", "balanced", "one-sided")

BLOCK = catalogued("differential-pair", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
