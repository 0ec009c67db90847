"""A testbench as arrays for the solver.

The unknowns are the voltages of all nodes that no source fixes. The solver's vector of voltages is `[unknown
nodes in the order of elimination | values of the sources | 0 (ground)]`; the value of a current source is a
column that adds itself to the current of its node. Kirchhoff's current law at the unknown nodes is

    d/dt (C v) + G v + i(v) = 0,     a current that leaves a node being positive

with the capacitances C, the linear conductances G, and the currents i(v) of transistors, diodes and
amplifiers. Every device type registers a function that adds its part.

A diode's charge q bends with its voltage. It is an unknown of its own, 1 V for 1 C, that stands before the
nodes, with the equation `q - q(v) = 0` and 1 F to either end of the diode: C stays constant, charge is
conserved, and what is made of G, C and i(v) holds for it as for a node.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, singledispatch
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I32, I64, U32, Bools
from circuits.bias import bias_voltages
from circuits.circuit import Shape
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode, DiodeArrays, diode_arrays, stores_charge
from circuits.devices.source import Constant, Polyline, Sampled, polyline
from circuits.devices.transistor import TransistorArrays, capacitances, merge_arrays, transistor_arrays
from circuits.errors import TopologyError
from circuits.lowering.check import check_flat, check_supplies
from circuits.lowering.factor import Factor, elimination_order, factor_program
from circuits.lowering.flatten import DeviceGroup, FlatCircuit, flatten
from circuits.lowering.made import made
from circuits.silicon.die import Die, Path
from circuits.silicon.passive import deviates
from circuits.silicon.process import POLARITIES, Polarity
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

Triplets = tuple[I64, I64, F64]


class Rows(NamedTuple):
    """A sparse matrix, stored by the rows of the unknown nodes, over all columns of the voltage vector."""

    start: I32
    column: I32
    value: F64
    entry: I32  # position in the Jacobian, -1 for a column that is no unknown


class Stamps(NamedTuple):
    """Where the currents and slopes of nonlinear devices are added to residual and Jacobian.

    `f[row] += sign i[source]` and `J[entry] += sign g[source]`.
    """

    row: U32
    current: U32
    current_sign: F64
    entry: U32
    slope: U32
    slope_sign: F64


class Kernel(NamedTuple):
    """A circuit as arrays: `unknowns` nodes are solved for, and the voltage vector has `columns` entries."""

    unknowns: int
    columns: int
    transistors: TransistorArrays
    amplifier_terminal: I32  # [5, n]
    amplifier_value: F64  # [3, n]
    charge: Rows  # C, F
    conductance: Rows  # G, S
    stamps: Stamps
    factor: Factor
    dynamic: Bools  # [unknowns] whether the node has capacitance
    diodes: DiodeArrays
    charges: int  # how many unknowns, the first ones, are charges of diodes
    curvature: float  # V: scale over which the law bends, 2 U_T, or an amplifier's linear range


class Sources(NamedTuple):
    """The polylines of all sources, one behind the other."""

    start: I64  # [sources + 1]
    time: F64
    value: F64
    sampled: Bools  # [sources] whether the vertices are samples to follow, not breakpoints


@dataclass(frozen=True, slots=True)
class Machine:
    """A testbench on its silicon, ready for the solver, with the way back from arrays to names.

    Attributes
    ----------
    testbench, silicon : Testbench, Silicon
        What was lowered, and what it is made on.
    flat : FlatCircuit
        The circuit without its hierarchy.
    kernel : Kernel
        The circuit as the solver's arrays.
    polylines : tuple of (array, array)
        Times (s) and values (V or A) of each source, float64[T] each.
    sampled : tuple of bool
        Whether the points of a source are samples to follow, not corners to stop at.
    source_names, source_quantities : tuple of str
        Name of each source, and whether it is a `voltage` or a `current`.
    direct : tuple of float or None
        What each source gives to an analysis without time, V or A; None for its value at 0 s.
    source_charge, source_conductance : triplets
        C (F) and G (S) at the sources' own nodes: rows and columns of the voltage vector.
    column : array
        Position of each node in the voltage vector, int64[nodes].
    names : tuple of str
        Path of each node.
    """

    testbench: Testbench
    silicon: Silicon
    flat: FlatCircuit
    kernel: Kernel
    polylines: tuple[Polyline, ...]
    sampled: tuple[bool, ...]
    source_names: tuple[str, ...]
    source_quantities: tuple[str, ...]
    direct: tuple[float | None, ...]
    source_charge: Triplets
    source_conductance: Triplets
    column: I64
    names: tuple[str, ...] = field(repr=False)

    def column_of(self, node: str) -> int:
        """Position of the node at the path `node` in the voltage vector.

        Raises `UnknownNameError` where there is no such node.
        """
        return int(self.column[self.flat.node(node)])

    def sources(self) -> Sources:
        """The polylines of the sources in the solver's form."""
        return pack_sources(self.polylines, self.sampled)

    def given(self, source: int) -> float:
        """Value of a source in an analysis without time, V or A.

        source: its number among `source_names`.
        """
        direct = self.direct[source]
        return float(np.interp(0.0, *self.polylines[source])) if direct is None else direct


