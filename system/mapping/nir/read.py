"""A graph of NIR as a network of populations.

Neurons become populations, what leads from one to the next becomes connections: weights are followed through
all linear nodes, graphs within graphs and loops among them. With the neuron's

    LIF      tau dv/dt = v_leak - v + R I                          I: a pulse of area w at each event
    CubaLIF  tau_syn dI/dt = -I + w_in S,  tau_mem dv/dt = v_leak - v + R I
    LI       tau dv/dt = v_leak - v + R I, before a neuron: its synapses

a weight w is R w / (v_threshold tau_s) in the network's units (`system.mapping.network`), tau_s being that of
CubaLIF or LI, or where pulses reach the membrane at once `DIRECT`, or `SHARE` of the membrane's if longer;
v_threshold counts from v_leak, which must be v_reset. NIR knows no refractory period: it is 0. Populations
and inputs come in the order of the file, which NIR sorts by name.

A bias is a constant current: an input of its own, `NODE.bias`, whose regular events (`RATE`) bring it in the
mean, through the same synapses as the weights beside it.

By the letter of the standard an event is a pulse of area 1 in the graph's time, and that is in seconds.
Frameworks that count in steps mean otherwise (`Times`): a spike is a 1 for one step of theirs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from chips.rolls.program.nir import nir_package
from circuits.arrays import F64
from circuits.errors import DataError, ParameterError
from system.files.aedat4 import UNREADABLE
from system.mapping.network import Connection, Input, Network, Population, Probe
from system.mapping.nir.nodes import (
    DIRECT,
    NODES,
    RATE,
    REMEDY,
    SHARE,
    SLOW,
    How,
    added,
    bias_of,
    check_linear,
    is_linear,
    linear,
)

SUFFIX = ".nir"
ORDER = "order"  # key of the metadata that tells in which order a network has its groups
NEURONS = ("LIF", "CubaLIF", "IF")
_KNOWN = {node.type: node for node in NODES}
_AXES = 3  # of what a convolution takes: channels, rows, columns
_ALIKE = 1e-3  # by which the time constants of a node's neurons may differ; ours


@dataclass(frozen=True, slots=True)
class Times:
    """What a graph's numbers mean in seconds.

    unit : what 1 is of its time constants, s; event : area of an event, s, `unit` where None. Raises
    `ParameterError` where they are not above 0.
    """

    unit: float = 1.0
    event: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("unit", self.unit), ("event", self.event)):
            if value is not None and not 0.0 < value < np.inf:
                raise ParameterError(f"graph.{name}: {value:g} s, must be above 0")

    @property
    def area(self) -> float:
        """Area of an event in the graph's own time."""
        return 1.0 if self.event is None else self.event / self.unit


STANDARD = Times()


class Judged(NamedTuple):
    """A node of a graph as it is read: its path and type, how (`Node`), and what of it or why not."""

    where: str
    type: str
    how: How
    note: str


@dataclass(frozen=True, slots=True)
class Flat:
    """A graph without graphs in it: nodes by path, what follows each, and its outer inputs and outputs."""

    nodes: Mapping[str, Any]
    after: Mapping[str, tuple[str, ...]]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


class Way(NamedTuple):
    """A way through linear nodes.

    node : where it has come to; signal : what arrives, float64[*shape, sources]; tau : of the filter on the
    way, s, None without one; before : the nodes on the way.
    """

    node: str
    signal: F64
    tau: float | None
    before: tuple[str, ...]


def read_nir(path: str | Path, times: Times = STANDARD) -> Network:
    """Read the file of NIR at `path` as a network.

    Raises `DataError` without the package nir, for a file that is none, and with the node's name where a
    network cannot be what the graph is.

    Parameters
    ----------
    path
        The file.
    times
        What its numbers mean in seconds.
    """
    graph = read_graph(path)
    try:
        return network_of_graph(graph, times)
    except ParameterError as error:
        raise DataError(f"{path}: {error}") from None


def read_graph(path: str | Path) -> Any:
    """Return the graph of a file, a `nir.NIRGraph`; raises `DataError` where it is none.

    Shapes need not agree, as where a framework leaves a batch's axis in them: weights are followed.
    """
    nir = nir_package()
    unchecked = {"type_check": False} if "type_check" in signature(nir.read).parameters else {}
    try:
        return nir.read(Path(path), **unchecked)
    except (*UNREADABLE, AssertionError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:80] or type(error).__name__
        raise DataError(f"{path}: {reason}, must be a graph of NIR; nir.write makes one") from None


def judged(graph: Any) -> tuple[Judged, ...]:
    """Return how each node of a graph is read, one by one: faithful, approximate or refused."""
    return tuple(_judged(where, node) for where, node in _flat(graph).nodes.items())


