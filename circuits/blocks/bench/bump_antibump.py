"""Bump-antibump circuit: a pair, and between its gates a middle branch that conducts where they are equal.

Two nFETs in series, one at each gate, take their share of the tail where both voltages are alike. With r, how
many times wider they are than the outer ones,

    I_out = I_b / (1 + (4 / r) cosh^2(kappa (v_1 - v_2) / 2 U_T))        in weak inversion
    width = (4 U_T / kappa) arccosh(sqrt(2 + r / 4))                      at half of the peak

The outer currents are the antibumps, of which the two have the offset of their own pair.

Source: topology, sizes and the bias's code are the laboratory's. The drains' voltage is ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import crossing, difference_knobs, difference_sweep, log_ratio
from circuits.blocks.block import catalogued
from circuits.blocks.measure import whether
from circuits.blocks.mos import mos
from circuits.blocks.ports import analog_in, analog_out, biased
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.silicon.process import ROLLS_180
from circuits.solver.power import drain_current
from circuits.solver.transient import Result


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Sizes, um, of the nFETs.

    outer: of the pair m1 and m2, whose currents are the antibumps. middle: of the branch of m3 and m4 between
    them; how many times wider these are than the outer ones is r. tail: of mb.
    """

    outer_width: float = um(1.0)
    outer_length: float = um(1.0)
    middle_width: float = um(16.0)
    middle_length: float = um(1.0)
    tail_width: float = um(3.0)
    tail_length: float = um(1.0)


BIASES = (coded_bias("tail", MASTERS[3], 12, "mb", (3.0, 1.0)),)


def build(params: Params = Params()) -> Circuit:
    """The circuit: ports v1, v2 (gates), i1, i2, i_out (currents in), v_tail (bias); params: sizes."""
    outer, middle = params.sizes("outer", "middle")
    devices = (
        mos("m1", "n", "i1", "v1", "v_s", *outer),
        mos("m2", "n", "i2", "v2", "v_s", *outer),
        mos("m3", "n", "v_x", "v1", "v_s", *middle),
        mos("m4", "n", "i_out", "v2", "v_x", *middle),
        mos("mb", "n", "v_s", "v_tail", "0", *params.size("tail")),
    )
    ports = (*analog_in("v1", "v2"), *analog_out("i1", "i2", "i_out"))
    return biased("bump_antibump", ports, BIASES, devices)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `centre_V`, `width_V`, `peak_share`, `antibump_offset_V` and `tail_A`.

    centre: middle of the two v_1 - v_2 at which the middle current is half of its peak. width: between them.
    peak_share: the peak over the sum of all three currents there. antibump_offset: where the outer currents
    are equal. tail: the sum at the peak. None where the sweep does not get there.
    """
    i1, i2, middle = (drain_current(result, name) for name in ("m1", "m2", "m4"))
    difference, top = result["v1"] - result["v2"], int(middle.argmax())
    half = 0.5 * float(middle[top])
    left = crossing(difference[: top + 1], middle[: top + 1], half)
    right = crossing(difference[top:], middle[top:], half)
    total = float((i1 + i2 + middle)[top])
    found = left is not None and right is not None
    return {
        "centre_V": 0.5 * (left + right) if left is not None and right is not None else None,
        "width_V": right - left if left is not None and right is not None else None,
        "peak_share": float(middle[top]) / total if found else None,
        "antibump_offset_V": crossing(difference, log_ratio(i1, i2), 0.0),
        "tail_A": total if found else None,
    }


STIMULI = difference_knobs(0.5, "all")
PLOTTED = ("v1", "v2", "v_s")
testbench = partial(difference_sweep, "bump-antibump", ("i1", "i2", "i_out"))
outcome = whether(measures, "width_V", "bump", "flank")

BLOCK = catalogued("bump-antibump", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
