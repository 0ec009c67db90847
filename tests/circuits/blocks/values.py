"""What tests of blocks share: numbers that have to be in a run."""

from __future__ import annotations

TEMPERATURES = (-20.0, 27.0, 85.0)  # degC, at which blocks of the sonar are run


def number(value: float | None) -> float:
    """A measured value, which has to be in the run."""
    assert value is not None
    return value
