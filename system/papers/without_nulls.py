"""Experiments that need no null, each with the reason; all others score nulls (`system.verdict.null`).

A null asks whether a rule could hold by chance or for a robot that does nothing. A closed form is an equation
that holds or not; a circuit is held against numbers, equations or transistors, in tolerances that no other
circuit meets by chance; and what is shown before and after a change is about the change alone.
"""

from __future__ import annotations

from collections.abc import Mapping

CLOSED = "a closed form: an equation holds or not"
CIRCUIT = "a circuit against numbers or equations of its paper"
TRANSISTORS = "a model or a simulator against the transistors of the same circuit"
STEPS = "one scene, step by step, that goes as the paper says or not"
BESIDE = "numbers beside one another, hardly any of them judged"

WITHOUT_NULLS: Mapping[str, str] = {
    "cheely2003-fig4": CIRCUIT,
    "cheely2003-fig5": CIRCUIT,
    "cheely2003-fig6": CIRCUIT,
    "cheely2003-fig8": CIRCUIT,
    "cheely2003-fig9": CIRCUIT,
    "cheely2003-fig10": CIRCUIT,
    "cheely2003-power": CIRCUIT,
    "hwu2018-fig1": STEPS,
    "hwu2018-fig2": STEPS,
    "wen2022-fig5": STEPS,
    "wen2022-fig11c": CLOSED,
    "wen2022-fig12": STEPS,
    "wen2022-fig12-chip": STEPS,
    "latency-equations": CLOSED,
    "latency-agreement": TRANSISTORS,
    "latency-recall": CIRCUIT,
    "stockel2017-fig5": STEPS,
    "nef-chip": TRANSISTORS,
    "nef-law": TRANSISTORS,
    "rolls-calibration": CIRCUIT,
    "rolls-mapping": "a chip against the equations of the network on it",
    "rolls-drift": CIRCUIT,
    "rolls-forms": TRANSISTORS,
    "rolls-mismatch": CIRCUIT,
    "rolls-learning": "the same chip before it is taught stands beside it, and tells patterns by chance",
    "rolls-depression": CIRCUIT,
    "rolls-measured": BESIDE,
    "milde2017-fig5": "a matrix of weights, each of the sign that the paper draws or not",
    "milde2017-power": CIRCUIT,
    "second-order": BESIDE,
    "ranging-law": TRANSISTORS,
    "wavefront-law": TRANSISTORS,
    "latency-law": TRANSISTORS,
    "choice-law": TRANSISTORS,
    "rolls-law": BESIDE,
    "defaults": BESIDE,
    "variation": BESIDE,
    "agreement": TRANSISTORS,
    "ngspice-dies": TRANSISTORS,
    "random-circuits": TRANSISTORS,
    "foundry-dies": TRANSISTORS,
    "coach-synthetic": "known dies of the fit's own model, so that coverage has its own expectation",
    "coach": "measurements that a fit has not seen, beside its band: no robot is judged",
    "foundry-blocks": BESIDE,
    "device-noise": TRANSISTORS,
    "chip-noise": TRANSISTORS,
}