@dataclass(slots=True)
class _Parts:
    """What the device types add while the circuit is lowered; rows and columns are node columns."""

    silicon: Silicon
    circuit: str  # name of the whole circuit
    column: I64
    amplifier_terminal: list[I64] = field(default_factory=list)
    amplifier_value: list[F64] = field(default_factory=list)
    charge: list[Triplets] = field(default_factory=list)
    conductance: list[Triplets] = field(default_factory=list)
    charges: int = 0  # charges of diodes that have a column so far


def to_kernel(
    testbench: Testbench, silicon: Silicon | None = None, hold: Mapping[str, float] | None = None
) -> Machine:
    """Turn a testbench on its silicon into the solver's arrays.

    Raises `TopologyError` for a circuit that cannot be solved: a gate that floats, a node without a path for
    direct current, or two sources on one node.

    Parameters
    ----------
    testbench
        The testbench.
    silicon
        Process, temperature and die; the nominal process at 27 degC unless given.
    hold
        Voltages (V), by path, of nodes that no source fixes and that are held as if one did.
    """
    silicon = silicon or Silicon()
    flat = flatten(testbench.circuit)
    sources = complete_sources(testbench, flat, silicon)
    fixed = check_supplies(flat, sources)
    for path, voltage in (hold or {}).items():
        fixed.append((flat.node(path), len(sources)))
        sources.append(Source(f"hold {path}", path, Constant(voltage)))
    check_flat(flat, [n for n, _ in fixed])
    free = np.setdiff1d(np.arange(1, flat.count), [n for n, _ in fixed])
    order = _order(flat, free)
    column = np.full(flat.count, -1, dtype=np.int64)
    charges = sum(int(stores_charge(g.parameters).sum()) for g in _diodes(flat))
    column[order] = np.arange(charges, charges + order.size)
    unknowns = charges + order.size
    columns = unknowns + len(sources) + 1
    column[0] = columns - 1
    for number, k in fixed:
        column[number] = unknowns + k
    parts = _Parts(silicon, flat.circuit.name, column)
    for group in flat.groups:
        add_device(group.device, group, parts)
    parts.conductance += _current_sources(sources, flat, column, unknowns)
    lines = tuple(polyline(f"{testbench.title}.{s.name}", s.waveform) for s in sources)
    sampled = tuple(isinstance(s.waveform, Sampled) for s in sources)
    return Machine(
        testbench, silicon, flat, _assemble(flat, parts, unknowns, columns), lines, sampled,
        tuple(s.name for s in sources), tuple(s.quantity for s in sources), tuple(s.direct for s in sources),
        _merge(parts.charge, unknowns, columns), _merge(parts.conductance, unknowns, columns), column,
        tuple(flat.node_names()),
    )  # fmt: skip


