"""Checks of a circuit's wiring: floating gates, nodes without a path for direct current, loops of supplies.

Every error names the first device or node that is wired wrongly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn

import numpy as np

from circuits.arrays import I64
from circuits.circuit import Circuit
from circuits.devices import ControlledSource, Transistor
from circuits.devices.source import Source
from circuits.errors import TopologyError
from circuits.lowering.flatten import FlatCircuit, flatten


def check_circuit(circuit: Circuit) -> None:
    """Check a circuit by itself, with its input ports taken as driven.

    Raises `TopologyError`, which names the instance path of the first device or node that is wired wrongly.
    """
    flat = flatten(circuit)
    driven = [int(n) for p in circuit.ports if p.direction == "in" for n in flat.ports[p.name].ravel()]
    check_flat(flat, driven)


def check_flat(flat: FlatCircuit, driven: Sequence[int]) -> None:
    """Raise `TopologyError` unless direct current can flow from every node to ground or to a driven node."""
    a, b = _conducting_pairs(flat)
    n = flat.count
    roots = np.unique(np.concatenate([[0], np.asarray(driven, dtype=np.int64)]))
    a, b = np.concatenate([a, roots]), np.concatenate([b, np.zeros(roots.size, dtype=np.int64)])
    _check_used(flat)
    islands = np.flatnonzero(_lowest_joined(n, a, b))
    if islands.size:
        _raise_floating(flat, islands)


def _lowest_joined(n: int, a: I64, b: I64) -> I64:
    """Lowest of the n nodes that each is joined with, where nodes a[k] and b[k] are; int64[n].

    SciPy's `connected_components` is slower to import than all of a small circuit's lowering.
    """
    lowest = np.arange(n)
    while True:
        last = lowest.copy()
        low = np.minimum(lowest[a], lowest[b])
        np.minimum.at(lowest, lowest[a], low)
        np.minimum.at(lowest, lowest[b], low)
        lowest = lowest[lowest]
        if (lowest == last).all():
            return lowest


def _check_used(flat: FlatCircuit) -> None:
    """Require a device at every node, ground apart."""
    used = np.zeros(flat.count, dtype=np.bool_)
    used[0] = True
    for group in flat.groups:
        used[group.nodes] = True
    if used.all():
        return
    number = int(np.argmin(used))
    node = flat.node_name(number)
    if any((nodes == number).any() for nodes in flat.ports.values()):
        raise TopologyError(f"{flat.circuit.name}.{node}: unconnected port; nothing inside uses it")
    raise TopologyError(f"{node}: unconnected node; nothing uses it, leave it out or connect it")


def _raise_floating(flat: FlatCircuit, islands: I64) -> NoReturn:
    for group in flat.groups:
        if isinstance(group.device, Transistor):
            floating = np.flatnonzero(np.isin(group.nodes[1], islands))
            if floating.size:
                k = int(floating[0])
                node = flat.node_name(int(group.nodes[1, k]))
                raise TopologyError(
                    f"{group.label(k)}.gate: floating gate, node {node} has no path for direct current;"
                    " drive it or bias it"
                )
    node = flat.node_name(int(islands[0]))
    raise TopologyError(
        f"{node}: no path for direct current to ground or a supply; connect a conducting device"
    )


def check_supplies(flat: FlatCircuit, sources: Sequence[Source]) -> list[tuple[int, int]]:
    """Node and source of every voltage source; raises `TopologyError` where two of them drive one node."""
    fixed: dict[int, int] = {0: -1}
    names: set[str] = set()
    for k, source in enumerate(sources):
        source.check()
        if source.name in names:
            raise TopologyError(f"{source.name}: duplicate source name; rename one")
        names.add(source.name)
        if source.quantity == "current":
            continue
        for node in flat.port_nodes(source.node):
            if int(node) in fixed:
                other = "ground" if node == 0 else sources[fixed[int(node)]].name
                raise TopologyError(
                    f"{source.name}: supply loop with {other} at node {flat.node_name(int(node))}; remove one"
                )
            fixed[int(node)] = k
    return [(node, k) for node, k in fixed.items() if k >= 0]


def _conducting_pairs(flat: FlatCircuit) -> tuple[I64, I64]:
    a, b = _back_to_back(flat)
    for group in flat.groups:
        for i, j in group.device.conducting():
            a.append(group.nodes[i])
            b.append(group.nodes[j] if j >= 0 else np.zeros_like(group.nodes[i]))
    return np.concatenate(a), np.concatenate(b)


def _back_to_back(flat: FlatCircuit) -> tuple[list[I64], list[I64]]:
    """Ends of controlled sources that pass direct current: one that is a conductance, two that are a gyrator.

    One alone is no path. Where its control are its own ends it is a conductance; where another one is
    controlled by its ends and drives its control, each passes what the other asks for.
    """
    ends: dict[tuple[frozenset[int], frozenset[int]], tuple[int, int]] = {}
    for group in flat.groups:
        if isinstance(group.device, ControlledSource):
            for p, n, high, low in group.nodes.T.tolist():
                ends[frozenset((p, n)), frozenset((high, low))] = p, n
    found = [pair for (own, control), pair in ends.items() if (control, own) in ends]
    pairs = np.array(found, dtype=np.int64).reshape(-1, 2)
    return [pairs[:, 0]], [pairs[:, 1]]
