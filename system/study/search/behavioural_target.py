"""Behavioural models of blocks as targets of a search, many times faster than their circuits."""

from __future__ import annotations

from dataclasses import replace
from typing import final

from chips.model import Proxy, load_model, model_names
from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.study.table import Condition
from system.study.target import BlockTarget, Measurement, Quantity, Target


def has_model(target: BlockTarget) -> bool:
    """Tell whether a behavioural model stands for the block of a target, and for all of its metrics."""
    return _proxy_of(target) is not None


def _proxy_of(target: BlockTarget) -> Proxy | None:
    name = target.choice.block.name
    proxy = load_model(name).proxy if name in model_names() else None
    names = {q.name for q in target.quantities}
    return proxy if proxy and not target.runs_testbench and names <= set(proxy.metrics) else None


def _known() -> str:
    """Blocks and metrics that models stand for."""
    models = [model for model in map(load_model, model_names()) if model.proxy]
    return " or ".join(f"{m.record_name} with {', '.join(m.proxy.metrics)}" for m in models if m.proxy)


@final
class BehaviouralTarget(Target):
    """The behavioural model of a target's circuit as a target itself, with the same dies."""

    def __init__(self, target: BlockTarget) -> None:
        """Prepare the model of the circuit.

        Raises `ParameterError` for a target that has no model, and `DataError` where the record of the model
        is not of the circuit.
        """
        proxy = _proxy_of(target)
        if proxy is None:
            raise ParameterError(
                f"level: behavioural, {target.choice.circuit.name} has no model with these metrics, must be"
                f" {_known()}; use transistor"
            )
        self._target = target
        self._tuned = proxy.tuned(target.choice.circuit, target.choice.silicon.process)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The quantities of the target that the model stands for."""
        return self._target.quantities

    def labels(self) -> tuple[str, ...]:
        """Give the labels of the draws of a die, which are those of the circuit."""
        return self._target.labels()

    def draws(self, die: Die) -> F64:
        """Give the draws of a die, float64[labels], which are those of the circuit."""
        return self._target.draws(die)

    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Measure one die at a condition by the model, tuned to that die."""
        silicon = replace(self._target.choice.silicon, temperature_c=condition.temperature_c, die=die)
        word, values = self._tuned(silicon)
        return Measurement(word, tuple(values[q.name] for q in self.quantities))

    def identity(self) -> str:
        """Give the hash of the target that the model stands for, with the level before it."""
        return f"behavioural-{self._target.identity()}"
