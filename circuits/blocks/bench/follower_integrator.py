"""Follower-integrator: the wide-range amplifier drives a capacitor and its own inverting input.

    C dv/dt = I_b tanh(kappa (v_in - v) / 2 U_T)

For small differences that is a low-pass of first order, `tau = 2 C U_T / (kappa I_b)`; for large ones the
output moves at the slew rate I_b / C, and ends exponentially. kappa is that of the pair at its source's
voltage, which body effect makes larger than at ground.

Source: topology, the capacitor of 1.000 pF and the bias's code are the laboratory's. The capacitance of the
output's line is ours, 0 unless given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.bench import wide_range_transamp as amplifier
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import slope, within_supply
from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import powered
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, biased
from circuits.circuit import Circuit
from circuits.devices import Capacitor
from circuits.devices.source import PiecewiseLinear
from circuits.silicon.process import ROLLS_180
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

END_FROM, END_TO = 10e-3, 1e-3  # V from where the output settles, between which its end is exponential; ours


@dataclass(frozen=True, slots=True)
class Params(amplifier.Params):
    """Sizes of the amplifier (um), and capacitors (F)."""

    capacitance: float = quantity(1e-12, "F")
    line_capacitance: float = quantity(0.0, "F", least=0.0)  # of the output, beside


BIASES = (coded_bias("tail", MASTERS[1], 37, "amplifier.mb", (1.0, 1.0)),)


def build(params: Params = Params()) -> Circuit:
    """The follower on its capacitor: ports v_in, v_out, v_tail (bias) and the supply.

    params: sizes and capacitors.
    """
    inside = amplifier.amplifier(params).instance("amplifier", v_plus="v_in", v_minus="v_out")
    ports = (SUPPLY, *analog_in("v_in"), *analog_out("v_out"))
    c = Capacitor("c", "v_out", "0", params.capacitance + params.line_capacitance)
    return biased("follower_integrator", ports, BIASES, (c,), (inside,))


BEGIN, EDGE = 1e-3, 1e-6  # s, when the input is stepped, and how long that takes

STIMULI = (
    Stimulus("base", "V", 0.9, "the input before the step"),
    Stimulus("step", "V", 0.3, "height of the step"),
    lasting(14e-3, "from the step on; back after half of it"),
)
PLOTTED = ("v_in", "v_out")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The input at `base`, and a step of `step` from 1 ms on, then back after half of what is left.

    Raises `ParameterError` for a step that leaves the supply.
    """
    base, height = stimuli["base"] or 0.0, stimuli["step"] or 0.0
    within_supply("step", v_dd, base, base + height)
    stop = BEGIN + (stimuli["duration"] or 0.0)
    back = 0.5 * (BEGIN + stop)
    wave = PiecewiseLinear(
        (0.0, BEGIN, BEGIN + EDGE, back, back + EDGE), (base, base, base + height, base + height, base)
    )
    return Testbench("follower-integrator", circuit, powered(v_dd, {"v_in": wave}), stop)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `slew_rate_V_per_s`, `time_constant_s`, `offset_V` and `gain`.

    slew_rate: the steepest rise of the output after the step up. time_constant: that of its exponential end,
    between 10 mV and 1 mV before where it settles; None where it does not come so far. offset: output less
    input before the step. gain: the output's step over the input's; None without a step.
    """
    time, out, given = result.time, result["v_out"], result["v_in"]
    up = (time >= BEGIN + EDGE) & (np.abs(given - given[0]) >= 0.999 * np.abs(given - given[0]).max())
    offset = float(out[0] - given[0])
    if up.sum() < 3:
        return {"slew_rate_V_per_s": None, "time_constant_s": None, "offset_V": offset, "gain": None}
    moved, step = out[up], float(given[up][0] - given[0])
    left = np.abs(moved[-1] - moved)
    ending = (left < END_FROM) & (left > END_TO)
    fall = slope(time[up], np.log(np.maximum(left, 1e-12)), ending)
    return {
        "slew_rate_V_per_s": float(np.abs(np.diff(moved) / np.diff(time[up])).max()),
        "time_constant_s": None if fall is None or fall >= 0.0 else -1.0 / fall,
        "offset_V": offset,
        "gain": float(moved[-1] - out[0]) / step if step else None,
    }


def outcome(result: Result) -> str:
    """`settles` where the output has come within 1 mV of its end long before the step back, else `slews`."""
    time, out = result.time, result["v_out"]
    back = 0.5 * (BEGIN + float(time[-1]))
    end, before = (float(np.interp(at, time, out)) for at in (back, 0.9 * back + 0.1 * BEGIN))
    return "settles" if abs(end - before) < END_TO else "slews"


BLOCK = catalogued("follower-integrator", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
