"""Rest states of many copies of a small network of transistors and resistors at once.

Kirchhoff's current law at the unknown nodes is solved by Newton's method with the exact derivatives of the
law that the solver of circuits has (`circuits.devices.transistor`), second-order effects and all. The copies
have the same devices and nodes; they differ in what stands at their switches, in their sizes and deviations
and in the voltages that are given. Bulks stand at given nodes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from circuits.arrays import C128, F64, I32, I64, Bools
from circuits.devices import Device, Resistor, Transistor
from circuits.devices.noise import channel_noise, resistor_noise
from circuits.devices.transistor import (
    TransistorArrays,
    TransistorWork,
    capacitances,
    drain_currents,
    merge_arrays,
    transistor_arrays,
    transistor_work,
)
from circuits.errors import SolverError
from circuits.silicon.process import POLARITIES, kelvin
from circuits.silicon.silicon import Deviation, Silicon

_TOLERANCE = 1e-9  # V, last update of a solve
_LARGEST = 0.2  # V, of a node in one iteration
_ITERATIONS = 600
_KEPT = 256  # networks whose layout is kept
_SHIFT = 1e-5  # V, of a derivative by a given node; ours


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Copies of a network, whose layout is worked out once.

    copies : the devices of each, alike but for the nodes at their gates and their sizes.
    given : names of the nodes whose voltages are given, ground `0` among them.
    """

    copies: Sequence[Sequence[Device]]
    given: Sequence[str]

    def transistors(self) -> list[Transistor]:
        """The transistors of the first copy."""
        return [d for d in self.copies[0] if isinstance(d, Transistor)]

    def of_transistors(self, attribute: str) -> F64:
        """A number of the transistors of all copies, float64[transistors, copies]."""
        each = [[getattr(d, attribute) for d in c if isinstance(d, Transistor)] for c in self.copies]
        return np.array(each, dtype=np.float64).T

    def resistors(self) -> list[Resistor]:
        """The resistors of the first copy, which are those of all."""
        return [d for d in self.copies[0] if isinstance(d, Resistor)]

    def unknown(self) -> list[str]:
        """The nodes that are solved for."""
        return list(_unknown(self))


@dataclass(frozen=True, slots=True, eq=False)
class AtRest:
    """Copies of a network on a die at rest.

    network : the copies.
    deviation : of all transistors: those of the first one in all copies, then those of the next.
    voltages : of their nodes but ground, V, float64[copies] by their names.
    """

    network: Network
    deviation: Deviation
    voltages: Mapping[str, F64]


def rest_state(
    network: Network,
    silicon: Silicon,
    deviation: Deviation,
    given: Mapping[str, F64],
    start: Mapping[str, F64],
) -> dict[str, F64]:  # fmt: skip
    """Voltages of the unknown nodes of all copies, V, float64[copies] each.

    Raises `SolverError` where none are found.

    Parameters
    ----------
    network
        The copies.
    silicon
        Process, temperature and what a die shares.
    deviation
        Of all transistors: those of the first one in all copies, then those of the next.
    given
        Voltages of the given nodes but ground, V, float64[copies].
    start
        A guess of every unknown node, V, float64[copies].
    """
    made = _made(network, silicon, deviation, {**start, **given})
    unknown, n, v = network.unknown(), len(network.unknown()), made.voltages
    for step in _steps(made, n, silicon):
        v[:, :n] -= np.clip(step, -_LARGEST, _LARGEST)
        if np.abs(step).max() < _TOLERANCE:
            break
    return {name: v[:, k].copy() for k, name in enumerate(unknown)}


def rest_states(
    network: Network, silicon: Silicon, deviation: Deviation, given: Mapping[str, F64],
    start: Mapping[str, F64],
) -> dict[str, F64]:  # fmt: skip
    """What `rest_state` gives of each copy by itself, to the last bit, all of them side by side."""
    made = _made(network, silicon, deviation, {**start, **given})
    unknown, n, v = network.unknown(), len(network.unknown()), made.voltages
    going = np.ones(len(network.copies), dtype=np.bool_)
    for step in _steps(made, n, silicon):
        v[going, :n] -= np.clip(step[going], -_LARGEST, _LARGEST)
        going &= ~(np.abs(step).max(axis=1) < _TOLERANCE)
        if not going.any():
            break
    return {name: v[:, k].copy() for k, name in enumerate(unknown)}


