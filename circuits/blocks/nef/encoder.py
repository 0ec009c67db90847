"""Encoder stage of the NEF chip: a signed and weighted copy of a signal's current into a membrane.

A signal comes as the gate voltages of two pFETs: `v_pos` for what it is above its middle and `v_neg` for what
it is below; one of the two is off. A bank of binary-weighted pFETs copies each of them. The bits let the
currents of the banks through, and the sign says which bank goes to the output directly, and which through a
mirror that draws a current:

    I_out = +-(code / unit) (I_pos - I_neg),    code = sum of 2^k over the bits that are on

A bit is on at 0 V. A column of such stages has one signal and a stage for each neuron; a neuron gets the sum
of its stages. With a fixed current in the place of the signal, a stage is the neuron's bias. Topology, sizes
and numbers are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.bias import bias_voltages
from circuits.blocks.block import Stimulus, Values, catalogued
from circuits.blocks.drive import Wave, powered, step
from circuits.blocks.mos import current_mirror, inverter, mos
from circuits.blocks.ports import SUPPLY, analog_out, biased
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench

BITS = 8
UNIT = 20e-12  # A, what a code of 1 gives at full scale
MEMBRANE = 0.3  # V, ours: ideal voltage at which the testbench measures the output's current


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Sizes, um; ours.

    unit: of the pFET that copies a signal for a code of 1; the others of a bank are 2, 4, ... such side by
    side. mirror: of the nFETs that turn a current round. switch: of the pFETs that bits and sign open.
    """

    unit_width: float = um(0.5)
    unit_length: float = um(2.0)
    mirror_width: float = um(4.0)
    mirror_length: float = um(8.0)
    switch_width: float = um(0.5)
    switch_length: float = um(1.0)


BIASES = (
    Bias("i_pos", "v_pos", "gate", UNIT, "md0"),
    Bias("i_neg", "v_neg", "gate", 0.05 * UNIT, "mr0"),
    *(Bias(f"v_b{k}", f"b{k}", "voltage", 0.0) for k in range(BITS)),
    Bias("v_posn", "sign", "voltage", 1.8),
)


def build(params: Params = Params()) -> Circuit:
    """The stage: ports i_out, v_pos, v_neg, b0 to b7 (low is on), sign (high is positive), the supply."""
    unit, switch = params.sizes("unit", "switch")
    banks = []
    for letter, gate, out in (("d", "v_pos", "pos"), ("r", "v_neg", "neg")):
        for k in range(BITS):
            source = mos(f"m{letter}{k}", "p", f"{letter}{k}", gate, "vdd", *unit)
            banks.append(replace(source, multiplicity=2.0**k))
            banks.append(mos(f"ms{letter}{k}", "p", out, f"b{k}", f"{letter}{k}", *switch))
    steering = (
        *inverter("mi", "sign", "unsigned", width=0.5, length=0.18),
        mos("mx1", "p", "i_out", "unsigned", "pos", *switch),
        mos("mx2", "p", "low", "sign", "pos", *switch),
        mos("mx3", "p", "i_out", "sign", "neg", *switch),
        mos("mx4", "p", "low", "unsigned", "neg", *switch),
        *current_mirror("mm1", "mm2", "n", "low", "i_out", params.size("mirror")),
    )
    ports = (SUPPLY, *analog_out("i_out"))
    return biased("nef_encoder", ports, BIASES, (*banks, *steering))


def bits_of(code: float, v_dd: float) -> dict[str, float]:
    """Voltages of the bits and the sign for a code from -255 to 255, V, by port.

    Raises `ParameterError` for another code.
    """
    most = 2**BITS - 1
    if code != int(code) or abs(code) > most:
        raise ParameterError(f"code: {code:g}, must be a whole number from {-most} to {most}")
    on = {f"b{k}": 0.0 if abs(int(code)) >> k & 1 else v_dd for k in range(BITS)}
    return on | {"sign": v_dd if code >= 0 else 0.0}


STEP_TIME, STOP = 1e-3, 5e-3  # s

STIMULI = (
    Stimulus("code", "", 50.0, "weight, -255 to 255"),
    Stimulus("step", "V", 20e-3, "of the signal's gate down from its bias at 1 ms", can_be_off=True),
)
PLOTTED = ("v_pos", "pos", "neg", "low")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A code, and a signal above its middle, whose gate falls by `step` (V) below its bias at 1 ms."""
    waves: dict[str, Wave] = {"i_out": MEMBRANE, **bits_of(stimuli["code"] or 0.0, v_dd)}
    if stimuli["step"]:
        begin = float(bias_voltages(circuit, circuit.bias("i_pos"), Silicon(ROLLS_180_IDEAL)))
        waves["v_pos"] = step(STEP_TIME, 1.1 * STEP_TIME, begin, begin - stimuli["step"])
    return rested("NEF encoder", circuit, powered(v_dd, waves), STOP, ROLLS_180_IDEAL)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: the current into the membrane, `current_A` at the end, `before_A` before the step."""
    current = output_current(result)
    before = int((result.time < STEP_TIME).sum()) - 1
    return {
        "current_A": float(current[-1]),
        "before_A": float(current[before]),
    }


def output_current(result: Result) -> F64:
    """Current out of `i_out`, A, float64[T]: that of the pFETs less that of the mirror."""
    return np.asarray(
        np.abs(drain_current(result, "mx1"))
        + np.abs(drain_current(result, "mx3"))
        - np.abs(drain_current(result, "mm2"))
    )


def outcome(result: Result) -> str:
    """`source` or `sink`, or `none` below a hundredth of a unit."""
    current = float(output_current(result)[-1])
    if abs(current) < 0.01 * UNIT:
        return "none"
    return "source" if current > 0.0 else "sink"


BLOCK = catalogued("nef-encoder", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
