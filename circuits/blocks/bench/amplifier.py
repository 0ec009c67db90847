"""What transconductance amplifiers have in common: sizes, the sweep of an input, and what is read off it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.blocks.bench.curve import crossing, ramp, within_supply
from circuits.blocks.block import Stimulus, Values, lasting
from circuits.blocks.drive import Wave, powered
from circuits.blocks.measure import whether
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.lowering.supply import half_supply
from circuits.solver.transient import Result
from circuits.testbench import Testbench


@dataclass(frozen=True, slots=True)
class AmplifierSizes(Sizes):
    """Sizes of an amplifier's transistors, um, one for each polarity."""

    n_width: float = um(1.0)
    n_length: float = um(1.0)
    p_width: float = um(3.4)
    p_length: float = um(1.0)


POINTS = 360  # of the sweep: 5 mV apart at 1.8 V
STIMULI = (
    Stimulus("v_minus", "V", 0.9, "at the inverting input"),
    lasting(1.0, "length of the sweep of the other input over the supply"),
)


def open_sweep(
    title: str, circuit: Circuit, stimuli: Values, v_dd: float, held: tuple[str, ...] = ()
) -> Testbench:
    """A sweep of `v_plus` from ground to the supply at one `v_minus`, with the output open.

    Raises `ParameterError` for a `v_minus` that leaves the supply.

    Parameters
    ----------
    title
        Name of the testbench.
    circuit
        An amplifier with ports v_plus and v_minus.
    stimuli
        Values of `STIMULI`, and of `out` (V) where nodes are held.
    v_dd
        The supply, V.
    held
        Nodes that stand at `out`.
    """
    minus, duration = (stimuli[name] or 0.0 for name in ("v_minus", "duration"))
    within_supply("v_minus", v_dd, minus)
    waves: dict[str, Wave] = {"v_plus": ramp(0.0, duration, 0.0, v_dd, POINTS), "v_minus": minus}
    for node in held:
        out = stimuli["out"] or 0.0
        within_supply("out", v_dd, out)
        waves[node] = out
    return Testbench(title, circuit, powered(v_dd, waves), duration)


def output_measures(result: Result, node: str = "v_out") -> dict[str, float | None]:
    """Numbers of an open output over such a sweep: `switch_V`, `gain`, `low_V` and `high_V`.

    switch: v_plus at which the output passes half the supply; None where it never does. gain: the steepest
    rise of the output. low, high: the lowest and the highest voltage of the output.
    """
    out, plus = result[node], result["v_plus"]
    return {
        "switch_V": crossing(plus, out, half_supply(result.machine)),
        "gain": steepest(plus, out),
        "low_V": float(out.min()),
        "high_V": float(out.max()),
    }


def steepest(x: F64, y: F64) -> float:
    """The steepest rise of y over x between points of the sweep."""
    even = np.linspace(x[0], x[-1], POINTS + 1)
    return float((np.diff(np.interp(even, x, y)) / np.diff(even)).max())


switches = whether(output_measures, "switch_V", "switches", "stays")
"""The outcome of a sweep: whether the output passes half the supply."""