def network_of_graph(graph: Any, times: Times = STANDARD) -> Network:
    """Return the network that `graph`, a `nir.NIRGraph`, is.

    Raises `ParameterError`, which names the node and what to do, where a network cannot be that.
    """
    flat = _flat(graph)
    wrong = [each for each in judged(graph) if each.how == "refused"]
    if wrong:
        more = f"; {len(wrong) - 1} more nodes cannot be either" if len(wrong) > 1 else ""
        raise ParameterError(f"{wrong[0].note}{more}")
    sources = [name for name in flat.nodes if _is_source(flat, name)]
    told = str((getattr(graph, "metadata", None) or {}).get(ORDER, "")).splitlines()
    if sorted(told) == sorted(sources):
        sources = told
    shapes: dict[str, tuple[int, ...]] = {}
    ways = {name: tuple(_ways(flat, name, shapes)) for name in sources}
    if len(ways) == len(flat.inputs):
        raise ParameterError(f"graph: no neuron, must have one of {', '.join(NEURONS)}; add it")
    sizes = {name: _size(flat, name, ways) for name in ways}
    populations = tuple(
        _population(name, flat.nodes[name], sizes[name], times.unit)
        for name in ways
        if name not in flat.inputs
    )
    biases = {f"{node}.bias": tuple(_biased(flat, node, shapes, times)) for node in _biases(flat, shapes)}
    inputs = (
        *(Input(name, sizes[name]) for name in ways if name in flat.inputs),
        *(Input(name, 1, RATE) for name in biases),
    )
    connections: list[tuple[tuple[str, ...], Connection]] = []
    probes: list[Probe] = []
    for name, found in {**ways, **biases}.items():
        for way in found:
            if way.node in flat.outputs:
                _check_readout(name, way)
                _check_alone(name, way.node, probes)
                probes += [Probe(way.node, name, *(() if way.tau is None else (times.unit * way.tau,)))]
            else:
                made = _connection(name, way, flat.nodes[way.node], sizes[way.node], times)
                connections.append((way.before, made))
    ordered = tuple(one for _, one in sorted(connections, key=lambda each: _natural(each[0])))
    return Network(populations, inputs, tuple(c for c in ordered if np.any(c.matrix)), tuple(probes))


def _judged(where: str, node: Any) -> Judged:
    kind = type(node).__name__
    try:
        _check_node(where, node)
    except ParameterError as error:
        return Judged(where, kind, "refused", str(error))
    if is_linear(node) and bias_of(node).any():
        note = f"weights, and a bias: regular events at {RATE:g} Hz of an input of its own"
        return Judged(where, kind, "approximate", note)
    if is_linear(node):  # a delay of 0 too
        return Judged(where, kind, "faithful", _KNOWN[kind].note if kind != "Delay" else "none, of 0")
    return Judged(where, kind, _KNOWN[kind].rolls, _KNOWN[kind].note)


def _check_node(where: str, node: Any) -> None:
    """Raise `ParameterError` for a node that no network has, by itself."""
    kind = type(node).__name__
    if kind not in _KNOWN:
        raise ParameterError(f"{where}: {kind}, is no node that NIR has; they are {', '.join(_KNOWN)}")
    if _KNOWN[kind].rolls == "refused" and not is_linear(node):
        raise ParameterError(f"{where}: {kind}, is refused on rolls, {_KNOWN[kind].note}; {REMEDY[kind]}")
    if is_linear(node):
        check_linear(where, node)
    if kind in NEURONS:
        _population(where, node, 1, 1.0)
    if kind == "CubaLIF":
        _one_value(where, "tau_syn", node.tau_syn)
    if kind == "LI":
        _check_zero(where, node, "v_leak")
        _one_value(where, "tau", node.tau)


def _flat(graph: Any) -> Flat:
    nodes: dict[str, Any] = {}
    edges: list[tuple[str, str]] = []
    ends: dict[str, tuple[list[str], list[str]]] = {}
    _gather(graph, "", nodes, edges, ends)
    after: dict[str, list[str]] = {name: [] for name in nodes}
    for before, behind in edges:
        for source in ends[before][1] if before in ends else [before]:
            after[source] += ends[behind][0] if behind in ends else [behind]
    inner = [name for inputs, outputs in ends.values() for name in (*inputs, *outputs)]
    kinds = {name: type(node).__name__ for name, node in nodes.items()}
    inputs = tuple(n for n, kind in kinds.items() if kind == "Input" and n not in inner)
    outputs = tuple(n for n, kind in kinds.items() if kind == "Output" and n not in inner)
    return Flat(nodes, {k: tuple(v) for k, v in after.items()}, inputs, outputs)