def _current_sources(
    sources: Iterable[Source], flat: FlatCircuit, column: I64, unknowns: int
) -> Iterable[Triplets]:
    """What current sources add to the conductances: their values' columns, in the rows of their nodes."""
    for k, source in enumerate(sources):
        if source.quantity == "current":
            node = column[flat.port_nodes(source.node)]
            yield node, np.full_like(node, unknowns + k), np.full(node.size, -1.0)


def complete_sources(testbench: Testbench, flat: FlatCircuit, silicon: Silicon) -> list[Source]:
    """The sources of a testbench, and one more for each element of a bias port that none of them drives."""
    return [*testbench.sources, *_bias_sources(testbench, flat, silicon)]


def _bias_sources(testbench: Testbench, flat: FlatCircuit, silicon: Silicon) -> Iterable[Source]:
    driven = {int(n) for s in testbench.sources for n in flat.port_nodes(s.node)}
    for bias in testbench.circuit.biases:
        voltages = bias_voltages(testbench.circuit, bias, silicon)
        shape: Shape = voltages.shape
        for index in np.ndindex(shape):
            element = bias.port + (f"[{','.join(map(str, index))}]" if shape else "")
            if int(flat.port_nodes(element)[0]) not in driven:
                yield Source(element, element, Constant(float(voltages[index])))


def on_die(machine: Machine, die: Die) -> Machine:
    """The same machine on another die, without the work of lowering its testbench again.

    Equal to lowering the testbench on that die: a die changes the transistors' and diodes' coefficients, the
    values of capacitors and resistors where they deviate, and the voltages of biases that stand on it.
    """
    return on_silicon(machine, replace(machine.silicon, die=die))


def on_silicon(machine: Machine, silicon: Silicon) -> Machine:
    """The same machine on another silicon, as `on_die`: another process or temperature changes the same."""
    before, die = machine.silicon, silicon.die
    other = replace(before, die=die) != silicon
    kernel = machine.kernel._replace(
        transistors=_transistor_table(machine.flat, machine.column, silicon),
        diodes=_diode_table(machine.flat, machine.column, silicon),
    )
    top = ((machine.flat.circuit.name, ()),) if silicon.place is None else silicon.place
    if other or deviates(die, top) or deviates(before.die, top):
        machine, kernel = _with_passives(machine, kernel, silicon)
    lines = machine.polylines
    if any(other or bias.kind in {"ideal", "generator"} for bias in machine.testbench.circuit.biases):
        given = len(machine.testbench.sources)
        biases = _bias_sources(machine.testbench, machine.flat, silicon)
        title = machine.testbench.title
        lines = (*lines[:given], *(polyline(f"{title}.{s.name}", s.waveform) for s in biases))
    return replace(machine, silicon=silicon, kernel=kernel, polylines=lines)


def _with_passives(machine: Machine, kernel: Kernel, silicon: Silicon) -> tuple[Machine, Kernel]:
    """The machine and its kernel with the capacitances and resistances of a silicon; no pattern changes."""
    parts = _Parts(silicon, machine.flat.circuit.name, machine.column)
    for group in machine.flat.groups:
        add_device(group.device, group, parts)
    sources = machine.testbench.sources
    parts.conductance += _current_sources(sources, machine.flat, machine.column, kernel.unknowns)
    n, columns = kernel.unknowns, kernel.columns
    charge, conductance = (_merge(m, 0, n)[2] for m in (parts.charge, parts.conductance))
    kernel = kernel._replace(
        charge=kernel.charge._replace(value=charge),
        conductance=kernel.conductance._replace(value=conductance),
    )
    outside = [_merge(m, n, columns) for m in (parts.charge, parts.conductance)]
    return replace(machine, source_charge=outside[0], source_conductance=outside[1]), kernel


def pack_sources(lines: tuple[Polyline, ...], sampled: tuple[bool, ...]) -> Sources:
    """Polylines of sources in the solver's form.

    sampled: for each source, whether its points are samples to follow, and not bends to restart at.
    """
    start = np.array([0, *accumulate(t.size for t, _ in lines)], dtype=np.int64)
    time = np.concatenate([t for t, _ in lines]) if lines else np.zeros(0)
    value = np.concatenate([v for _, v in lines]) if lines else np.zeros(0)
    return Sources(start, time, value, np.array(sampled, dtype=np.bool_))


