"""Axon-hillock neuron: two inverters with a capacitor from their output back to the membrane.

A small current fills the membrane. At the first inverter's threshold both inverters turn, and the feedback
capacitor lifts the membrane by a step; the reset then draws a current from it until the way back is passed,
and the step comes off.

    jump = V_dd C_fb / (C_fb + C_m + C_par)
    t_low = (C_fb + C_m + C_par) jump / I_in,    t_high = (C_fb + C_m + C_par) jump / (I_pw - I_in)

C_par is what the inverter's gate has, a third of a picofarad, and its line. Mead, "Analog VLSI and Neural
Systems" (1989), has the circuit.

Source: topology and sizes (C_m is 32 um square, C_fb 20 um square) and the bias's code are the laboratory's.
The input's current is a source of the chip, whose circuit is not told; here it is the testbench's, 3 pA, of
which the reset that is off takes one in this process. That the reset's switch follows the output at once, as
its acknowledge, is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import slope
from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import current_into, powered
from circuits.blocks.measure import spike_outcome
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_in, biased, event_out
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.devices import Capacitor
from circuits.lowering.supply import half_supply
from circuits.silicon.process import ROLLS_180
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um)."""

    membrane_capacitance: float = quantity(2.08e-12, "F")
    feedback_capacitance: float = quantity(0.81e-12, "F")
    line_capacitance: float = quantity(0.0, "F", least=0.0)  # of the membrane, beside: the buffer's input
    first_p_width: float = um(13.6)
    first_n_width: float = um(4.0)
    first_length: float = um(4.0)
    second_p_width: float = um(3.4)
    second_n_width: float = um(1.0)
    second_length: float = um(1.0)
    reset_width: float = um(3.4)
    reset_length: float = um(1.0)


BIASES = (coded_bias("pw", MASTERS[0], 2, "m_pw", (3.4, 1.0)),)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports v_mem (current in), spike (out), v_pw (bias) and the supply; params: its sizes."""
    reset = params.size("reset")
    devices = (
        Capacitor("c_m", "v_mem", "0", params.membrane_capacitance + params.line_capacitance),
        Capacitor("c_fb", "spike", "v_mem", params.feedback_capacitance),
        mos("m1p", "p", "v_o", "v_mem", "vdd", params.first_p_width, params.first_length),
        mos("m1n", "n", "v_o", "v_mem", "0", params.first_n_width, params.first_length),
        mos("m2p", "p", "spike", "v_o", "vdd", params.second_p_width, params.second_length),
        mos("m2n", "n", "spike", "v_o", "0", params.second_n_width, params.second_length),
        mos("m_rst", "n", "v_mem", "spike", "low", *reset),
        mos("m_pw", "n", "low", "v_pw", "0", *reset),
    )
    return biased("axon_hillock", (SUPPLY, *analog_in("v_mem"), *event_out("spike")), BIASES, devices)


BEGIN, DURATION = 0.6, 6.0  # V, s

STIMULI = (
    Stimulus("current", "A", 3e-12, "into the membrane"),
    lasting(DURATION),
)
PLOTTED = ("v_mem", "v_o", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A current into the membrane, which begins at 0.6 V."""
    sources = (*powered(v_dd), current_into("v_mem", stimuli["current"] or 0.0))
    stop = stimuli["duration"] or DURATION
    return Testbench("axon hillock", circuit, sources, stop, watch=("spike",), initial={"v_mem": BEGIN})


MARGIN = 0.15  # of a phase at each end that slopes leave out


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `period_s`, `pulse_width_s`, `jump_V`, `threshold_V`, `rise_V_per_s`, `fall_V_per_s`.

    Of the last whole period. threshold: v_mem before the spike's jump, which is that from there to the top.
    rise, fall: slopes of v_mem while the output is low and high. None where there is no whole period.
    """
    time, v = result.time, result["v_mem"]
    up, down = _crossings(result, 1.0), _crossings(result, -1.0)
    names = ("period_s", "pulse_width_s", "jump_V", "threshold_V", "rise_V_per_s", "fall_V_per_s")
    if up.size < 2 or not ((down > up[-2]) & (down < up[-1])).any():
        return dict.fromkeys(names)
    begin, end = float(up[-2]), float(up[-1])
    back = float(down[(down > begin) & (down < end)][0])
    edge = 1e-3 * (end - begin)
    before, top = (float(np.interp(begin + side * edge, time, v)) for side in (-1.0, 1.0))
    return {
        "period_s": end - begin,
        "pulse_width_s": back - begin,
        "jump_V": top - before,
        "threshold_V": before,
        "rise_V_per_s": _slope_within(time, v, back, end),
        "fall_V_per_s": _slope_within(time, v, begin, back),
    }


def _crossings(result: Result, sign: float) -> F64:
    """Times at which the output passes half the supply, upwards for a sign above 0."""
    over = sign * (result["spike"] - half_supply(result.machine))
    return np.asarray(result.time[1:][(over[:-1] < 0.0) & (over[1:] >= 0.0)])


def _slope_within(time: F64, v: F64, begin: float, end: float) -> float | None:
    margin = MARGIN * (end - begin)
    return slope(time, v, (time > begin + margin) & (time < end - margin))


BLOCK = catalogued("axon-hillock", build, STIMULI, testbench, measures, spike_outcome, PLOTTED, ROLLS_180)