def _gather(
    graph: Any, path: str, nodes: dict[str, Any], edges: list[tuple[str, str]],
    ends: dict[str, tuple[list[str], list[str]]],
) -> None:  # fmt: skip
    """Add the nodes of a graph and of those in it by path; ends: inputs and outputs of inner graphs."""
    edges += [(f"{path}{a}", f"{path}{b}") for a, b in graph.edges]
    for name, node in graph.nodes.items():
        where = f"{path}{name}"
        if where in nodes or where in ends:
            raise ParameterError(f"{where}: is the path of two nodes, must be of one; rename one of them")
        if type(node).__name__ != "NIRGraph":
            nodes[where] = node
            continue
        _gather(node, f"{where}.", nodes, edges, ends)
        ends[where] = (
            [f"{where}.{n}" for n, x in node.nodes.items() if type(x).__name__ == "Input"],
            [f"{where}.{n}" for n, x in node.nodes.items() if type(x).__name__ == "Output"],
        )


def _is_source(flat: Flat, name: str) -> bool:
    return type(flat.nodes[name]).__name__ in NEURONS or name in flat.inputs


def _ways(flat: Flat, source: str, shapes: dict[str, tuple[int, ...]]) -> Iterator[Way]:
    """All ways from a source to neurons and outputs; fills the shapes of what linear nodes give."""
    shape = _shape(flat.nodes[source])
    size = int(np.prod(shape))
    # one entry tells whether shapes fit; all would be gigabytes of a graph that is none of a network
    entries = size if any(type(node).__name__ in NEURONS for node in flat.nodes.values()) else 1
    start = np.eye(size, entries).reshape(*shape, entries)
    yield from _followed(flat, [Way(name, start, None, ()) for name in flat.after[source]], shapes)


def _biases(flat: Flat, shapes: Mapping[str, tuple[int, ...]]) -> Iterator[str]:
    """Linear nodes with a bias, of those that something leads to."""
    return (name for name in flat.nodes if name in shapes and bias_of(flat.nodes[name]).any())


def _biased(flat: Flat, name: str, shapes: dict[str, tuple[int, ...]], times: Times) -> Iterator[Way]:
    """All ways of a linear node's bias, as weights of an event of `RATE` that bring it in the mean."""
    start = added(name, flat.nodes[name], shapes[name])[..., None] / (RATE * times.unit * times.area)
    yield from _followed(flat, [Way(after, start, None, (name,)) for after in flat.after[name]], shapes)


def _followed(flat: Flat, begun: Sequence[Way], shapes: dict[str, tuple[int, ...]]) -> Iterator[Way]:
    """All that ways come to through linear nodes."""
    waiting = list(begun)
    while waiting:
        way = waiting.pop(0)
        node = flat.nodes[way.node]
        if type(node).__name__ in NEURONS or way.node in flat.outputs:
            yield way
            continue
        if way.node in way.before:
            raise ParameterError(f"{way.node}: is in a loop without a neuron, must not be; put one into it")
        signal, tau = _through(way, node)
        if is_linear(node):
            shapes[way.node] = signal.shape[:-1]
        before = (*way.before, way.node)
        waiting += [Way(name, signal, tau, before) for name in flat.after[way.node]]


def _through(way: Way, node: Any) -> tuple[F64, float | None]:
    """Signal and filter behind a node that is no neuron."""
    kind = type(node).__name__
    if kind in ("Input", "Output"):
        return way.signal, way.tau
    if kind != "LI":
        return linear(way.node, node, way.signal), way.tau
    if way.tau is not None:
        raise ParameterError(f"{way.node}: LI, is a second filter in series; leave one out")
    tau = _one_value(way.node, "tau", node.tau)
    scale = np.asarray(node.r, dtype=np.float64) / np.asarray(node.tau, dtype=np.float64)
    flat = way.signal.reshape(-1, way.signal.shape[-1])
    return (np.broadcast_to(scale.ravel(), (flat.shape[0],))[:, None] * flat).reshape(way.signal.shape), tau


def _check_readout(source: str, way: Way) -> None:
    """Raise `ParameterError` for weights between neurons and an output, which no probe has."""
    weights = way.signal.reshape(-1, way.signal.shape[-1])
    if weights.shape[0] != weights.shape[1] or np.any(weights != weights[0, 0] * np.eye(len(weights))):
        raise ParameterError(
            f"{way.before[-1]}: weights from {source} to the output {way.node}, must be none, as an output is"
            f" a population's mean rate; put neurons behind them, or weigh the spikes of {source} yourself"
        )


def _check_alone(source: str, output: str, probes: Sequence[Probe]) -> None:
    """Raise `ParameterError` for an output that has a probe already."""
    others = [probe.population for probe in probes if probe.name == output]
    if others:
        raise ParameterError(
            f"{output}: comes from {others[0]} and {source}, must come once, from one population; give each"
            " way an output of its own"
        )