def _transistor_table(flat: FlatCircuit, column: I64, silicon: Silicon) -> TransistorArrays:
    """Coefficients of all transistors in the order of the groups, each with its deviation on the die."""
    terminal = np.concatenate(
        [np.zeros((4, 0), np.int64), *(column[g.nodes] for g, _ in _transistor_groups(flat))], axis=1
    )
    paths, polarities, is_n, (width, length, multiplicity) = transistors_of(flat)
    for path, polarity, (group, _) in zip(paths, polarities, _transistor_groups(flat), strict=True):
        size = silicon.process.model(polarity).size
        if size is not None:
            owner = ".".join(name for name, _ in path)
            size.check(group.parameters["width"], group.parameters["length"], owner)
    area = width * length * multiplicity
    v_t0, beta = silicon.deviations(flat.circuit.name, paths, area, polarities)
    arrays = {
        polarity: transistor_arrays(
            terminal.astype(np.int32),
            polarity,
            silicon.law(polarity),
            width,
            length,
            multiplicity,
            v_t0,
            beta,
        )
        for polarity in POLARITIES
    }
    return merge_arrays(is_n, arrays["n"], arrays["p"])


def _diodes(flat: FlatCircuit) -> list[DeviceGroup]:
    return [g for g in flat.groups if isinstance(g.device, Diode)]


def _diode_table(flat: FlatCircuit, column: I64, silicon: Silicon) -> DiodeArrays:
    """Coefficients of all diodes in the order of the groups; the first unknowns are their charges."""
    groups = _diodes(flat)
    terminal = np.concatenate([np.zeros((2, 0), np.int64), *(column[g.nodes] for g in groups)], axis=1)
    parameters = diode_figures(flat, silicon)
    stores = stores_charge(parameters)
    charge = np.where(stores, np.cumsum(stores) - 1, -1)
    return diode_arrays(terminal, charge, parameters, silicon.temperature_c)


def diode_figures(flat: FlatCircuit, silicon: Silicon) -> dict[str, F64]:
    """Figures of all diodes on the silicon's die by name, float64[diodes], in the order of the kernel."""
    groups = _diodes(flat)
    names = groups[0].parameters if groups else Diode("d", "a", "c").parameters()
    found = {n: np.concatenate([np.zeros(0), *(g.parameters[n] for g in groups)]) for n in names}
    on_the_die = [made(g, flat.circuit.name, silicon) for g in groups]
    return found | {"saturation_current": np.concatenate([np.zeros(0), *on_the_die])}


def _transistor_groups(flat: FlatCircuit) -> list[tuple[DeviceGroup, Transistor]]:
    return [(g, g.device) for g in flat.groups if isinstance(g.device, Transistor)]


class TransistorsOf(NamedTuple):
    """The transistors of a circuit in the order of the kernel.

    paths, polarities: of each group of them. is_n: bool[n]. sizes: width (m), length (m) and multiplicity,
    float64[n] each.
    """

    paths: list[Path]
    polarities: list[Polarity]
    is_n: Bools
    sizes: tuple[F64, F64, F64]


def transistors_of(flat: FlatCircuit) -> TransistorsOf:
    """The transistors of a circuit in the order of the kernel."""
    groups = _transistor_groups(flat)
    width, length, multiplicity = (
        np.concatenate([np.zeros(0), *(g.parameters[k] for g, _ in groups)])
        for k in ("width", "length", "multiplicity")
    )
    is_n = np.concatenate(
        [np.zeros(0, np.bool_), *(np.full(g.nodes.shape[1], d.polarity == "n") for g, d in groups)]
    )
    paths = [(*g.path, (d.name, ())) for g, d in groups]
    return TransistorsOf(paths, [d.polarity for _, d in groups], is_n, (width, length, multiplicity))


