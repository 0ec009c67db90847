"""The rebound neuron's behavioural model as a target: a proxy for a search, some ten times faster.

It knows class, best delay, width and t_inh, and the class `undecided`, which no specification of words names.
Dies far from the model's validity box are extrapolated: what a search finds on them is to be measured at
transistor level.
"""

from __future__ import annotations

from dataclasses import replace
from typing import final

from chips.ranging.model import ReboundModel, model_of, neurons_on
from chips.ranging.response import UNDECIDED, Tunings, tune
from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.study.table import Condition
from system.study.target import BlockTarget, Measurement, Quantity, Target

CIRCUIT = "rebound_neuron"
METRICS = ("best_delay", "width", "t_inh")


def has_model(target: BlockTarget) -> bool:
    """Whether a model stands for the target: its circuit, and all of its metrics."""
    names = [q.name for q in target.quantities]
    return target.choice.circuit.name == CIRCUIT and not target.runs_testbench and set(names) <= set(METRICS)


@final
class BehaviouralTarget(Target):
    """The model of a target's circuit, with the same dies."""

    def __init__(self, target: BlockTarget) -> None:
        """Prepare the model; raises `ParameterError` or `DataError` where the record is not of the target."""
        if not has_model(target):
            raise ParameterError(
                f"--level: behavioural, {target.choice.circuit.name} has no model with these metrics, must be"
                f" {CIRCUIT} with {', '.join(METRICS)}; use transistor"
            )
        self._target = target
        self._model: ReboundModel = model_of(target.choice.circuit, target.choice.silicon.process)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Those of the target."""
        return self._target.quantities

    def labels(self) -> tuple[str, ...]:
        """Those of the target."""
        return self._target.labels()

    def draws(self, die: Die) -> F64:
        """Those of the target."""
        return self._target.draws(die)

    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Tune the model of one die."""
        silicon = replace(self._target.choice.silicon, temperature_c=condition.temperature_c, die=die)
        found = tune(neurons_on(self._model, silicon))
        word = found.classes[0]
        return Measurement(word, tuple(_value(q.name, found, word) for q in self.quantities))

    def identity(self) -> str:
        """That of the target, with the level."""
        return f"behavioural-{self._target.identity()}"


def _value(name: str, found: Tunings, word: str) -> float:
    first, last = float(found.first[0]), float(found.last[0])
    if name == "t_inh":
        return float(found.t_inh[0])
    if word == UNDECIDED:
        return float("nan")
    return 0.5 * (first + last) if name == "best_delay" else last - first
