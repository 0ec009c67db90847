"""Nodes and probes of a nengo network while it runs on the chip, called in Python every millisecond.

A step has nengo's order. Without a synapse a value is there in the same step, behind one in the next step.
Nodes that get spikes without a synapse, and those that get of such nodes without one, are called after the
neurons, all others before them. What these late nodes give to neurons without a synapse acts a step later
than in nengo.

Low-passes of spikes that nodes and probes read are the network's own. All other synapses here are nengo's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import nengo
import numpy as np

from chips.nef.nengo.errors import CallError, RefusedError
from chips.nef.nengo.plan import Plan, matrix_of, slice_of_probe, tau_of_reading
from chips.nef.network.kernel import DT
from chips.nef.simulation import Simulation
from circuits.arrays import F64

_Read = Callable[[], F64]


class _Filtered:
    """A value behind one of nengo's synapses: what is there in this step, and what was in the one before."""

    def __init__(self, read: _Read, synapse: Any, size: int) -> None:
        state = synapse.make_state((size,), (size,), DT, dtype=float)
        self._step = synapse.make_step((size,), (size,), DT, np.random.RandomState(synapse.seed), state)
        self._read, self.value, self.before = read, np.zeros(size), np.zeros(size)

    def step(self) -> None:
        """Take in what is read in this step."""
        self.before = self.value
        self.value = np.array(self._step(0.0, self._read()), dtype=float)


class Live:
    """Nodes and probes of a running network.

    Parameters
    ----------
    plan
        The network.
    run
        Its neurons.
    seed
        Seed of processes that have none of their own.
    """

    def __init__(self, plan: Plan, run: Simulation, seed: int) -> None:
        self._plan, self._run = plan, run
        nodes = plan.source.all_nodes
        ends = [c for c in plan.source.all_connections if isinstance(c.post_obj, nengo.Node)]
        self._values = {n: np.zeros(n.size_out) for n in nodes}
        self._filters: list[_Filtered] = []
        order, late = _ordered(nodes, ends)
        self._inputs: dict[Any, list[_Read]] = {n: [] for n in nodes}
        for c in ends:
            self._inputs[c.post_obj].append(self._input(c, early=c.post_obj not in late))
        rng = np.random.RandomState(seed)
        self._calls = {n: _callback(n, rng) for n in nodes}
        self._early, self._late = ([n for n in order if (n in late) == then] for then in (False, True))
        feeds = [
            (name, _weighted(c, rows, self._values), c.synapse is None and c.pre_obj not in late)
            for name, (c, rows) in plan.fed
        ]
        self.delayed = [
            c
            for c in plan.source.all_connections
            if c.synapse is None
            and not isinstance(c.post_obj, nengo.Node)
            and not (isinstance(c.pre_obj, nengo.Node) and c.pre_obj not in late)
        ]  # by which spikes act a step later than in nengo
        self._first, self._last = ([f[:2] for f in feeds if f[2] == now] for now in (True, False))
        self._spikes = run.state.spikes.copy()
        self._spiking = np.zeros(len(self._spikes))
        self.probes = {p: self._probe(p) for p in plan.source.all_probes}

    def step(self, t: float) -> None:
        """Take the step that ends at the time t, s."""
        self._call(self._early, t)
        self._feed(self._first)
        self._run.advance(DT)
        self._spiking = (self._run.state.spikes - self._spikes) / DT
        self._spikes = self._run.state.spikes.copy()
        self._call(self._late, t)
        self._feed(self._last)
        for each in self._filters:
            each.step()

    def _call(self, nodes: list[Any], t: float) -> None:
        for node in nodes:
            given = np.zeros(node.size_in)
            for read in self._inputs[node]:
                given = given + read()
            self._values[node] = self._calls[node](t, given)

    def _feed(self, feeds: list[tuple[str, _Read]]) -> None:
        for name, read in feeds:
            self._run.set(name, read())

    def _input(self, c: Any, *, early: bool) -> _Read:
        """What a node gets by a connection."""
        size = c.post_obj.size_in
        if isinstance(c.pre_obj, nengo.Node):
            read = _weighted(c, matrix_of(c, str(c)), self._values)
            return read if c.synapse is None else self._behind(read, c.synapse, size)
        return self._decoded(self._plan.read[c], c.synapse, size, early=early)

    def _decoded(self, name: str, synapse: Any, size: int, *, early: bool) -> _Read:
        """What comes of neurons, read before or after their step."""
        if tau_of_reading(synapse) is not None:
            return (lambda: self._run.coming(name)) if early else (lambda: self._run.read(name))
        if synapse is None:
            return lambda: self._run.arrived(name)
        return self._behind(lambda: self._run.arrived(name), synapse, size)

    def _behind(self, read: _Read, synapse: Any, size: int) -> _Read:
        """What a node sees of a value behind a synapse."""
        held = _Filtered(read, synapse, size)
        self._filters.append(held)
        return lambda: held.value

    def _probe(self, p: Any) -> _Read:
        """What a probe sees after a step."""
        size = size_of_probe(p)
        if p in self._plan.read:
            name = self._plan.read[p]
            if p.synapse is None or tau_of_reading(p.synapse) is not None:
                return self._decoded(name, p.synapse, size, early=False)

            def read() -> F64:
                return self._run.arrived(name)

        elif isinstance(p.obj, nengo.Node):
            read = _slice_of(self._values, p.obj, slice_of_probe(p))
        else:
            own, part = self._run.built.neurons(self._plan.names[p.obj.ensemble]), slice_of_probe(p)

            def read() -> F64:
                return np.asarray(self._spiking[own][part])

        if p.synapse is None:
            return read
        held = _Filtered(read, p.synapse, size)
        self._filters.append(held)
        return lambda: held.before


