"""The contract of a metric: a number, or a word, by which a study judges a circuit on a die."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from circuits.circuit import Circuit
from circuits.lowering.kernel import Machine
from circuits.silicon.silicon import Silicon


@dataclass(frozen=True, slots=True)
class Metric:
    """A metric of the circuits whose names are in `circuits`.

    name, unit, summary
        What studies call it, its SI unit (empty for a plain number), and a line about it.
    prepare
        `prepare(circuit, silicon)` returns the machine that is measured.
    measure
        `measure(machine)` returns a measurement, which several metrics can share.
    outcome, reason
        What happened in a measurement, in a word, and why it failed, empty unless it did.
    value
        The metric of a measurement, NaN where it is not defined; None where the metric is the outcome itself.
    yes_no
        Whether the metric is 1 or 0, for yes or no.
    shown
        Knobs of the block's testbench, in SI units, that show what was measured, where the measurement makes
        runs of its own.
    missing
        Why a measurement has no value of the metric; None for a metric that does not say.
    """

    name: str
    unit: str
    summary: str
    circuits: tuple[str, ...]
    prepare: Callable[[Circuit, Silicon], Machine]
    measure: Callable[[Machine], Any]
    outcome: Callable[[Any], str]
    reason: Callable[[Any], str]
    value: Callable[[Any], float] | None
    yes_no: bool = False
    shown: Callable[[Any], Mapping[str, float | None]] | None = None
    missing: Callable[[Any], str] | None = None
