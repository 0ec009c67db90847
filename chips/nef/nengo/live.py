"""Nodes and probes of a nengo network while it runs on the chip, called in Python every millisecond."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import nengo
import numpy as np

from chips.nef.nengo.plan import Plan, matrix_of, slice_of_probe, tau_of
from chips.nef.network.kernel import DT
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.errors import ParameterError, TopologyError


@dataclass(slots=True)
class _Link:
    """What ends at a node: where it comes from, a low-pass, and where it goes."""

    read: Callable[[], F64]
    keep: float  # 0: no synapse
    matrix: F64
    function: Callable[[F64], Any] | None = None
    value: F64 = field(init=False)

    def __post_init__(self) -> None:
        """Begin at 0, as nengo's low-pass does."""
        self.value = np.zeros(len(self.matrix))

    def step(self) -> F64:
        """The low-passed input of this step."""
        given = self.read()
        given = self.matrix @ (given if self.function is None else np.ravel(self.function(given)))
        self.value = given + self.keep * (self.value - given)
        return self.value


class Live:
    """Nodes and probes of a running network."""

    def __init__(self, plan: Plan, run: Simulation) -> None:
        self.run = run
        network = plan.source
        self.values = {n: np.zeros(n.size_out) for n in network.all_nodes}
        self.links: dict[Any, list[_Link]] = {n: [] for n in network.all_nodes}
        after: dict[Any, set[Any]] = {n: set() for n in network.all_nodes}
        for c in network.all_connections:
            if not isinstance(c.post_obj, nengo.Node):
                continue
            if isinstance(c.pre_obj, nengo.Node):
                pre = c.pre_obj
                tau = tau_of(c.synapse, str(c))
                read = _slice_of(self.values, pre, c.pre_slice)
                self.links[c.post_obj].append(_Link(read, _keep(tau), matrix_of(c, str(c)), c.function))
                if tau == 0.0:
                    after[c.post_obj].add(pre)
            else:
                name = plan.read[c]
                self.links[c.post_obj].append(_Link(_reader(run, name), 0.0, np.eye(c.post_obj.size_in)))
        self.order = _ordered(after)
        self.calls = {n: _callback(n, plan.seeds) for n in self.order}
        self.fed = [(name, c, rows) for name, (c, rows) in plan.fed]
        self.before = run.state.spikes.copy()
        self.spiking = np.zeros(len(self.before))
        self.probes = {p: self._probe(p, plan) for p in network.all_probes}

    def step(self, t: float) -> None:
        """Call the nodes, set what they give, and go on by a step."""
        for node in self.order:
            given = np.zeros(node.size_in)
            for link in self.links[node]:
                given = given + link.step()
            self.values[node] = self.calls[node](t, given)
        for name, c, rows in self.fed:
            value = self.values[c.pre_obj][c.pre_slice]
            self.run.set(name, rows @ (value if c.function is None else np.ravel(c.function(value))))
        self.run.advance(DT)
        self.spiking = (self.run.state.spikes - self.before) / DT
        self.before = self.run.state.spikes.copy()

    def _probe(self, p: Any, plan: Plan) -> Callable[[], F64]:
        if p in plan.read:
            return _reader(self.run, plan.read[p])
        if isinstance(p.obj, nengo.Node):
            read = _slice_of(self.values, p.obj, slice_of_probe(p))
        else:
            own, part = self.run.built.neurons(plan.names[p.obj.ensemble]), slice_of_probe(p)

            def read() -> F64:
                return np.asarray(self.spiking[own][part])

        size = size_of_probe(p)
        return _Link(read, _keep(tau_of(p.synapse, str(p))), np.eye(size)).step


def _keep(tau: float) -> float:
    return float(np.exp(-DT / tau)) if tau > 0.03 * DT else 0.0


def _slice_of(values: dict[Any, F64], node: Any, part: Any) -> Callable[[], F64]:
    return lambda: values[node][part]


def _reader(run: Simulation, name: str) -> Callable[[], F64]:
    return lambda: run.read(name)


def size_of_probe(p: Any) -> int:
    """Return how many numbers a probe sees."""
    return len(np.arange(p.obj.size_out)[slice_of_probe(p)])


def _ordered(after: Mapping[Any, set[Any]]) -> list[Any]:
    """Nodes, each behind those that it gets something of without a synapse; refuses circles."""
    done: list[Any] = []
    left = dict(after)
    while left:
        ready = [n for n, before in left.items() if not before & left.keys()]
        if not ready:
            raise TopologyError(f"{next(iter(left))}: in a circle of nodes without a synapse; put one in")
        done += ready
        left = {n: b for n, b in left.items() if n not in ready}
    return done


def _callback(node: Any, seeds: Mapping[Any, int]) -> Callable[[float, F64], F64]:
    """What a node gives at a time for its input."""
    output, size = node.output, node.size_out
    if output is None:
        return lambda _, x: x
    if isinstance(output, nengo.base.Process):
        return _process(output, node, seeds[node])
    if not callable(output):
        constant = np.array(output, dtype=float).ravel()
        return lambda _t, _x: constant

    def call(t: float, x: F64) -> F64:
        found = output(t, x.copy()) if node.size_in else output(t)
        if size == 0:
            return np.zeros(0)
        given = np.zeros(0) if found is None else np.asarray(found, dtype=float).ravel()
        if given.size != size or not np.isfinite(given).all():
            raise ParameterError(f"{node}.output: {found!r}, must be {size} finite numbers")
        return given

    return call


def _process(process: Any, node: Any, seed: int) -> Callable[[float, F64], F64]:
    shape_in, shape_out = (node.size_in,), (node.size_out,)
    rng = process.get_rng(np.random.RandomState(seed))
    state = process.make_state(shape_in, shape_out, DT)
    step = process.make_step(shape_in, shape_out, DT, rng, state)
    if node.size_in:
        return lambda t, x: np.array(step(t, x), dtype=float)
    return lambda t, _: np.array(step(t), dtype=float)
