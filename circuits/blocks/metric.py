"""The contract of a metric: a number, or a word, by which a study judges a circuit on a die."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from circuits.circuit import Circuit
from circuits.lowering.kernel import Machine
from circuits.silicon.silicon import Silicon


@dataclass(frozen=True, slots=True)
class Edge:
    """Where a search over the time of a stimulus ended: on one side a spike comes, on the other none.

    beside
        Gives the testbench so far beyond the edge, s, on the side where none comes.
    resolution
        How near the search came to the edge, s.
    source
        Name of the source whose time was searched.
    port
        The watched port at which the spike comes.
    node
        Node behind whatever decides on the spike, whose peak tells how near it was.
    begin
        Time from which on the node has that peak, s.
    weight
        What the metric has of the edge.
    """

    beside: Callable[[float], Machine]
    resolution: float
    source: str
    port: str
    node: str
    begin: float
    weight: float


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
    edges
        `edges(machine, measurement)` gives the edges whose weighted sum the metric is; None for one that is
        no search.
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
    edges: Callable[[Machine, Any], Sequence[Edge]] | None = None
