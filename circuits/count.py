"""Checks of counts: whole numbers within limits, refused before anything is built of them."""

from __future__ import annotations

from circuits.errors import ParameterError

PARTS = 64  # of one kind in a block or a chip; ours: twice the largest here, and solved whole in minutes
PULSES = 100_000  # of one source; ours
SAMPLES = 10_000_000  # of one source; ours: 80 MB


def whole_number(name: str, value: float, least: int = 1, most: int = PARTS) -> int:
    """`value` as a whole number from `least` to `most`; raises `ParameterError` for any other value."""
    if not least <= value <= most or value != int(value):
        raise ParameterError(f"{name}: {value:g}, must be a whole number from {least} to {most}")
    return int(value)


def pulse_count(name: str, count: float, rate: float) -> int:
    """How many pulses a source at `rate` (Hz) gives; raises `ParameterError` for none or too many."""
    if not rate > 0.0:
        raise ParameterError(f"rate: {rate:g} Hz, must be > 0")
    return whole_number(name, count, 1, PULSES)
