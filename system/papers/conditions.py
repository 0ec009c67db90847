"""On which silicon published figures are made again.

The equations of the papers are those of the ideal law, without second-order effects. The chips that they
describe have gate voltages from outside, or a bias generator whose circuit is not published; what stands for
it is an ideal current. What noctule's own defaults, the full law and the generator's circuit, make of the
same runs is an experiment of its own (`system.papers.checks.defaults`).
"""

from __future__ import annotations

from typing import TypedDict

from circuits.circuit import BiasKind
from circuits.silicon.process import Effects


class Conditions(TypedDict):
    """Fields of a scenario by which its silicon is that of a paper.

    law : of its transistors, `ideal` or `full`.
    bias_kind : of its chips' biases.
    """

    law: Effects
    bias_kind: BiasKind


FIXED_GATES: Conditions = {"law": "ideal", "bias_kind": "gate"}
"""The papers' equations, and gate voltages that neither die nor temperature moves."""

IDEAL_CURRENTS: Conditions = {"law": "ideal", "bias_kind": "ideal"}
"""The papers' equations, and ideal currents into copies of the biased devices on the die."""
