"""Comparison of two circuits: whether they are the same, and where they differ.

The order of devices, the hierarchy, and the names of devices and inner nodes do not count. Both circuits are
flattened. Ports are matched by name, without regard to case; an element `spike[3]` also matches `spike#3`.
Colour refinement (`netlists.compare.refinement`) tells devices and nodes apart by their surroundings. A node
whose colour no other node has is matched by it. Without these nodes the circuits fall into pieces
(`netlists.compare.pieces`). Where a colour repeats inside a piece, networkx matches it, so that "equal" means
that there is an isomorphism.

Sizes and deviations are equal within `TOLERANCE`, relative: values are sorted over both circuits, and
neighbours that are that close count as one value. Devices in parallel are not merged. Stimuli and the kinds
of ports do not count.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Literal

import numpy as np

from circuits.arrays import U64, Bools
from circuits.circuit import Circuit
from netlists.compare.pair import Deviations, FlatDevice, Pair, pair_of
from netlists.compare.pieces import unlike_pieces
from netlists.compare.refinement import Colours, class_count, first_colours, label, mix, refine

TOLERANCE = 1e-9
SHOWN = 10  # differences

Kind = Literal["port", "device", "node", "size"]


@dataclass(frozen=True, slots=True)
class Difference:
    """A difference between two circuits.

    Attributes
    ----------
    kind : str
        What differs: a port, a device or node, or a size.
    path : str
        Where: the path in the first circuit, or else in the second.
    text : str
        A line that tells the difference.
    """

    kind: Kind
    path: str
    text: str

    def __str__(self) -> str:
        return f"{self.kind} {self.path}: {self.text}"


@dataclass(frozen=True, slots=True)
class Comparison:
    """What a comparison of two circuits has found.

    Attributes
    ----------
    devices : (int, int)
        Number of devices of both circuits.
    nodes : (int, int)
        Number of nodes of both circuits, ground left out.
    differences : tuple of Difference
        The first differences; none where the circuits are equal.
    """

    devices: tuple[int, int]
    nodes: tuple[int, int]
    differences: tuple[Difference, ...]

    @property
    def equal(self) -> bool:
        """Whether the circuits are the same."""
        return not self.differences


def compare(
    a: Circuit, b: Circuit, *, deviations: tuple[Deviations, Deviations] = ({}, {}), most: int = SHOWN
) -> Comparison:
    """Compare two circuits, whatever their names, order and hierarchy.

    Parameters
    ----------
    a, b
        The circuits.
    deviations
        For each circuit, what its transistors deviate by: by instance path.
    most
        How many differences are returned at most: those of ports first, then of devices and nodes, then of
        sizes.

    Raises
    ------
    ParameterError
        A circuit has more than 2,000,000 devices.
    """
    pair = pair_of(a, b, deviations)
    found = tuple(islice(_differences(pair), most))
    devices = pair.devices_a, len(pair.devices) - pair.devices_a
    nodes = pair.nodes_a - 1, len(pair.node_names) - pair.nodes_a - 1
    return Comparison(devices, nodes, found)


def _differences(pair: Pair) -> Iterator[Difference]:
    """All differences of the first of four kinds that there is: ports, connections, sizes, pieces."""
    ports = list(_different_ports(pair))
    if ports:
        yield from ports
        return
    plain = np.zeros(len(pair.devices), dtype=np.uint64)
    rounds = _refined(pair, plain)
    if not pair.agree(rounds[-1]):
        yield from _different_connections(pair, rounds)
        return
    sized = _refined(pair, _size_labels(pair.devices))
    if not pair.agree(sized[-1]):
        yield from _different_sizes(pair, rounds[-1], sized[-1])
        return
    for piece, first, second in unlike_pieces(pair, sized[-1]):
        counts = f"{first} in the first, {second} in the second"
        yield Difference(
            "device", pair.devices[piece[0]].path, f"pieces like its own, {counts}, differ inside"
        )


def _refined(pair: Pair, device_label: U64) -> list[Colours]:
    """Colours after each round, until no more colours split or the circuits disagree for the second time."""
    colours = first_colours(pair.structure, device_label)
    rounds, count, disagreed = [colours], class_count(colours), 0
    while True:
        colours = refine(pair.structure, colours)
        rounds.append(colours)
        disagreed += not pair.agree(colours)
        del rounds[1:-3]
        new = class_count(colours)
        if disagreed == 2 or new == count:
            return rounds
        count = new


def _different_ports(pair: Pair) -> Iterator[Difference]:
    for here, there, where in ((*pair.ports, "first"), (*pair.ports[::-1], "second")):
        for key, node in here.items():
            if key not in there:
                yield Difference("port", pair.node_names[node], f"only in the {where}")


def _different_connections(pair: Pair, rounds: Sequence[Colours]) -> Iterator[Difference]:
    """What has no counterpart in the earliest round in which something has none."""
    counts = [
        Counter(d.kind for d in part)
        for part in (pair.devices[: pair.devices_a], pair.devices[pair.devices_a :])
    ]
    for kind in sorted({*counts[0], *counts[1]}):
        if counts[0][kind] != counts[1][kind]:
            yield Difference(
                "device", kind, f"{counts[0][kind]} in the first, {counts[1][kind]} in the second"
            )
    for colours in rounds[1:]:
        devices = _alone(pair.parted(colours.device, "device"))
        nodes = _alone((colours.node[: pair.nodes_a], colours.node[pair.nodes_a :]), pair.used)
        if devices or nodes:
            yield from _device_differences(pair, devices or _moved_devices(pair, nodes))
            yield from _node_differences(pair, nodes)
            return
    if counts[0] == counts[1]:  # the same surroundings, but not equally often
        yield Difference("node", pair.node_names[1], "the circuits are connected otherwise")


def _alone(pair: tuple[U64, U64], used: Bools | None = None) -> list[int]:
    """Numbers over pair circuits of what has a colour that the other circuit does not have."""
    a, b = pair
    lone = np.concatenate([~np.isin(a, b), ~np.isin(b, a)])
    numbers: list[int] = np.flatnonzero(lone if used is None else lone & used).tolist()
    return numbers


def _device_differences(pair: Pair, numbers: Sequence[int]) -> Iterator[Difference]:
    first = {pair.devices[k].path.lower(): pair.devices[k] for k in numbers if k < pair.devices_a}
    second = {pair.devices[k].path.lower(): pair.devices[k] for k in numbers if k >= pair.devices_a}
    for path, device in first.items():
        other = second.get(path)
        if other is None:
            yield Difference("device", device.path, f"{_described(pair, device)} has no like in the second")
        else:
            yield Difference("device", device.path, _moved(pair, device, other))
    for path, device in second.items():
        if path not in first:
            yield Difference("device", device.path, f"{_described(pair, device)} has no like in the first")


def _moved_devices(pair: Pair, nodes: Sequence[int]) -> list[int]:
    """Devices at some nodes whose namesake in the other circuit has a terminal at a node of another name."""
    wanted = set(nodes)
    names = pair.node_names
    at = [[names[n].lower() for n in device.nodes] for device in pair.devices]
    by_path: dict[str, list[int]] = defaultdict(list)
    for k, device in enumerate(pair.devices):
        by_path[device.path.lower()].append(k)
    numbers = (k for k, device in enumerate(pair.devices) if not wanted.isdisjoint(device.nodes))
    twins = {pair.devices[k].path.lower(): by_path[pair.devices[k].path.lower()] for k in numbers}
    return [k for two in twins.values() if len(two) == 2 and at[two[0]] != at[two[1]] for k in two]


def _described(pair: Pair, device: FlatDevice) -> str:
    pairs = zip(device.terminals, device.nodes, strict=True)
    return f"{device.kind} of " + " ".join(f"{t}={pair.node_names[n]}" for t, n in pairs)


def _moved(pair: Pair, a: FlatDevice, b: FlatDevice) -> str:
    if a.kind != b.kind:
        return f"{a.kind} in the first, {b.kind} in the second"
    names = pair.node_names
    moved = [
        f"{t} at {names[m]} in the first, {names[n]} in the second"
        for t, m, n in zip(a.terminals, a.nodes, b.nodes, strict=True)
        if names[m].lower() != names[n].lower()
    ]
    return ", ".join(moved) or f"{_described(pair, a)}: what its nodes connect to differs"


def _node_differences(pair: Pair, numbers: Sequence[int]) -> Iterator[Difference]:
    wanted = set(numbers)
    ends: dict[int, list[str]] = defaultdict(list)
    for device in pair.devices:
        for terminal, node in zip(device.terminals, device.nodes, strict=True):
            if node in wanted:
                ends[node].append(f"{device.path}.{terminal}")
    for node in numbers:
        where = "first" if node < pair.nodes_a else "second"
        more = f" and {len(ends[node]) - 6} more" if len(ends[node]) > 6 else ""
        listed = ", ".join(ends[node][:6]) + more or "nothing"
        yield Difference("node", pair.node_names[node], f"in the {where} it connects {listed}")


def _size_labels(devices: Sequence[FlatDevice]) -> U64:
    """One label for all sizes of a device, equal for values that are within the tolerance: uint64[D]."""
    found: dict[tuple[str, str], list[tuple[float, int]]] = defaultdict(list)
    for k, device in enumerate(devices):
        for name, value in device.sizes:
            if value != 0.0 or not name.startswith("deviation"):
                found[device.kind, name].append((value, k))
    total = np.zeros(len(devices), dtype=np.uint64)
    for (kind, name), pairs in found.items():
        values, owner = np.array([v for v, _ in pairs]), np.array([k for _, k in pairs])
        order = np.argsort(values, kind="stable")
        ordered = values[order]
        size = np.maximum(np.abs(ordered[1:]), np.abs(ordered[:-1]))
        far = np.diff(ordered) > TOLERANCE * size
        group = np.concatenate([[0], np.cumsum(far)]).astype(np.uint64)
        seed = np.uint64(label(f"{kind} {name}"))
        total[owner[order]] += mix(mix(group + np.uint64(1)) ^ seed)
    return total


def _different_sizes(pair: Pair, plain: Colours, sized: Colours) -> Iterator[Difference]:
    """Pair devices of the same surroundings, of the same path first, and name the sizes that differ."""
    own = _size_labels(pair.devices)
    waiting: dict[int, tuple[list[int], list[int]]] = defaultdict(lambda: ([], []))
    for k, colour in enumerate(plain.device.tolist()):
        waiting[colour][k >= pair.devices_a].append(k)
    some = False
    for first, second in waiting.values():
        surplus = _unpaired(first, second, own)
        for m, n in _by_path(pair.devices, *surplus):
            some = True
            yield from _size_differences(pair.devices[m], pair.devices[n])
    if not some:  # every surrounding has its sizes, but not side by side
        for k in _alone(pair.parted(sized.device, "device"))[:SHOWN] or [0]:
            yield Difference(
                "size", pair.devices[k].path, "its sizes stand beside others in the other circuit"
            )


def _unpaired(first: list[int], second: list[int], own: U64) -> tuple[list[int], list[int]]:
    """Leave out as many devices of each label as pair have."""
    a, b = Counter(own[first].tolist()), Counter(own[second].tolist())
    common = a & b
    if common.total() == len(first):
        return [], []
    return _without(first, own, common.copy()), _without(second, own, common.copy())


def _without(numbers: list[int], own: U64, common: Counter[int]) -> list[int]:
    left = []
    for k in numbers:
        if common[int(own[k])] > 0:
            common[int(own[k])] -= 1
        else:
            left.append(k)
    return left


def _by_path(
    devices: Sequence[FlatDevice], first: Sequence[int], second: Sequence[int]
) -> Iterator[tuple[int, int]]:
    by_path = {devices[n].path.lower(): n for n in second}
    rest = []
    for m in first:
        n = by_path.pop(devices[m].path.lower(), None)
        if n is None:
            rest.append(m)
        else:
            yield m, n
    yield from zip(rest, by_path.values(), strict=True)


def _size_differences(a: FlatDevice, b: FlatDevice) -> Iterator[Difference]:
    left, right = dict(a.sizes), dict(b.sizes)
    other = "" if a.path.lower() == b.path.lower() else f" ({b.path})"
    for name in {**left, **right}:
        m, n = left.get(name, 0.0), right.get(name, 0.0)
        if abs(m - n) > TOLERANCE * max(abs(m), abs(n)):
            yield Difference("size", a.path, f"{name} {m!r} in the first, {n!r} in the second{other}")
