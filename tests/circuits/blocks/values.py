"""What tests of blocks share: numbers that have to be in a run."""

from __future__ import annotations


def number(value: float | None) -> float:
    """A measured value, which has to be in the run."""
    assert value is not None
    return value
