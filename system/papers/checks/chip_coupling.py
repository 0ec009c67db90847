"""Rows about a chip's coupling: fully coupled beside separately stepped, held to what docs/circuits.md says.

Both sides are the solver's (`chips.ranging.coupling`). The rules hold the documentation to what is measured.
"""

from __future__ import annotations

import numpy as np

from chips.ranging.coupling import Coupling
from system.experiment import Row

# docs/circuits.md: the worst neuron's inhibition and spike come this much earlier on the coupled chip
SHARE, INHIBITION, SPIKE = 0.0491, 0.364e-3, 0.290e-3  # of t_inh, s, s
SHARE_TOLERANCE, TIME_TOLERANCE = 5e-4, 2e-6  # of t_inh, s


def coupling_rows(coupling: Coupling) -> list[Row]:
    """Worst neuron by share of t_inh, by time and by its spike, and who fires in one of the two only."""
    share = coupling.t_inh / coupling.t_inh_separate
    shares, times = f"within {100 * SHARE_TOLERANCE:g} %", f"within {1e6 * TIME_TOLERANCE:g} us"
    lost = float(len(coupling.only_one_fires))
    return [
        _row("t_inh_share", share, SHARE, f"{100 * SHARE:g} %, {shares}", SHARE_TOLERANCE),
        _row("t_inh_s", coupling.t_inh, INHIBITION, f"{1e3 * INHIBITION:g} ms, {times}", TIME_TOLERANCE),
        _row("spike_s", coupling.spike, SPIKE, f"{1e3 * SPIKE:g} ms, {times}", TIME_TOLERANCE),
        Row(
            "coupling_fires_in_one_only", None, lost, "no neuron", 0.0, fitted=False, agrees=lost == 0.0
        ),
    ]  # fmt: skip


def coupling_note(coupling: Coupling) -> str:
    """The difference neuron by neuron."""
    inhibition, spike = coupling.t_inh, coupling.spike
    return (
        "Fully coupled against separately stepped, 27 degC, neurons 0 to 12: inhibition ends earlier by"
        f" {_microseconds(inhibition)} us, most of its length in neuron"
        f" {int(np.nanargmax(inhibition / coupling.t_inh_separate))}, most in neuron"
        f" {int(np.nanargmax(inhibition))}; after an echo at its best delay the spike comes earlier by"
        f" {_microseconds(spike)} us, most in neuron {int(np.nanargmax(spike))}."
    )


def _row(name: str, values: np.ndarray, said: float, text: str, tolerance: float) -> Row:
    worst = float(np.nanmax(np.abs(values)))
    rule = f"worst neuron as in docs/circuits.md: {text}"
    agrees = abs(worst - said) <= tolerance
    return Row(f"coupling_{name}", None, worst, rule, tolerance, fitted=False, agrees=agrees)


def _microseconds(values: np.ndarray) -> str:
    return ", ".join(f"{1e6 * v:.0f}" for v in values)
