"""What the codes of a ranging chip say: values of its biases, delays of its neurons, and which are off."""

from __future__ import annotations

from chips.codes import Codes
from chips.ranging import circuit as ranging_chip

NAME = "ranging-chip"  # of the calibration
PADS = ("v_rest", "v_th", "v_ex_max")
"""Biases that are voltages, trimmed on the board."""


def values_of(codes: Codes | None) -> dict[str, float | tuple[float, ...]]:
    """Return values of biases by name, A or V, as `circuits.bias.rebias` takes them; none without codes."""
    if codes is None:
        return {}
    return codes.currents | {name: codes.trims[name][0] for name in PADS}


def delays_of(codes: Codes | None) -> tuple[float, ...]:
    """Return the delay for which each neuron stands, s; those of the design without codes."""
    return ranging_chip.BEST_DELAYS if codes is None else codes.trims["delays"]


def off_of(codes: Codes | None) -> tuple[int, ...]:
    """Return the neurons that are switched off by their address."""
    return () if codes is None else codes.off.get("neuron", ())
