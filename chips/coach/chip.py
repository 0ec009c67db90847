"""The teaching chip as the command line lists it."""

from __future__ import annotations

from chips.coach.wiring import CIRCUITS
from chips.registry import Chip
from circuits.circuit import Circuit


def circuits() -> tuple[Circuit, ...]:
    """Return the circuits of the chip, in the order in which the laboratory takes them."""
    return tuple(wiring.block.build(wiring.block.sizes) for wiring in CIRCUITS.values())


CHIP = Chip(
    "coach",
    "teaching chip: transistors, amplifiers, a synapse, neurons, and its bench",
    circuits,
    "measure it with `noctule run bench SCRIPT.toml`, or take one of its circuits, as differential-pair",
)
