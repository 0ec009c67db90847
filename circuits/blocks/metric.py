"""What a metric is: a number, or a word, that a machine on a die is judged by."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from circuits.circuit import Circuit
from circuits.lowering.kernel import Machine
from circuits.silicon.silicon import Silicon


@dataclass(frozen=True, slots=True)
class Metric:
    """A metric of the blocks whose circuits are called `circuits`.

    `prepare(circuit, silicon)` is the machine to measure, `measure(machine)` a measurement that several
    metrics can share, `outcome` and `reason` of it a word and why it failed (empty unless it did), and
    `value` of it the metric, in `unit` (SI), NaN where it is not defined; None for a metric that is the
    outcome itself. yes_no: it is 1 or 0, for yes or no. `shown` of it are stimuli of the block's testbench
    that show what was measured, for a measurement that makes runs of its own.
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