def _connection(source: str, way: Way, node: Any, size: int, times: Times) -> Connection:
    """The connection of a way: weights as the network has them, and their time constant."""
    weights = way.signal.reshape(-1, way.signal.shape[-1])
    if weights.shape[0] != size:
        raise ParameterError(f"{way.node}: {size} neurons, {weights.shape[0]} entries come; mend the weights")
    r, threshold = (np.asarray(x, dtype=np.float64).ravel() for x in (node.r, node.v_threshold))
    over, tau = times.area * r / (threshold - _rest(node).ravel()), way.tau
    kind = type(node).__name__
    if kind == "IF":
        over = over * SLOW / times.unit
    if kind == "CubaLIF":
        if tau is not None:
            raise ParameterError(f"{way.node}: CubaLIF behind LI, two filters in series; take LIF")
        tau = _one_value(way.node, "tau_syn", node.tau_syn)
        over = over * np.asarray(node.w_in, dtype=np.float64).ravel() / tau
    elif tau is None:
        held = SLOW if kind == "IF" else times.unit * _one_value(way.node, "tau", node.tau)
        tau = max(DIRECT, SHARE * held) / times.unit
        over = over / tau
    matrix = np.broadcast_to(over, (size,))[:, None] * weights
    rows = tuple(map(tuple, matrix.tolist()))
    return Connection(source, way.node, rule="matrix", tau=times.unit * tau, matrix=rows)


def _population(name: str, node: Any, size: int, unit: float) -> Population:
    _check_reset(name, node)
    kind = type(node).__name__
    if kind == "IF":
        return Population(name, size, SLOW, 0.0)
    tau = node.tau_mem if kind == "CubaLIF" else node.tau
    return Population(name, size, unit * _one_value(name, "tau", tau), 0.0)


def _shape(node: Any) -> tuple[int, ...]:
    """Shape of what a node gives, without the axis of a batch of one."""
    shape = tuple(int(n) for n in np.asarray(next(iter(node.output_type.values()))).ravel()) or (1,)
    return shape[1:] if len(shape) > _AXES and shape[0] == 1 else shape


def _size(flat: Flat, name: str, ways: Mapping[str, tuple[Way, ...]]) -> int:
    """How many neurons a node has: of one that states a single number for all, what comes in."""
    size = int(np.prod(_shape(flat.nodes[name])))
    come = [int(np.prod(w.signal.shape[:-1])) for found in ways.values() for w in found if w.node == name]
    return size if size > 1 or not come else come[0]


def _one_value(where: str, name: str, values: Any) -> float:
    found = np.asarray(values, dtype=np.float64)
    low, high = float(found.min()), float(found.max())
    if not 0.0 < low <= high < np.inf:
        wrong = found[~((found > 0.0) & (found < np.inf))].flat[0]
        raise ParameterError(f"{where}.{name}: {wrong:g} s, must be above 0 and finite; mend it")
    if high > low * (1.0 + _ALIKE):
        raise ParameterError(f"{where}.{name}: {low:g} to {high:g} s, must be one; split the node")
    return low if low == high else float(found.mean())


def _rest(node: Any) -> F64:
    """Where its membrane rests; 0 of a neuron that does not leak."""
    return np.asarray(getattr(node, "v_leak", 0.0), dtype=np.float64)


def _check_reset(where: str, node: Any) -> None:
    """Raise `ParameterError` unless a neuron is reset to where it rests, below its threshold."""
    rest, reset = _rest(node), np.asarray(getattr(node, "v_reset", None), dtype=np.float64)
    off = np.broadcast_to(np.nan_to_num(reset) - rest, np.shape(node.v_threshold)).ravel()
    if np.any(off):
        worst = float(off[np.argmax(np.abs(off))])
        raise ParameterError(f"{where}.v_reset: {worst:g} from v_leak, must be v_leak on rolls; set it so")
    if not np.all(np.asarray(node.v_threshold) > rest):
        raise ParameterError(f"{where}.v_threshold: not above v_leak, must be; raise it")


def _check_zero(where: str, node: Any, name: str) -> None:
    value = getattr(node, name, None)
    if value is not None and np.any(np.asarray(value)):
        worst = float(np.abs(np.asarray(value)).max())
        raise ParameterError(
            f"{where}.{name}: up to {worst:g}, must be 0 on rolls; shift threshold and weights"
        )


def _natural(names: tuple[str, ...]) -> list[tuple[int, str]]:
    """By length first, so that `connection10` comes behind `connection9`."""
    return [(len(name), name) for name in names]