def _slice_of(values: dict[Any, F64], node: Any, part: Any) -> _Read:
    return lambda: values[node][part]


def _weighted(c: Any, rows: F64, values: dict[Any, F64]) -> _Read:
    """What a connection from a node makes of its value."""
    read, function = _slice_of(values, c.pre_obj, c.pre_slice), c.function
    if function is None:
        return lambda: rows @ read()

    def call() -> F64:
        found = function(read().copy())
        return rows @ _numbers(found, c.size_mid, f"{c}.function")

    return call


def _numbers(found: Any, size: int, label: str) -> F64:
    """What a function gave, float64[size]; a single number stands for all, as in nengo."""
    given = np.full(size, np.nan)
    try:
        given[...] = found
    except (TypeError, ValueError):
        given[...] = np.nan
    if not np.isfinite(given).all():
        raise CallError(f"{label}: {found!r}, must be {size} finite numbers")
    return given


def size_of_probe(p: Any) -> int:
    """Return how many numbers a probe sees."""
    return len(np.arange(p.obj.size_out)[slice_of_probe(p)])


def _ordered(nodes: list[Any], ends: list[Any]) -> tuple[list[Any], set[Any]]:
    """Nodes, each behind those that it gets something of without a synapse, and the late ones of them.

    ends: connections into nodes. Raises `RefusedError` for a circle.
    """
    after: dict[Any, set[Any]] = {n: set() for n in nodes}
    late = set()
    for c in ends:
        if c.synapse is None and isinstance(c.pre_obj, nengo.Node):
            after[c.post_obj].add(c.pre_obj)
        elif c.synapse is None:
            late.add(c.post_obj)
    order: list[Any] = []
    left: Mapping[Any, set[Any]] = after
    while left:
        ready = [n for n, before in left.items() if not before & left.keys()]
        if not ready:
            raise RefusedError(f"{next(iter(left))}: in a circle of nodes without a synapse; put one in")
        order += ready
        left = {n: b for n, b in left.items() if n not in ready}
    for node in order:
        if after[node] & late:
            late.add(node)
    return order, late


def _callback(node: Any, rng: np.random.RandomState) -> Callable[[float, F64], F64]:
    """What a node gives at a time for its input."""
    output, size = node.output, node.size_out
    if output is None:
        return lambda _, x: x
    if isinstance(output, nengo.base.Process):
        return _process(output, node, rng)
    if not callable(output):
        if not isinstance(output, np.ndarray):
            raise RefusedError(f"{node}.output: {output!r}, must be numbers, a function or a process")
        constant = np.array(output, dtype=float).ravel()
        return lambda _t, _x: constant

    def call(t: float, x: F64) -> F64:
        found = output(t, x.copy()) if node.size_in else output(t)
        return np.zeros(0) if size == 0 else _numbers(found, size, f"{node}.output")

    return call


def _process(process: Any, node: Any, rng: np.random.RandomState) -> Callable[[float, F64], F64]:
    shape_in, shape_out = (node.size_in,), (node.size_out,)
    state = process.make_state(shape_in, shape_out, DT)
    step = process.make_step(shape_in, shape_out, DT, process.get_rng(rng), state)
    if node.size_in:
        return lambda t, x: np.array(step(t, x), dtype=float)
    return lambda t, _: np.array(step(t), dtype=float)
