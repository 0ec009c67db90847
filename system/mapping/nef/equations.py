"""The equations that a network of values asks for, without any neurons, in steps of 1 ms.

y' = (T f(x) - y) / tau of each connection and probe, and x of an ensemble the sum of what ends there; inputs
stand still in a step, and what an ensemble decodes comes a step later, as on neurons.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from chips.nef.network.kernel import DT
from chips.nef.network.network import Connection, Probe, label
from chips.nef.population import evaluate
from circuits.arrays import F64
from system.mapping.nef.network import ValueNetwork


class Equations:
    """A network of values in time, at rest at first; network: what is asked for."""

    def __init__(self, network: ValueNetwork) -> None:
        own = network.lowered()
        self._x = {e.name: np.zeros(e.dimensions) for e in network.ensembles}
        sizes = {**self._x, **{one.name: np.zeros(one.size) for one in network.inputs}}
        ends: list[Connection | Probe] = [*own.connections, *own.probes]
        self._lanes = [_Lane(one, sizes) for one in ends]
        self._probes = {
            p.name: lane for p, lane in zip(own.probes, self._lanes[len(own.connections) :], strict=True)
        }

    def set(self, name: str, values: F64) -> None:
        """Set what the input `name` gives from now on, float64[size]."""
        for lane in self._lanes:
            if lane.source == name:
                lane.last = lane.value(values)

    def read(self, name: str) -> F64:
        """Return what the probe `name` shows, float64[size]."""
        return self._probes[name].y

    def summed(self, names: Sequence[str], steps: int) -> F64:
        """Take steps, and return the sums of what probes of these names show at the end of each."""
        total = np.zeros(sum(self._probes[name].y.size for name in names))
        for _ in range(steps):
            self.step()
            total += np.concatenate([self._probes[name].y for name in names])
        return total

    def step(self) -> None:
        """Take a step."""
        for lane in self._lanes:
            lane.y = lane.last + lane.keep * (lane.y - lane.last)
        for name, before in self._x.items():
            self._x[name] = sum((lane.y for lane in self._lanes if lane.end == name), np.zeros(before.size))
        for lane in self._lanes:
            if lane.source in self._x:
                lane.last = lane.value(self._x[lane.source])


class _Lane:
    """A connection or a probe: what comes in, low-passed; sizes: a vector of each end, by name.

    last: T f(x) that comes in, and y: what is left of it behind the filter, float64[results].
    """

    def __init__(self, one: Connection | Probe, sizes: Mapping[str, F64]) -> None:
        if isinstance(one, Probe):
            self.source, self.end, self._label = one.target, one.name, one.name
        else:
            self.source, self.end, self._label = one.pre, str(one.post), label(one)
        self.keep = math.exp(-DT / one.synapse) if one.synapse > 0.0 else 0.0
        self._function, self._transform = one.function, np.asarray(one.transform, dtype=float)
        self.last = self.value(np.zeros_like(sizes[self.source]))
        self.y = np.zeros(self.last.size)

    def value(self, x: F64) -> F64:
        """T f(x)."""
        found = x if self._function is None else evaluate(self._function, x[None], self._label)[0]
        return np.asarray(self._transform @ found if self._transform.ndim else self._transform * found)
