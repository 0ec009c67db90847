"""The conditions that a process must meet for the behavioural models to hold."""

from __future__ import annotations

from circuits.errors import ParameterError
from circuits.silicon.process import POLARITIES, Process


def check_law(process: Process) -> None:
    """Raise `ParameterError` unless the transistors have constant kappa, no Early effect and no leakage."""
    for polarity in POLARITIES:
        law = process.model(polarity)
        if law.law != "ekv" or law.early != 0.0 or law.junction_leakage != 0.0:
            raise ParameterError(
                f"{process.name}.{polarity}: {law.law}, Early {law.early:g}/V, leakage"
                f" {law.junction_leakage:g} A/m, must be ekv without either; use the transistor level"
            )
