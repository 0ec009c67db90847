"""Rows of `agreement` about the ranging chip's coupling, held to what docs/evidence/cheely2003.md says.

The chip with its bias chain is simulated fully coupled, and its neurons separately stepped, both by the
solver (`chips.ranging.coupling`). Compared with the figures of the documentation is by how much earlier
inhibition and spike come in the coupled chip, in the neuron that it moves most.
"""

from __future__ import annotations

import numpy as np

from chips.ranging.coupling import Coupling
from system.rule import Rule, none, within
from system.statement import Statement

# docs/evidence/cheely2003.md: the worst neuron's inhibition and spike come this much earlier when coupled
SHARE, INHIBITION, SPIKE = 0.0491, 0.364e-3, 0.290e-3  # of t_inh, s, s
DOCUMENTED = "worst neuron as in docs/evidence/cheely2003.md"
SHARE_TOLERANCE, TIME_TOLERANCE = 5e-4, 2e-6  # of t_inh, s


def coupling_rows(coupling: Coupling) -> list[Statement]:
    """Compare the worst neuron with the documentation, and count neurons that fire in one run only."""
    share = coupling.t_inh / coupling.t_inh_separate
    times = f"{DOCUMENTED}: {{of_milli:g}} ms, within {{micro:g}} us"
    return [
        _row(
            "t_inh_share",
            share,
            within(SHARE_TOLERANCE, f"{DOCUMENTED}: {{of_percent:g}} %, within {{percent:g}} %", of=SHARE),
        ),
        _row("t_inh_s", coupling.t_inh, within(TIME_TOLERANCE, times, of=INHIBITION)),
        _row("spike_s", coupling.spike, within(TIME_TOLERANCE, times, of=SPIKE)),
        Statement("coupling_fires_in_one_only", None, float(len(coupling.only_one_fires)), none("no neuron")),
    ]


def coupling_note(coupling: Coupling) -> str:
    """Tell the difference neuron by neuron."""
    inhibition, spike = coupling.t_inh, coupling.spike
    return (
        "Fully coupled against separately stepped, 27 degC, neurons 0 to 12: inhibition ends earlier by"
        f" {_microseconds(inhibition)} us, most of its length in neuron"
        f" {int(np.nanargmax(inhibition / coupling.t_inh_separate))}, most in neuron"
        f" {int(np.nanargmax(inhibition))}; after an echo at its best delay the spike comes earlier by"
        f" {_microseconds(spike)} us, most in neuron {int(np.nanargmax(spike))}."
    )


def _row(name: str, values: np.ndarray, rule: Rule) -> Statement:
    return Statement(f"coupling_{name}", None, float(np.nanmax(np.abs(values))), rule)


def _microseconds(values: np.ndarray) -> str:
    return ", ".join(f"{1e6 * v:.0f}" for v in values)