def _steps(made: _Made, n: int, silicon: Silicon) -> Iterator[F64]:
    """Newton's steps at the first `n` nodes of all copies, V, float64[copies, n], as their voltages move.

    Raises `SolverError` where they do not end.
    """
    for _ in range(_ITERATIONS):
        residual, whole = made.currents()
        jacobian = whole[:, :, :n]
        scale = np.maximum(np.abs(jacobian).max(axis=2), 1e-300)
        try:
            step = np.linalg.solve(jacobian / scale[:, :, None], (residual / scale)[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            break
        if not np.isfinite(step).all():
            break
        yield step
    raise no_room(silicon)


@dataclass(frozen=True, slots=True)
class Slopes:
    """What moves one node of every copy about its rest state, and the noise that does.

    by_gate : by a voltage at the gate of each transistor, V/V, float64[copies, transistors].
    by_given : by the voltage of a given node, by its name, V/V, float64[copies].
    by_current : by a current through each transistor, then each resistor, V/A, float64[copies, devices].
    sources : white noise of these currents, A^2/Hz, float64[copies, devices].
    resistance : by a current into the node itself, Ohm, float64[copies].
    by_factor : by a relative change of each transistor's current, V, float64[copies, transistors].
    """

    by_gate: F64
    by_given: Mapping[str, F64]
    by_current: F64
    sources: F64
    resistance: F64
    by_factor: F64

    @property
    def white(self) -> F64:
        """Density at the node by white noise, V^2/Hz, float64[copies]."""
        return np.asarray((self.by_current**2 * self.sources).sum(axis=1))


def slopes_at(rest: AtRest, silicon: Silicon, node: str) -> Slopes:
    """Small signals at an unknown node of all copies, by one solve of their transposed networks.

    silicon: process, temperature and what a die shares.
    """
    network, made = rest.network, _made(rest.network, silicon, rest.deviation, rest.voltages)
    _, jacobian = made.currents()
    unknown = network.unknown()
    n, copies = len(unknown), len(network.copies)
    wanted = np.zeros((copies, n, 1))
    wanted[:, unknown.index(node)] = -1.0
    back = np.linalg.solve(jacobian[:, :, :n].transpose(0, 2, 1), wanted)[:, :, 0]
    moved = np.concatenate([back, np.zeros((copies, len(network.given)))], axis=1)  # V/A, out of each node
    at = np.arange(copies)
    channels = (moved[at, made.flow.drain] - moved[at, made.flow.source]).T  # [copies, transistors]
    white = np.empty(made.arrays.sign.size)
    channel_noise(made.arrays, made.work, white)
    column, resistors = _columns(network), network.resistors()
    ends = [(column[i], column[j]) for i, j in (r.terminals() for r in resistors)]
    through = np.array([moved[:, i] - moved[:, j] for i, j in ends]).reshape(-1, copies).T
    thermal = resistor_noise(np.array([r.resistance for r in resistors]), kelvin(silicon.temperature_c))
    slope = made.work.conductance[1].reshape(-1, copies).T
    return Slopes(
        by_gate=channels * slope,
        by_given={
            name: np.asarray((back * jacobian[:, :, n + k]).sum(axis=1))
            for k, name in enumerate(network.given)
        },
        by_current=np.concatenate([channels, through], axis=1),
        sources=np.concatenate(
            [white.reshape(-1, copies).T, np.broadcast_to(thermal, through.shape)], axis=1
        ),
        resistance=np.abs(back[:, unknown.index(node)]),
        by_factor=channels * made.work.current.reshape(-1, copies).T,
    )


def response_at(
    rest: AtRest,
    silicon: Silicon,
    moving: Mapping[str, C128],
    added: Sequence[tuple[str, str, float]],
    frequency: float,
) -> dict[str, C128]:
    """Small signals at the unknown nodes of all copies where given nodes move at a frequency, V.

    They are those of `(G + j 2 pi f C) v = -(G_s + j 2 pi f C_s) s`, with the capacitances of the
    transistors.

    Parameters
    ----------
    rest
        The copies at rest.
    silicon
        Process, temperature and what a die shares.
    moving
        Given nodes that move, and by how much, V, complex128[copies].
    added
        Capacitors besides the transistors' own: two nodes, and F.
    frequency
        Hz.
    """
    network, made = rest.network, _made(rest.network, silicon, rest.deviation, rest.voltages)
    column = _columns(network)
    unknown, omega = network.unknown(), 2.0 * np.pi * frequency
    n = len(unknown)
    charge = _charge(network, silicon, column, added)
    driven = np.zeros((len(network.copies), n), dtype=np.complex128)
    for name, by in moving.items():
        k = column[name]
        driven += (made.by_node(k) + 1j * omega * charge[:, :n, k]) * by[:, None]
    whole = made.currents()[1][:, :, :n] + 1j * omega * charge[:, :n, :n]
    found = np.linalg.solve(whole, -driven[:, :, None])[:, :, 0]
    return {name: np.asarray(found[:, k], dtype=np.complex128) for k, name in enumerate(unknown)}


@dataclass(frozen=True, slots=True)
class _Made:
    """Copies of a network with their numbers on a silicon, and the voltages of their nodes, V."""

    arrays: TransistorArrays
    work: TransistorWork
    flow: _Flow
    voltages: F64  # [copies, nodes], the unknown ones first

    def currents(self) -> tuple[F64, F64]:
        """Currents that leave the unknown nodes, A, and their derivatives by all nodes, S."""
        drain_currents(self.arrays, self.voltages.ravel(), self.work)
        return self.flow.currents(self.voltages, self.work)

    def by_node(self, column: int) -> F64:
        """Derivatives of the unknown nodes' currents by a node, at which bulks may stand, S."""
        ends = []
        for move in (_SHIFT, -_SHIFT):
            there = self.voltages.copy()
            there[:, column] += move
            ends.append(replace(self, voltages=there).currents()[0].copy())
        return np.asarray((ends[0] - ends[1]) / (2.0 * _SHIFT))


def _charge(
    network: Network, silicon: Silicon, column: Mapping[str, int], added: Sequence[tuple[str, str, float]]
) -> F64:
    """Capacitances between the nodes of each copy, F, float64[copies, nodes, nodes]."""
    found, at = np.zeros((len(network.copies), len(column), len(column))), np.arange(len(network.copies))

    def add(first: I64, second: I64, farad: F64) -> None:
        for i, j in ((first, second), (second, first)):
            found[at, i, i] += farad
            found[at, i, j] -= farad

    sizes = zip(*(network.of_transistors(name) for name in ("width", "length", "multiplicity")), strict=True)
    alike = zip(*([d for d in c if isinstance(d, Transistor)] for c in network.copies), strict=True)
    for copies, size in zip(alike, sizes, strict=True):
        nodes = np.array([[column[n] for n in d.terminals()] for d in copies]).T
        own = capacitances(silicon.process.model(copies[0].polarity), *size)
        for (a, b), farad in own.items():
            add(nodes[a], nodes[b], farad)
    for first, second, farads in added:
        add(np.full(at.size, column[first]), np.full(at.size, column[second]), np.full(at.size, farads))
    return found


@lru_cache(maxsize=_KEPT)
def _unknown(network: Network) -> tuple[str, ...]:
    nodes = dict.fromkeys(node for device in network.copies[0] for node in device.terminals())
    return tuple(node for node in nodes if node not in network.given)


@lru_cache(maxsize=_KEPT)
def _columns(network: Network) -> Mapping[str, int]:
    """Place of each node among the voltages of a copy, the unknown ones first."""
    return {name: k for k, name in enumerate([*_unknown(network), *network.given])}


class _Layout(NamedTuple):
    """What is of a network whatever the die.

    at : nodes of the terminals of each copy's first transistor, then each copy's next one, int32[4, count].
    is_n : whether each is an nFET. sizes : width, length (m) and multiplicity of each.
    """

    flow: _Flow
    at: I32
    is_n: Bools
    sizes: tuple[F64, F64, F64]


@lru_cache(maxsize=_KEPT)
def _layout(network: Network) -> _Layout:
    column, copies = _columns(network), len(network.copies)
    terminals = np.array(
        [[[column[n] for n in d.terminals()] for d in copy if isinstance(d, Transistor)]
         for copy in network.copies]
    )  # fmt: skip
    flow = _Flow(terminals, len(_unknown(network)), _conductance(network, column))
    apart = terminals + len(column) * np.arange(copies)[:, None, None]
    width, length, multiplicity = (
        network.of_transistors(name).ravel() for name in ("width", "length", "multiplicity")
    )
    return _Layout(
        flow,
        apart.transpose(2, 1, 0).reshape(4, -1).astype(np.int32),
        np.repeat([d.polarity == "n" for d in network.transistors()], copies),
        (width, length, multiplicity),
    )


def _made(network: Network, silicon: Silicon, deviation: Deviation, voltages: Mapping[str, F64]) -> _Made:
    column, layout = _columns(network), _layout(network)
    v = np.zeros((len(network.copies), len(column)))
    for name, value in voltages.items():
        v[:, column[name]] = value
    arrays = _arrays(network, layout, silicon, deviation)
    return _Made(arrays, transistor_work(arrays.sign.size), layout.flow, v)


def no_room(silicon: Silicon) -> SolverError:
    """The error of a generator whose supply is too low for it."""
    return SolverError(
        f"bias generator: no operating point at {silicon.process.v_dd:g} V and"
        f" {silicon.temperature_c:g} degC; give a higher supply"
    )


def _arrays(network: Network, layout: _Layout, silicon: Silicon, deviation: Deviation) -> TransistorArrays:
    """Coefficients of the transistors: each copy's first one, then each copy's next one."""
    for device in network.transistors():
        size = silicon.process.model(device.polarity).size
        if size is not None:
            size.check(device.width, device.length, f"bias generator.{device.name}")
    each = {p: transistor_arrays(layout.at, p, silicon.law(p), *layout.sizes, *deviation) for p in POLARITIES}
    return merge_arrays(layout.is_n, each["n"], each["p"])


def _conductance(network: Network, column: Mapping[str, int]) -> F64:
    """Conductances between the nodes of a copy, S, float64[nodes, nodes]."""
    matrix = np.zeros((len(column), len(column)))
    for device in network.copies[0]:
        if isinstance(device, Resistor):
            i, j = (column[node] for node in device.terminals())
            matrix[[i, j], [i, j]] += 1.0 / device.resistance
            matrix[[i, j], [j, i]] -= 1.0 / device.resistance
    return matrix


class _Flow:
    """Where the currents of the transistors and their slopes go, once for all iterations."""

    def __init__(self, terminals: I64, unknown: int, conductance: F64) -> None:
        self.unknown, self.conductance = unknown, conductance
        self.copies, self.nodes = len(terminals), len(conductance)
        drain, gate, source, _ = terminals.transpose(2, 1, 0)  # [devices, copies] each
        self.drain, self.source = drain, source
        self.row = [self._at(drain), self._at(source)]
        self.entry = {
            (i, j): (self._at(a) * self.nodes + b).ravel()
            for i, a in (("d", drain), ("s", source))
            for j, b in (("d", drain), ("g", gate), ("s", source))
        }

    def _at(self, node: I64) -> I64:
        return np.asarray(np.arange(self.copies) * self.nodes + node)

    def currents(self, v: F64, w: TransistorWork) -> tuple[F64, F64]:
        """Currents that leave the unknown nodes, A, [copies, unknown], and their derivatives by all, S."""
        n, size = self.unknown, self.copies * self.nodes
        residual = v @ self.conductance
        slopes: list[tuple[str, str, F64]] = []
        for row, end, sign in ((self.row[0], "d", 1.0), (self.row[1], "s", -1.0)):
            side = "ds".index(end)
            leaving = sign * w.current + w.junction[side]
            slopes += [(end, to, sign * w.conductance[k]) for k, to in enumerate("dgs")]
            slopes.append((end, end, w.junction_conductance[side]))
            slopes.append((end, "g", w.junction_conductance[2 + side]))
            residual += np.bincount(row.ravel(), leaving, size).reshape(self.copies, self.nodes)
        jacobian = np.zeros(size * self.nodes)
        for end, to, slope in slopes:
            jacobian += np.bincount(self.entry[end, to], slope, jacobian.size)
        square = jacobian.reshape(self.copies, self.nodes, self.nodes) + self.conductance
        return residual[:, :n], square[:, :n]