@singledispatch
def add_device(device: Device, group: DeviceGroup, parts: _Parts) -> None:
    """Add a group of devices to what the kernel is made of; every device type registers its function."""
    raise TypeError(f"{type(device).__name__}: no lowering to the kernel")


@add_device.register
def _(device: Transistor, group: DeviceGroup, parts: _Parts) -> None:
    """Add the capacitances; the currents' coefficients are laid out for all transistors at once."""
    model = parts.silicon.process.model(device.polarity)
    width, length, multiplicity = (group.parameters[k] for k in ("width", "length", "multiplicity"))
    terminal = parts.column[group.nodes]
    for (i, j), value in capacitances(model, width, length, multiplicity).items():
        _two_terminal(parts.charge, terminal[i], terminal[j], value)


@add_device.register
def _(device: Capacitor, group: DeviceGroup, parts: _Parts) -> None:
    a, b = parts.column[group.nodes]
    _two_terminal(parts.charge, a, b, made(group, parts.circuit, parts.silicon))


@add_device.register
def _(device: Resistor, group: DeviceGroup, parts: _Parts) -> None:
    a, b = parts.column[group.nodes]
    _two_terminal(parts.conductance, a, b, 1.0 / made(group, parts.circuit, parts.silicon))


@add_device.register
def _(device: ControlledSource, group: DeviceGroup, parts: _Parts) -> None:
    positive, negative, high, low = parts.column[group.nodes]
    g = group.parameters["transconductance"]
    for row, sign in ((positive, 1.0), (negative, -1.0)):
        parts.conductance.append((row, high, sign * g))
        parts.conductance.append((row, low, -sign * g))


@add_device.register
def _(device: Diode, group: DeviceGroup, parts: _Parts) -> None:
    """Add the charge, an unknown of its own; the currents are laid out for all diodes at once."""
    a, c = parts.column[group.nodes[:, stores_charge(group.parameters)]]
    own, one = np.arange(parts.charges, parts.charges + a.size), np.ones(a.size)
    parts.charges += a.size
    parts.charge += [(a, own, one), (c, own, -one)]
    parts.conductance.append((own, own, one))


@add_device.register
def _(device: OperationalAmplifier, group: DeviceGroup, parts: _Parts) -> None:
    parts.amplifier_terminal.append(parts.column[group.nodes])
    parts.amplifier_value.append(
        np.array([group.parameters[k] for k in ("gain", "output_resistance", "offset")])
    )


@add_device.register
def _(device: Source, group: DeviceGroup, parts: _Parts) -> None:
    raise TopologyError(f"{group.label(0)}: a source stands in a circuit; put it in the testbench")


def _two_terminal(into: list[Triplets], a: I64, b: I64, value: F64) -> None:
    into += [(a, a, value), (b, b, value), (a, b, -value), (b, a, -value)]


def _order(flat: FlatCircuit, free: I64) -> I64:
    """Free nodes in elimination order."""
    local = np.full(flat.count, -1, dtype=np.int64)
    local[free] = np.arange(free.size)
    pairs = []
    for group in flat.groups:
        nodes = local[group.nodes]
        terminals = len(nodes)
        pairs.append((np.repeat(nodes, terminals, axis=0).ravel(), np.tile(nodes, (terminals, 1)).ravel()))
    if free.size < 2 or not pairs:
        return free
    rows, columns = (np.concatenate(part) for part in zip(*pairs, strict=True))
    keep = (rows >= 0) & (columns >= 0)
    order = elimination_order(free.size, rows[keep], columns[keep])
    rank = _rank(flat, local, free.size)
    return free[order if rank is None else order[np.argsort(rank[order], kind="stable")]]


