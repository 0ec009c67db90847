"""The conditions that a process and a die must meet for the behavioural models to hold."""

from __future__ import annotations

from circuits.errors import ParameterError
from circuits.silicon.die import Die
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


def check_capacitors(path: str, die: Die) -> None:
    """Raise `ParameterError` for a die whose capacitors deviate; the model at `path` does not follow them."""
    if die.number is not None and die.variation == "full":
        raise ParameterError(
            f"{path}: {die}, its model does not follow the deviations of capacitors and resistors;"
            " leave them out by `variation=transistors`, or take the transistor level"
        )
