"""The option `--deadline`, which limits the time of a run in ngspice."""

from __future__ import annotations

from circuits.errors import ParameterError
from circuits.units import parse_quantity
from netlists.ngspice.deadline import DEADLINE


def deadline_of(text: str | None, engine: str) -> float:
    """Read the wall-clock time that a run in ngspice may take, s; `DEADLINE` where none is given.

    Raises `ParameterError` for a time that is not above 0, and for another engine than ngspice.
    """
    if text is None:
        return DEADLINE
    if engine != "ngspice":
        raise ParameterError(f"--deadline: {text}, only --engine ngspice takes it; leave it out")
    seconds = parse_quantity(text, "s", "--deadline")
    if not seconds > 0.0:
        raise ParameterError(f"--deadline: {seconds:g} s, must be > 0; give more time")
    return seconds
