"""Metrics of a block as a list shows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from circuits.catalogue import loaded
from circuits.registry import metrics_of_circuit
from circuits.units import unit_of_name
from system.options.block import Choice


@dataclass(frozen=True, slots=True)
class Listed:
    """A metric as a list shows it.

    name, unit, summary : what studies call it, its SI unit where its name has none, and a line about it.
    nominal : its value on the nominal die; None where it was not measured or is not defined.
    """

    name: str
    unit: str
    summary: str
    nominal: float | None = None


def listed(choice: Choice, *, run: bool) -> list[Listed]:
    """List the metrics that are registered for a block's circuit.

    run: whether also what its testbench measures, with the values of a run on the nominal die.
    """
    found = [Listed(m.name, m.unit, m.summary) for m in metrics_of_circuit(choice.circuit.name)]
    if run:  # whose solver is slow to import
        numbers: Mapping[str, float | None] = loaded("system.study.metrics.metric:nominal_numbers")(choice)
        about = "of the testbench's run"
        found += [Listed(name, unit_of_name(name), about, value) for name, value in numbers.items()]
    return found
