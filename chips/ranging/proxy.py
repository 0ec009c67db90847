"""A fast substitute of the rebound neuron's simulation in a search: what its model knows of its tuning.

It knows class, best delay, width and t_inh, and the class `undecided`, which no specification of words names.
Dies far from the model's validity box are extrapolated: what a search finds on them is to be measured at
transistor level.
"""

from __future__ import annotations

from chips.model import Tuned
from chips.ranging.model import model_of, neurons_on
from chips.ranging.response import UNDECIDED, Tunings, tune
from circuits.circuit import Circuit
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

METRICS = ("best_delay", "width", "t_inh")


def tuned(circuit: Circuit, process: Process) -> Tuned:
    """Return a function of the silicon that gives class and metrics of a lone rebound neuron.

    Raises `ParameterError` or `DataError` where the record is not of the circuit.
    """
    model = model_of(circuit, process)

    def on(silicon: Silicon) -> tuple[str, dict[str, float]]:
        found = tune(neurons_on(model, silicon))
        word = found.classes[0]
        return word, {name: _value(name, found, word) for name in METRICS}

    return on


def _value(name: str, found: Tunings, word: str) -> float:
    first, last = float(found.first[0]), float(found.last[0])
    if name == "t_inh":
        return float(found.t_inh[0])
    if word == UNDECIDED:
        return float("nan")
    return 0.5 * (first + last) if name == "best_delay" else last - first