def _rank(flat: FlatCircuit, local: I64, count: int) -> I64 | None:
    """Which unknown nodes are eliminated early: 0 by an entry of their own, 1 by a source's, 2 without one.

    None where no sources are controlled. A node that only controlled sources are at has no entry on the
    diagonal, or a small one, until its neighbours are eliminated.
    """
    sources = [g for g in flat.groups if isinstance(g.device, ControlledSource)]
    if not sources:
        return None
    rank = np.full(count + 1, 2, dtype=np.int64)  # the last takes what is no unknown
    for group in sources:
        nodes = local[group.nodes]
        own = (nodes[0] == nodes[2]) & (nodes[1] == nodes[3])
        rank[nodes[:2, own]] = 1
    for group in flat.groups:
        if not isinstance(group.device, ControlledSource):
            rank[local[group.nodes]] = 0
    return rank[:count]


def _assemble(flat: FlatCircuit, parts: _Parts, unknowns: int, columns: int) -> Kernel:
    transistors = _transistor_table(flat, parts.column, parts.silicon)
    terminal = np.concatenate([np.zeros((5, 0), np.int64), *parts.amplifier_terminal], axis=1).astype(
        np.int32
    )
    value = np.concatenate([np.zeros((3, 0)), *parts.amplifier_value], axis=1)
    diodes = _diode_table(flat, parts.column, parts.silicon)
    charge, conductance = (_merge(m, 0, unknowns) for m in (parts.charge, parts.conductance))
    places = transistors.terminal, terminal, diodes.terminal, diodes.charge, *charge[:2], *conductance[:2]
    second_order = transistors.leaks, transistors.induces
    pattern = _pattern(unknowns, second_order, *(each.astype(np.int64).tobytes() for each in places))
    dynamic = np.zeros(unknowns, dtype=np.bool_)
    dynamic[charge[0][(charge[2] > 0.0) & (charge[0] == charge[1])]] = True
    ends = diodes.terminal[:, diodes.charge >= 0]
    dynamic[ends[ends < unknowns]] = True
    curvature = 2.0 * parts.silicon.thermal_voltage
    if value.shape[1]:
        curvature = min(curvature, float(parts.silicon.process.v_dd / value[0].max()))
    curvature = min(curvature, 2.0 * float(np.min([diodes.slope, diodes.breakdown_slope], initial=np.inf)))
    return Kernel(
        unknowns, columns, transistors, terminal, value, _rows(charge, unknowns, pattern.charge),
        _rows(conductance, unknowns, pattern.conductance), pattern.stamps, pattern.factor, dynamic, diodes,
        parts.charges, curvature,
    )  # fmt: skip


class _Pattern(NamedTuple):
    """What follows from the nodes of a circuit's devices, whatever their values.

    charge, conductance: positions of a matrix's entries in the Jacobian, as of `Rows`.
    """

    stamps: Stamps
    factor: Factor
    charge: I32
    conductance: I32


@lru_cache(maxsize=32)
def _pattern(unknowns: int, second_order: tuple[bool, bool], *places: bytes) -> _Pattern:
    """Lay out the Jacobian once for all circuits of the same nodes, whatever their sizes, die and process.

    second_order: as of `_stamps`. places: terminals of transistors, amplifiers and diodes, columns of the
    diodes' charges, and rows and columns of the charges and of the conductances, as bytes of int64.
    """
    columns = [np.frombuffer(each, np.int64) for each in places]
    nodes = [each.reshape(terminals, -1) for terminals, each in zip((4, 5, 2), columns[:3], strict=True)]
    stamped = _stamps(second_order, nodes, columns[3], unknowns)
    nonlinear = list(zip(stamped[3].tolist(), stamped[4].tolist(), strict=True))
    linear = [list(zip(r.tolist(), c.tolist(), strict=True)) for r, c in (columns[4:6], columns[6:])]
    inside = ((r, c) for each in linear for r, c in each if c < unknowns)
    factor, position = factor_program(unknowns, {*nonlinear, *inside})
    entry, charge, conductance = (
        np.array([position.get(each, -1) for each in entries], dtype=np.int32)
        for entries in (nonlinear, *linear)
    )
    stamps = Stamps(*stamped[:3], entry.astype(np.uint32), *stamped[5:])
    return _Pattern(stamps, factor, charge, conductance)


