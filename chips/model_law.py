"""The conditions that a process must meet for some behavioural models to hold."""

from __future__ import annotations

from circuits.errors import ParameterError
from circuits.silicon.process import POLARITIES, SECOND_ORDER, Process


def check_law(process: Process) -> None:
    """Raise `ParameterError` unless the transistors have constant kappa and no second-order effect."""
    for polarity in POLARITIES:
        model = process.model(polarity)
        if model != model.ideal():
            found = [f"{name} {getattr(model, name):g}" for name in SECOND_ORDER if getattr(model, name)]
            raise ParameterError(
                f"{process.name}.{polarity}: {', '.join([model.law, *found])}, must be ekv without"
                " second-order effects; take the law `ideal`, or the transistor level"
            )