def _stamps(
    second_order: tuple[bool, bool], nodes: Sequence[I64], charge: I64, unknowns: int
) -> tuple[U32, U32, F64, I64, I64, U32, F64]:
    """Residual (row, current, sign) and Jacobian (row, column, slope, sign) entries of nonlinear devices.

    second_order: whether transistors leak, and whether the gate induces leakage. nodes: of transistors,
    amplifiers and diodes. charge: column of each diode's.
    Currents are laid out [drain n | junction 2n | amplifier 5m | diode d | charge d], slopes [transistor 3n |
    junction 2n | junction by gate 2n | amplifier 25m | diode d | charge d].
    """
    (leaks, induces), (transistor, amplifier, diode) = second_order, nodes
    n, m = transistor.shape[1], amplifier.shape[1]
    residual: list[tuple[int, int, float]] = []
    jacobian: list[tuple[int, int, int, float]] = []

    def flow(row: int, sign: float, current: int, slopes: list[tuple[int, int, float]]) -> None:
        if row < unknowns:
            residual.append((row, current, sign))
            jacobian.extend((row, c, k, sign * s) for c, k, s in slopes if c < unknowns)

    for i in range(n):
        d, g, s, b = transistor[:, i].tolist()
        slopes = [(d, i, 1.0), (g, n + i, 1.0), (s, 2 * n + i, 1.0)]
        slopes += [(b, k * n + i, -1.0) for k in range(3)]
        flow(d, 1.0, i, slopes)
        flow(s, -1.0, i, slopes)
        for side, node in enumerate((d, s) if leaks else ()):
            own, by_gate = 3 * n + side * n + i, 5 * n + side * n + i
            leak = [(node, own, 1.0), (b, own, -1.0)]
            leak += [(g, by_gate, 1.0), (b, by_gate, -1.0)] if induces else []
            flow(node, 1.0, n + side * n + i, leak)
            flow(b, -1.0, n + side * n + i, leak)
    for k in range(m):
        at = amplifier[:, k].tolist()
        for i in (2, 3, 4):
            flow(
                at[i],
                1.0,
                3 * n + i * m + k,
                [(at[j], 7 * n + (i * 5 + j) * m + k, 1.0) for j in range(5)],
            )
    count = diode.shape[1]
    for k in range(count):
        (a, c), own = diode[:, k].tolist(), int(charge[k])
        i, g = 3 * n + 5 * m + k, 7 * n + 25 * m + k
        flow(a, 1.0, i, [(a, g, 1.0), (c, g, -1.0)])
        flow(c, -1.0, i, [(a, g, 1.0), (c, g, -1.0)])
        if own >= 0:
            flow(own, -1.0, i + count, [(a, g + count, 1.0), (c, g + count, -1.0)])
    r = np.array(residual, dtype=np.float64).reshape(-1, 3)
    j = np.array(jacobian, dtype=np.float64).reshape(-1, 4)
    return (
        r[:, 0].astype(np.uint32), r[:, 1].astype(np.uint32), r[:, 2].copy(), j[:, 0].astype(np.int64),
        j[:, 1].astype(np.int64), j[:, 2].astype(np.uint32), j[:, 3].copy(),
    )  # fmt: skip


def _merge(triplets: list[Triplets], first: int, stop: int) -> Triplets:
    """Sum equal (row, column) pairs of rows first to stop, sorted."""
    nothing: Triplets = (np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))
    rows, columns, values = (np.concatenate(part) for part in zip(nothing, *triplets, strict=True))
    keep = (rows >= first) & (rows < stop)
    rows, columns, values = rows[keep], columns[keep], values[keep]
    wide = int(columns.max(initial=0)) + 1
    keys, inverse = np.unique(rows * wide + columns, return_inverse=True)
    sums = np.bincount(inverse, weights=values, minlength=keys.size).astype(np.float64)
    return keys // wide, keys % wide, sums


def _rows(merged: Triplets, unknowns: int, entry: I32) -> Rows:
    rows, columns, values = merged
    start = np.searchsorted(rows, np.arange(unknowns + 1)).astype(np.int32)
    return Rows(start, columns.astype(np.int32), values, entry)
